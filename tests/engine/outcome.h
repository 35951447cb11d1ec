// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "sim/device/opencl.h"
#include "tests/engine/scene_fixture.h"
#include "tests/support/temp_dir.h"

namespace reamsim::test {

/// The outcome of a run: the bytes of forces.csv, the removed voxels and their frames, and the remaining fill.
struct Outcome {
  std::string forces;
  RemovedFrames removed;
  std::vector<std::uint16_t> fill;
  RunTotals totals{1};
  Diagnostics report;
};

/// Runs the scene on an engine that has its bone.
inline Outcome run_on(Engine& engine, SimulationInput scene) {
  const TempDir dir;
  Outcome out;
  {
    Recorder recorder(dir.path(), scene.bone.voxmap->grid.voxel_mm);
    simulate(scene, engine, recorder, {}, out.report);
    recorder.close();
    out.totals = recorder.totals();
    out.removed = recorder.removed_frames();
  }
  std::sort(out.removed.begin(), out.removed.end());
  out.forces = file_bytes(dir.path() + "/forces.csv");
  for (std::int64_t e = 0; e < scene.bone.voxmap->grid.size(); ++e) {
    out.fill.push_back(scene.bone.fill.get(scene.bone.voxmap->grid.coord(e)));
  }
  return out;
}

inline Outcome run(const SimulationInput& scene) {
  const auto engine = make_engine(scene.scenario, scene.bone, scene.tool);
  return run_on(*engine, scene);
}

inline void expect_same(const Outcome& a, const Outcome& b) {
  EXPECT_EQ(a.forces, b.forces);
  EXPECT_EQ(a.removed, b.removed);
  EXPECT_EQ(a.fill, b.fill);
}

/// Runs `exact` with kernels of both shapes, batches of several sizes, and one core. `scene_of` takes the device.
template <class SceneOf>
void expect_all_shapes_give(const Outcome& serial, SceneOf scene_of) {
  const auto expect = [&](KernelShape shape, int batch, int compute_units) {
    SCOPED_TRACE(name_of(shape) + ", batch " + std::to_string(batch) + ", " + std::to_string(compute_units) +
                 " compute units");
    SimulationInput scene = scene_of("auto");
    scene.scenario.engine.tuning.kernel_shape = shape;
    scene.scenario.engine.tuning.compute_units = compute_units;
    scene.scenario.engine.batch_frames = batch;
    expect_same(run(scene), serial);
  };
  const cl::DeviceInfo device = cl::choose_device("auto");
  for (const KernelShape shape : {KernelShape::cpu, KernelShape::gpu}) {
    for (const int batch : {1, 7, 1000}) expect(shape, batch, 0);
    if (!device.gpu && device.compute_units > 1 && device.max_parts > 0) expect(shape, 7, 1);
  }
}

/// Engines with a shell, and the shapes of the kernels of `bricked`.
inline const std::vector<std::string> kShellEngines = {"direct",           "octree",      "bricked",
                                                       "bricked_unculled", "bricked_gpu", "bricked_gpu_unculled"};
inline const std::vector<std::string> kEngines = [] {
  std::vector<std::string> all = kShellEngines;
  all.emplace_back("implicit");
  return all;
}();

/// A name of kEngines as settings; `bricked` leaves the choice between bricked and exact to the erosion.
inline void choose_engine(EngineSettings& engine, const std::string& name) {
  const std::string type = name.substr(0, name.find('_'));
  engine.type = type == "bricked" ? EngineKind::automatic : *from_name<EngineKind>(type);
  engine.tuning.kernel_shape = name.find("_gpu") != std::string::npos ? KernelShape::gpu : KernelShape::automatic;
  engine.tuning.culling = name.find("_unculled") == std::string::npos;
}

/// A tilted tool on an oblique path through bone of all densities.
inline SimulationInput oblique_scene(const std::string& device, const std::string& engine = "bricked") {
  SimulationInput scene;
  scene.scenario = quiet_scenario(device);
  choose_engine(scene.scenario.engine, engine);
  scene.bone.set_voxels(random_bone({41, 37, 29}, 0.2, 7));
  scene.tool = make_tool(cap_profile(5, 6, 2.5, 0.6), 61);
  const Quat tilt(Eigen::AngleAxisd(0.4, Vec3(1, 2, 0.5).normalized()));
  scene.motion = straight({1.5, 1, 4}, {0.6, 1.4, 0.4}, 40, 100, 250, tilt);
  return scene;
}

}  // namespace reamsim::test
