#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "render/pictures/run_view.h"

// The data that the page's scripts work on, and its pictures.
namespace reamsim {

/// The curves of the page's plot, columns of equal length: `frame`, `time_s`, `depth_mm`, `axial_force_n`,
/// `spin_torque_nmm`, `removed_mm3` (since the start); and, where forces are means over some travel (the log has them),
/// `mean_axial_force_n`, `mean_spin_torque_nmm` with `mean_travel_mm`. Of very many rows those stay that have the least
/// and the greatest force and torque of their neighbours, so that no spike is lost.
nlohmann::ordered_json plot_data(const ForceLog& log, double mean_travel_mm);

/// What the page's 3D view needs, all in B and mm: `before` and `after`, the bone's surface as mesh_bytes() packs it;
/// `density`, a volume for cuts; colour maps; where to look, and which planes to cut along.
nlohmann::ordered_json bone_data(const RunData& run, const RenderSettings& settings);

/// Densities of the unreamed bone on a coarse lattice, for the colours of a cut through it.
struct DensityVolume {
  Vec3i dims = Vec3i::Zero();     ///< cells; x fastest
  Vec3 origin_mm = Vec3::Zero();  ///< lower corner of cell (0, 0, 0), B
  double cell_mm = 0;
  std::vector<std::uint8_t> grades;  ///< see sim/bone/voxmap/density.h
};

/// Means over the bone in cubes of n³ voxels, n the least for which there are at most `most_cells` cells. The bone's
/// outer cells are carried on into the air round it, so that interpolation at its edge does not mix it with air.
/// Throws InputError when there is no bone.
DensityVolume density_volume(const Voxmap& voxmap, std::int64_t most_cells);

/// A picture as the page holds it: a JPEG in base 64.
struct PagePicture {
  std::string name;  ///< of the file it was made from, without folder and ending
  int width_px = 0;
  int height_px = 0;
  std::string jpeg_base64;
};

/// PNG files as JPEGs in base 64, each at most `most_px` wide. When together they are more than `most_bytes`, all are
/// made smaller until they fit, or until they are an eighth as wide.
/// Throws InputError when one cannot be read.
std::vector<PagePicture> page_pictures(const std::vector<std::string>& paths, int most_px, std::size_t most_bytes);

/// At most `most` of `count` items, evenly spread, the first and the last among them; ascending.
std::vector<std::size_t> evenly_spaced(std::size_t count, std::size_t most);

}  // namespace reamsim
