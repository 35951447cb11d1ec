// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>
#include <vector>

#include "render/pictures/run_view.h"
#include "render/surface/bone_surface.h"
#include "render/viewer/page.h"

namespace reamsim {

/// Writes DIR/report.html, a self-contained page of a run, from its results, and where present from reamed*.png,
/// frames/, depth_map.png, segmentation.png, forces.png and verification.json. Deterministic. `options`: those of the
/// pictures. Throws InputError (a result missing or damaged), RunError (the page cannot be written).
void write_report(const RunData& run, const PictureOptions& options);

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
/// of append_numbers16(). null for a tool without triangles.
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

/// Whether mesh_bytes() writes a vertex as reamed.
bool counts_as_reamed(const float* vertex);

inline constexpr int kSteps16 = 65535;
/// Appends `values` as numbers 0…`steps` from `low` to `low` + `size`, 16 bits each, as zigzag differences to the one
/// before: first all low bytes, then all high bytes.
void append_numbers16(std::span<const double> values, double low, double size, std::vector<std::uint8_t>& out,
                      int steps = kSteps16);

/// A surface for the page's JSON: `vertices`, `triangles`, and mesh_bytes() compressed as `bytes`.
nlohmann::ordered_json mesh_json(const BoneSurface& surface, const Eigen::AlignedBox3f& box, double depth_max_mm);

/// The bounding box of a surface, mm.
Eigen::AlignedBox3f bounds_of(const BoneSurface& surface);

}  // namespace reamsim
