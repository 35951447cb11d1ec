#include "sim/plan/memory_plan.h"

#include <algorithm>

#include "sim/bone/voxmap/lattice.h"
#include "sim/engine/bricked/bricked_engine.h"
#include "sim/engine/dense/dense_plan.h"
#include "sim/plan/exact_forecast.h"

namespace reamsim {

namespace {

// Measured on scapulae of 0.15 and 0.075 mm voxels (memory_mb.peak_process of their summaries).

/// The program and its libraries.
constexpr double kProgramBytes = 1e8;
/// The compiler of the kernels, and what the heap keeps of the loading of the bone.
constexpr double kCompilerBytes = 9e7;
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

std::size_t planned_device_bytes(const ReamingScene& scene, const ExactForecast& forecast) {
  const Scenario& scenario = scene.scenario;
  const BoneView bone = scene.bone;
  if (scenario.engine.device == "serial") return 0;
  const EngineKind engine = engine_of(scenario);
  if (engine == EngineKind::exact) return exact_engine_bytes(bone, scene.tool, forecast);
  if (engine == EngineKind::bricked) return bricked_engine_bytes(scenario, bone, scene.tool);
  return plan_dense(engine, bone, scene.tool, scenario.cutting.erosion == ErosionMode::wear).bytes();
}

}  // namespace

MemoryPlan plan_memory(const ReamingScene& scene) {
  const Voxmap& voxmap = *scene.bone.voxmap;
  const bool exact = scene.scenario.cutting.erosion == ErosionMode::exact;
  const ExactForecast forecast = exact ? forecast_exact(scene) : ExactForecast{};
  MemoryPlan plan{.device_bytes = planned_device_bytes(scene, forecast)};

  const double voxels = static_cast<double>(voxmap.grade.count());
  const double loading = scene.scenario.bone.source == BoneSource::mesh ? kMeshBytesPerVoxel * voxels : 0;
  const bool serial = scene.scenario.engine.device == "serial";
  const double engine = serial ? kSerialBytes * static_cast<double>(voxmap.grid.size())
                               : kCompilerBytes + static_cast<double>(plan.device_bytes);
  // The fill as it was when the run began, and as it is.
  const double fill =
      std::max(2.0 * static_cast<double>(scene.bone.fill.bytes()),
               static_cast<double>(scene.bone.fill.bytes() + sizeof(FillBricks::Brick) * forecast.parted));
  BrickCounts bricks = count_bricks(voxmap.grade);
  // The face that the tool leaves is surface as well.
  bricks.parted += static_cast<double>(forecast.listed);
  bricks.mixed += static_cast<double>(forecast.listed);
  const double held = static_cast<double>(voxmap.grade.bytes()) + fill + engine;
  const double most = std::max(loading, held + results_bytes(bricks));
  plan.process_bytes = static_cast<std::size_t>(kProgramBytes + most);
  return plan;
}

}  // namespace reamsim
