// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Geometry>
#include <cstdint>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "render/pictures/run_view.h"
#include "render/surface/bone_surface.h"
#include "sim/base/error.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scan/ct_import.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// Text escaped for HTML, between tags and in quoted attributes.
std::string escape_html(std::string_view text);

/// Bytes in base 64 (RFC 4648, padded).
std::string base64(std::span<const std::uint8_t> bytes);

/// Bytes compressed by zlib (RFC 1950), in base 64.
std::string compressed_base64(std::span<const std::uint8_t> bytes);

/// JSON escaped for an element `script`: it cannot end the element or open a comment. Invalid UTF-8 is replaced.
std::string json_for_script(const nlohmann::ordered_json& json);

/// A value rounded to six significant digits, for short JSON.
double short_number(double value);

/// x, y, z with six significant digits.
template <class Vector>
nlohmann::ordered_json vector_json(const Vector& v) {
  return {short_number(v.x()), short_number(v.y()), short_number(v.z())};
}
/// Lower and upper corner of a box.
template <class Vector>
nlohmann::ordered_json box_json(const Vector& low, const Vector& high) {
  return nlohmann::ordered_json::array({vector_json(low), vector_json(high)});
}

using PageTexts = std::map<std::string, std::string>;

/// The pages of dist/, which build.mjs makes.
namespace embedded {
extern const char* const report_page;
extern const char* const preview_page;
extern const char* const study_page;
}  // namespace embedded

/// One of these pages as one HTML file that loads nothing: with its title, the name of the program, the data of its
/// scripts, and the `texts` (HTML) that it has other names for.
std::string self_contained_page(const char* page, const std::string& title, const std::string& program,
                                const nlohmann::ordered_json& data, PageTexts texts = {});

/// `page` with each {{name}} replaced, not recursively. Throws std::logic_error when a name has no text.
std::string fill_template(std::string_view page, const PageTexts& texts);

/// What takes time in the report of a run, and needs no summary.
struct ReportParts {
  PageTexts figures;                      ///< the final pictures
  nlohmann::ordered_json pictures, bone;  ///< pictures along the run; bone_data()
};

/// A picture of the page.
struct PagePicture {
  int width_px = 0;
  int height_px = 0;
  std::string jpeg_base64;
};
/// By the path of their PNG files.
using PagePictures = std::map<std::string, PagePicture>;
/// Keeps a picture just written for report_parts(), if the page may show it: reading its file later takes three times
/// as long. `dir`: of the run. No more than a page has.
void keep_page_picture(const std::string& dir, const std::string& path, PixelImage& image, PagePictures& pictures);

/// From the run, its bone_data(), the pictures that are `ready`, and where present from frames/, reamed*.png,
/// depth_map.png and segmentation.png in DIR. `bone` gives bone_data() and is called after the pictures along the run
/// have been read. Throws InputError for a result that is missing or damaged, and what `bone` throws.
ReportParts report_parts(const RunData& run, const RenderSettings& settings,
                         const std::function<nlohmann::ordered_json()>& bone, const PagePictures& ready = {});

/// Writes DIR/report.html, a self-contained page of a run, from its parts and results, and where present from
/// forces.png and verification.json. Deterministic. Throws InputError (a result missing or damaged), RunError (the page
/// cannot be written).
void write_report(const RunData& run, const RenderSettings& settings, const ReportParts& parts);

// Its parts: data of its scripts, and pictures.

/// The rows of a log that the page shows, ascending: of each of at most 1000 groups the first and the extremes of
/// force, torque and feed rate, and the last row. `rows` must not be empty.
std::vector<std::size_t> shown_rows(const std::vector<ForceRow>& rows);

/// The curves of the page's plot as columns with the names of forces.csv, at shown_rows(); `removed_mm3` is cumulative.
/// With means over `mean_travel_mm` > 0: `mean_axial_force_n`, `mean_spin_torque_nmm`; of a push: feed rate and power.
nlohmann::ordered_json plot_data(const ForceLog& log, double mean_travel_mm);

/// The page's 3D view in B and mm: `before` and `after`, surfaces as of mesh_json(); `density`, a volume for sections;
/// colour maps; view target and section planes; `reaming`.
nlohmann::ordered_json bone_data(const RunData& run, const RenderSettings& settings);

/// The reamers in the 3D view: `passes`, each with its `mesh` in T as of mesh_json() over `box_mm`, simplified, and its
/// first `row` of shown_rows(); `shown` and `look` as the settings say; `poses`, one for each of shown_rows(): x, y, z
/// over their `box_mm` in B, the quaternion's x, y, z, w over −1…1, and the spin angle (about −z of T) over a turn, as
/// of append_numbers16() in scene_data.cpp. null for a tool without triangles.
nlohmann::ordered_json tool_data(const std::vector<ToolPass>& passes, const ForceLog& log,
                                 const RenderSettings& settings);

