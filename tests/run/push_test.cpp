// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// A push on voxels: the same on every device and however it is interrupted, and smooth at feeds whose frames are below
// the smallest loss.
#include <gtest/gtest.h>

#include "sim/base/error.h"
#include "tests/engine/frame_rows.h"
#include "tests/engine/outcome.h"

namespace reamsim::test::push_tests {
namespace {

PushSettings pushed_with(double thrust_n) {
  PushSettings push;
  push.entry_mm = {0.03, 0.05, 0};
  push.approach_mm = 0.01;
  push.thrust_n = thrust_n;
  push.depth_mm = 0.3;
  return push;
}

/// A small head without bore on a block.
SimulationInput scene_of(const PushSettings& push, const std::string& device, double rate_hz = 200) {
  SimulationInput scene;
  scene.scenario = quiet_scenario(device);
  scene.scenario.cutting.erosion = ErosionMode::exact;
  scene.bone.set_voxels(block({12, 12, 3}, 0.25, 1.8));
  scene.tool = make_tool(cap_profile(12, 8, 4, 0), 8);
  scene.motion.frame_rate_hz = rate_hz;
  scene.motion.push = std::make_shared<const PushPlan>(push, rate_hz, std::nullopt);
  scene.motion.poses = unresisted_poses(scene.motion.push, rate_hz);
  return scene;
}

std::vector<double> values_of(const FrameRows& sink) {
  std::vector<double> out;
  for (const FrameResult& r : sink.rows) {
    for (const double v : {r.pose.position_mm.z(), r.axial_force_n, r.spin_torque_nmm, r.removed_mm3, r.energy_mj,
                           r.push ? r.push->feed_mm_s : 0, r.push ? r.push->hand_force_n : 0})
      out.push_back(v);
  }
  return out;
}

TEST(Push, SameOnSerialAndBothShapesOfKernels) {
  const FrameRows serial = run_rows(scene_of(pushed_with(20), "serial"));
  ASSERT_GT(serial.rows.size(), 20U);
  for (const KernelShape shape : {KernelShape::cpu, KernelShape::gpu}) {
    SimulationInput scene = scene_of(pushed_with(20), "auto");
    scene.scenario.engine.tuning.kernel_shape = shape;
    EXPECT_EQ(values_of(run_rows(scene)), values_of(serial)) << name_of(shape);
  }
}

TEST(Push, InterruptedAndContinuedIsTheSame) {
  const FrameRows whole = run_rows(scene_of(pushed_with(20), "auto"));
  SimulationInput scene = scene_of(pushed_with(20), "auto");
  auto engine = make_engine(scene.scenario, scene.bone, scene.tool);
  FrameRows sink;
  Diagnostics report;
  std::optional<SimulationState> saved;
  RunControl control;
  control.stop = [&] { return sink.rows.size() == 13 && !saved; };
  control.save = [&](const SimulationState& state) { saved = state; };
  EXPECT_THROW(simulate(scene, *engine, sink, control, report), Interrupted);
  ASSERT_TRUE(saved);
  EXPECT_EQ(saved->frame, 12);
  engine = make_engine(scene.scenario, scene.bone, scene.tool);
  control.from = saved;
  simulate(scene, *engine, sink, control, report);
  EXPECT_EQ(values_of(sink), values_of(whole));
  EXPECT_EQ(sink.pictures, whole.pictures);
}

TEST(Push, TrialsLeaveTheBoneAsItIs) {
  for (const std::string device : {"serial", "auto"}) {
    SimulationInput scene = scene_of(pushed_with(20), device);
    const auto engine = make_engine(scene.scenario, scene.bone, scene.tool);
    FrameRows sink;
    Diagnostics report;
    FrameStepper stepper(scene, *engine, sink, report);
    const PushPlan& plan = *scene.motion.push;
    stepper.start({.frame = 0, .before = plan.pose(0, 0), .pose = plan.pose(0, 0)});
    const FrameMotion down{.frame = 1, .before = plan.pose(0, 0), .pose = plan.pose(0.1, 1e-3)};
    const auto tried = stepper.evaluate({down, down});
    EXPECT_GT(tried[0].removed, 0) << device;
    EXPECT_EQ(tried[0].removed, tried[1].removed) << device;
    stepper.read_fill();
    EXPECT_EQ(scene.bone.view().bone_mm3(), scene_of(pushed_with(20), device).bone.view().bone_mm3()) << device;
    stepper.add(down);
    stepper.finish_batch();
    EXPECT_NEAR(sink.rows.back().axial_force_n, static_cast<double>(tried[0].force[2]) / RS_FORCE_SCALE, 1e-6);
    EXPECT_GT(sink.rows.back().removed_mm3, 0);
  }
}

TEST(Push, SlowFeedIsSmoothBelowTheSmallestLoss) {
  PushSettings push = pushed_with(1);  // 0.01 mm/s and less: 10 nm in a frame of 1 ms
  push.entry_mm.z() = -1.2;            // in full contact
  push.approach_mm = 0;
  push.until = PushEnd::time;
  push.time_s = 0.4;
  const FrameRows sink = run_rows(scene_of(push, "auto", 1000));
  double sum = 0, least = 1e9, most = 0, force = 0;
  std::size_t count = 0;
  for (std::size_t k = 50; k < sink.rows.size(); ++k, ++count) {
    const double feed = sink.rows[k].push->feed_mm_s;
    sum += feed;
    force += sink.rows[k].axial_force_n;
    least = std::min(least, feed);
    most = std::max(most, feed);
  }
  const double mean = sum / static_cast<double>(count);
  EXPECT_LT(mean, 0.03);
  EXPECT_LT((most - least) / mean, 0.03);
  // Cuts of single frames are bursts; their mean is the thrust.
  EXPECT_NEAR(force / static_cast<double>(count), 1, 0.05);
}

TEST(Push, EndsAtItsDepthOrItsTime) {
  const FrameRows deep = run_rows(scene_of(pushed_with(20), "serial"));
  EXPECT_LE(deep.rows.back().pose.position_mm.z(), -0.3 + 1e-9);
  EXPECT_GT(deep.rows[deep.rows.size() - 2].pose.position_mm.z(), -0.3);
  EXPECT_EQ(deep.pictures.back(), deep.rows.back().frame);
  PushSettings push = pushed_with(20);
  push.time_s = 0.05;
  const FrameRows late = run_rows(scene_of(push, "serial"));
  EXPECT_EQ(late.rows.back().frame, 10);
}

}  // namespace
}  // namespace reamsim::test::push_tests
