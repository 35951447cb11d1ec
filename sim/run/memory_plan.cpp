// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/run/memory_plan.h"

#include <algorithm>

#include "sim/bone/voxmap/lattice.h"
#include "sim/engine/bricked/bricked_engine.h"
#include "sim/engine/dense/dense_plan.h"
#include "sim/record/force_log.h"
#include "sim/tool/bounded_path.h"

namespace reamsim {

namespace {

// Measured on a scapula of 0.1 mm voxels (memory_mb.peak_process of its summary).

/// The program and its libraries: a run of a small block peaks at 177 MB with the compiler.
constexpr double kProgramBytes = 1.2e8;
/// The kernel compiler, and heap memory retained from loading the bone.
constexpr double kCompilerBytes = 9e7;
/// Per brick on the surface, while `surface` of reamed.vdb is computed: leaves of the smoothed occupancy and of the
/// distances.
constexpr double kSurfaceBytes = 7'000;
/// A leaf of a FloatGrid.
constexpr double kLeafBytes = 2'200;
/// The serial engine's dense grades and fill, per voxel.
constexpr double kSerialBytes = 3;

/// A long run thins poses and rows; until then it holds all, and vectors double as they grow.
double path_bytes(double frames) {
  return 2 * sizeof(PathSample) * std::min(frames, static_cast<double>(BoundedPath::kMost));
}

/// The rows of the log, and a copy with the means that the plots show.
double log_bytes(double frames) {
  return 2 * sizeof(ForceRow) * std::min(frames, static_cast<double>(LogOptions{}.most_rows));
}

struct BrickCounts {
  double partial = 0;  ///< with bone and air
  double mixed = 0;    ///< with more than one grade, air included
};

BrickCounts count_bricks(const GradeBricks& grades) {
  BrickCounts out;
  grades.for_each_brick([&out](const Vec3i&, const GradeBricks::Brick& brick) {
    const auto [least, most] = std::minmax_element(brick.begin(), brick.end());
    out.partial += *least == 0 ? 1 : 0;
    out.mixed += *least != *most ? 1 : 0;
  });
  return out;
}

/// The surface is computed first, and freed before all grids are written.
double results_bytes(const BrickCounts& bricks) {
  const double grids = kLeafBytes * (bricks.mixed + bricks.partial + 1.6 * bricks.partial);
  return std::max(kSurfaceBytes * bricks.partial, grids);
}

std::size_t planned_device_bytes(const SimulationInput& scene, const ExactForecast& forecast) {
  const Scenario& scenario = scene.scenario;
  const BoneView bone = scene.bone;
  if (scenario.engine.device == "serial") return 0;
  const EngineKind engine = engine_of(scenario);
  if (engine == EngineKind::exact) return exact_engine_bytes(bone, scene.tool, forecast);
  if (engine == EngineKind::bricked) return bricked_engine_bytes(scenario, bone, scene.tool);
  return plan_dense(engine, bone, scene.tool, scenario.cutting.erosion == ErosionMode::wear).bytes();
}

}  // namespace

MemoryPlan plan_memory(const SimulationInput& scene) {
  const Voxmap& voxmap = *scene.bone.voxmap;
  const bool exact = scene.scenario.cutting.erosion == ErosionMode::exact;
  const ExactForecast forecast = exact ? forecast_exact(scene) : ExactForecast{};
  MemoryPlan plan{.device_bytes = planned_device_bytes(scene, forecast)};

  const double voxels = static_cast<double>(voxmap.grade.count());
  const double loading = scene.scenario.bone.source == BoneSource::mesh ? kMeshBytesPerVoxel * voxels : 0;
  const bool serial = scene.scenario.engine.device == "serial";
  const double engine =
      serial ? kSerialBytes * static_cast<double>(voxmap.grid.size()) : static_cast<double>(plan.device_bytes);
  // The fill at the start of the run, and the current one where it differs.
  const double fill = static_cast<double>(scene.bone.fill.bytes() + sizeof(FillBricks::Brick) * forecast.partial);
  BrickCounts bricks = count_bricks(voxmap.grade);
  // The reamed face is part of the surface.
  bricks.partial += static_cast<double>(forecast.listed);
  bricks.mixed += static_cast<double>(forecast.listed);
  const double resident = static_cast<double>(voxmap.grade.bytes()) + fill;
  const auto frames = static_cast<double>(scene.motion.poses.size());
  // What is held of the frames uses the memory that the compiler has left.
  const double held = std::max(serial ? 0 : kCompilerBytes, path_bytes(frames) + log_bytes(frames));
  // The engine is freed before the results are written.
  const double most = std::max(loading, resident + held + std::max(engine, results_bytes(bricks)));
  plan.process_bytes = static_cast<std::size_t>(kProgramBytes + most);
  return plan;
}

}  // namespace reamsim