/// Densities of the unreamed bone on a coarse lattice, for the colours of sections.
struct DensityVolume {
  Vec3i dims = Vec3i::Zero();     ///< cells; x fastest
  Vec3 origin_mm = Vec3::Zero();  ///< lower corner of cell (0, 0, 0), B
  double cell_mm = 0;
  std::vector<std::uint8_t> grades;  ///< see sim/bone/voxmap/voxmap.h
};

/// Means over the bone in cubes of n³ voxels, with the least n for at most `most_cells` cells, extrapolated into the
/// adjacent air, so that interpolation does not mix bone with air. Throws InputError when there is no bone.
DensityVolume density_volume(const Voxmap& voxmap, std::int64_t most_cells);

/// Indices of at most `most` of `count` items, evenly spaced and ascending, with the first and the last.
std::vector<std::size_t> evenly_spaced(std::size_t count, std::size_t most);

/// A text of a result file. Throws InputError, naming `path`, if it is missing.
std::string text_at(const nlohmann::ordered_json& json, const char* key, const std::string& path);

/// The figures and tables of the page from summary.json and verification.json (null if missing), without missing
/// values. A row is [label, value, unit]. A table has `title` and `rows`; that of a list has `columns` (titles) as
/// well, and of their numbers the `decimals` (null: texts). `verification` says what `differs` from the run: program,
/// device. Throws InputError, naming the path, for values that no run and no verification writes.
nlohmann::ordered_json summary_data(const nlohmann::ordered_json& summary, const nlohmann::ordered_json& verification,
                                    const std::string& summary_path, const std::string& verification_path);

/// The maximum number of triangles of a mesh on the page.
struct MeshBudget {
  std::size_t unreamed_triangles = 110'000;  ///< of the unreamed surface
  std::size_t reamed_triangles = 90'000;     ///< of the reamed face, which stays finer
};

/// Simplifies a surface with meshoptimizer (edge collapses by quadric error) to a subset of its vertices, in the order
/// of their first use. Reamed face and rest are simplified separately with locked borders, so that no cracks open.
BoneSurface simplified(const BoneSurface& surface, const MeshBudget& budget);

/// A surface as bytes for the page: as of append_numbers16() x, y, z of the vertices over `box`, depth over
/// 0…`depth_max_mm`, x, y, z of the normal (−1…1, 254 steps), reamed, density (0…2 g/cm³) and ambient accessibility
/// (255 steps each); then the triangle indices, each as its distance below the first vertex not yet used, as
/// variable-length numbers with 7 bits per byte, low bits first.
std::vector<std::uint8_t> mesh_bytes(const BoneSurface& surface, const Eigen::AlignedBox3f& box, double depth_max_mm);

/// The bounding box of a surface, mm.
Eigen::AlignedBox3f bounds_of(const BoneSurface& surface);

/// The page of a study: HTML without network, at most `most_bytes`, which sorts, filters and plots its runs and opens
/// their reports. A study that would be larger has a part of its runs, drawn at random; the page says so.
std::string study_page(const std::string& study, const struct RunTable& table, std::size_t most_bytes = 14'500'000);

/// What `reamsim preview` shows.
struct PreviewRequest {
  Scenario scenario;      ///< bone, tool and motion
  std::string text;       ///< the scenario as its user wrote it, which the page changes
  std::string file_name;  ///< under which the page saves it
  std::string source;     ///< what the page is titled with: the name of the scenario or of the bone's file
};

/// The page: HTML without network, at most 15 MB. It shows problems that stop a run, because it is there to mend them;
/// `report` gets warnings. Throws InputError when the bone itself cannot be read.
std::string preview_page(const PreviewRequest& request, Diagnostics& report);

/// Whether a file is such a page.
bool is_preview_page(const std::string& path);

/// What the page shows in its slices, on a lattice along the axes of B.
struct PreviewVolume {
  ct::Lattice lattice;
  std::string unit;          ///< of `value`: "HU" or "g/cm³"
  std::vector<float> value;  ///< radiodensity, or density with 0 in the air
  std::vector<float> bone;   ///< above 0 in the bone, 0 at its surface, within −1…1; empty without a segmentation
};

/// A CT scan and its segmentation, averaged to at most `most_voxels` voxels, first along axes with small spacing.
PreviewVolume preview_of_scan(const SegmentedScan& scan, std::int64_t most_voxels);

/// A voxmap, averaged over cubes of n³ voxels, with the least n for at most `most_voxels` cubes.
PreviewVolume preview_of_voxmap(const BoneView& bone, std::int64_t most_voxels);

/// The volume for the page: its lattice, `unit`, and as differences to the previous voxel, zlib in base 64: `values`, a
/// byte v per voxel for low + step·v, and `bone`, a byte per voxel, 128 at the surface and more inside, or null.
nlohmann::ordered_json volume_json(const PreviewVolume& volume);

}  // namespace reamsim
