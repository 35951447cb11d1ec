// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "render/pictures/run_view.h"
#include "render/surface/bone_surface.h"

// The parts of the page: data of its scripts, pictures, and HTML.
namespace reamsim {

/// The rows of a log that the page shows: of each of at most 1000 groups the first and the extremes of force and
/// torque, ascending, and the last row. `rows` must not be empty.
std::vector<std::size_t> shown_rows(const std::vector<ForceRow>& rows);

/// The curves of the page's plot as columns: `frame`, `time_s`, `depth_mm`, `axial_force_n`, `spin_torque_nmm`,
/// `removed_mm3` (cumulative); and, if the log has means over some travel, `mean_axial_force_n`, `mean_spin_torque_nmm`
/// with `mean_travel_mm`. Long logs are decimated to the rows with the extremes of force and torque, so that spikes
/// remain.
nlohmann::ordered_json plot_data(const ForceLog& log, double mean_travel_mm);

/// The data of the page's 3D view in B and mm: `before` and `after`, surfaces as in mesh_bytes(); `density`, a volume
/// for sections; colour maps; view target and section planes.
nlohmann::ordered_json bone_data(const RunData& run, const RenderSettings& settings);

/// The reaming between the two surfaces of bone_data(), at up to 12 of the pictures along the run: at each of `time_s`,
/// how much bone stood over each reamed vertex of `after` (counts_as_reamed(), in the order of the mesh) along the axis
/// of the tool, 0…`most_mm`, in the code of mesh_bytes(). null without snapshots or reamed vertices. Throws as
/// apply_snapshot() does.
nlohmann::ordered_json reaming_data(const RunData& run, const BoneSurface& after);

/// The reamers in the 3D view: `passes`, each with its `mesh` as in mesh_json() in T over `box_mm`, simplified, and its
/// first `row` of shown_rows(); `shown` and `look` as the settings say; and `poses`, one for each of shown_rows():
/// `count`, `box_mm` of their positions in B, and `bytes`, eight numbers each in the code of mesh_bytes(): x, y, z over
/// that box, the quaternion's x, y, z, w over −1…1, and the spin angle (about −z of T) over a turn. null for a tool
/// without triangles.
nlohmann::ordered_json tool_data(const std::vector<ToolPass>& passes, const ForceLog& log,
                                 const RenderSettings& settings);

/// Densities of the unreamed bone on a coarse lattice, for the colours of sections.
struct DensityVolume {
  Vec3i dims = Vec3i::Zero();     ///< cells; x fastest
  Vec3 origin_mm = Vec3::Zero();  ///< lower corner of cell (0, 0, 0), B
  double cell_mm = 0;
  std::vector<std::uint8_t> grades;  ///< see sim/bone/voxmap/density.h
};

/// Means over the bone in cubes of n³ voxels, with the least n for at most `most_cells` cells. Extrapolated into the
/// adjacent air, so that interpolation at the surface does not mix bone with air. Throws InputError when there is no
/// bone.
DensityVolume density_volume(const Voxmap& voxmap, std::int64_t most_cells);

/// A picture of the page.
struct PagePicture {
  std::string name;  ///< stem of its source file
  int width_px = 0;
  int height_px = 0;
  std::string jpeg_base64;
};

/// Converts PNG files to JPEGs in base 64, at most `most_px` wide. If they exceed `most_bytes` together, all are
/// reduced until they fit or are an eighth as wide. Throws InputError when one cannot be read.
std::vector<PagePicture> page_pictures(const std::vector<std::string>& paths, int most_px, std::size_t most_bytes);

/// Indices of at most `most` of `count` items, evenly spaced and ascending, with the first and the last.
std::vector<std::size_t> evenly_spaced(std::size_t count, std::size_t most);

/// A number with `digits` significant digits, a true minus sign, thin spaces between thousands, and exponents as in
/// 1.2 × 10⁻⁸.
std::string number_text(double value, int digits = 4);

/// A measured value with the decimals that mean something for its unit ("mm": 0.01), and digits behind the point
/// only up to the fourth significant one: 0.2734 mm is "0.27". Below ten steps it has one decimal more, and a positive
/// value that would be zero is "< 0.01". A value of another unit has three significant digits.
std::string measured_text(double value, const char* unit);

/// A text of summary.json, escaped. Throws InputError, naming `path`, if it is missing.
std::string text_at(const nlohmann::ordered_json& summary, const char* key, const std::string& path);

/// Parts of the page from summary.json, as HTML, without missing values. All throw InputError, naming `path`, for
/// values that a run does not write.
std::string key_figures_html(const nlohmann::ordered_json& summary, const std::string& path);
std::string summary_tables_html(const nlohmann::ordered_json& summary, const std::string& path);
/// The section on the fit of the implant; "" for a run without an implant.
std::string planning_html(const nlohmann::ordered_json& summary, const std::string& path);
std::string provenance_html(const nlohmann::ordered_json& summary, const std::string& path);
/// The warnings of the run; "" without any.
std::string warnings_html(const nlohmann::ordered_json& summary, const std::string& path);

/// The energy balance of the run and the result of `verification` (verification.json; null if missing), with a note if
/// program or device differ.
std::string verification_html(const nlohmann::ordered_json& summary, const nlohmann::ordered_json& verification,
                              const std::string& summary_path, const std::string& verification_path);

}  // namespace reamsim
