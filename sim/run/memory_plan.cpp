#include "sim/run/memory_plan.h"

#include <algorithm>

#include "sim/bone/lattice.h"

namespace reamsim {

namespace {

// Measured on scapulae of 0.15 and 0.075 mm voxels (memory_mb.peak_process of their summaries).

/// The program and its libraries.
constexpr double kProgramBytes = 1e8;
/// The compiler of the kernels.
constexpr double kCompilerBytes = 5e7;
/// For each brick through which the surface passes, while `surface` of reamed.vdb is made: smoothed occupancy,
/// polygons, distances and the nearest polygons' numbers.
constexpr double kSurfaceBytes = 16'000;
/// A leaf of a FloatGrid.
constexpr double kLeafBytes = 2'200;
/// The serial engine's dense grades and fill, a voxel.
constexpr double kSerialBytes = 3;

struct BrickCounts {
  double parted = 0;  ///< neither all bone nor all air
  double mixed = 0;   ///< of more than one grade, air included
};

BrickCounts count_bricks(const GradeBricks& grades) {
  BrickCounts out;
  grades.for_each_brick([&out](const Vec3i&, const GradeBricks::Brick& brick) {
    const auto [least, most] = std::minmax_element(brick.begin(), brick.end());
    out.parted += *least == 0 ? 1 : 0;
    out.mixed += *least != *most ? 1 : 0;
  });
  return out;
}

/// Results are made of the surface first, and then of all grids together.
double results_bytes(const BrickCounts& bricks) {
  const double grids = kLeafBytes * (bricks.mixed + bricks.parted + 1.6 * bricks.parted);
  return std::max(kSurfaceBytes * bricks.parted, grids);
}

}  // namespace

std::size_t planned_process_bytes(const ReamingScene& scene, std::size_t device_bytes) {
  const Voxmap& voxmap = scene.bone.voxmap;
  const double voxels = static_cast<double>(voxmap.grade.count());
  const double loading = scene.scenario.bone.source == "mesh" ? kMeshBytesPerVoxel * voxels : 0;
  const bool serial = scene.scenario.engine.device == "serial";
  const double engine = serial ? kSerialBytes * static_cast<double>(voxmap.grid.size())
                               : kCompilerBytes + static_cast<double>(device_bytes);
  // The fill twice: as it was when the run began, and as it is.
  const double held = static_cast<double>(voxmap.grade.bytes() + 2 * voxmap.fill.bytes()) + engine;
  const double most = std::max(loading, held + results_bytes(count_bricks(voxmap.grade)));
  return static_cast<std::size_t>(kProgramBytes + most);
}

}  // namespace reamsim
