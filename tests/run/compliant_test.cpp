// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// A tool on springs on voxels: the same on every device and however it is interrupted; passes, teeth and edge forces.
#include <gtest/gtest.h>

#include <cmath>

#include "sim/base/error.h"
#include "tests/engine/frame_rows.h"
#include "tests/engine/outcome.h"

namespace reamsim::test::compliant_tests {
namespace {

/// A small head fed down beside the middle of a block, so that half of it is in the air.
SimulationInput scene_of(const ComplianceSettings& springs, const std::string& device, double rate_hz = 200) {
  SimulationInput scene;
  scene.scenario = quiet_scenario(device);
  scene.scenario.cutting.erosion = ErosionMode::exact;
  scene.scenario.motion.compliance = springs;
  scene.bone.set_voxels(block({12, 12, 3}, 0.25, 1.8));
  scene.tool = make_tool(cap_profile(12, 8, 4, 0), 8);
  scene.motion.frame_rate_hz = rate_hz;
  std::vector<ToolPose> poses;
  const double frames = 0.35 * rate_hz;
  for (int k = 0; k <= static_cast<int>(frames); ++k) {
    ToolPose pose;
    pose.position_mm = {6.03, 0.05, 0.05 - 0.35 * k / frames};
    pose.spin_rpm = 250;
    pose.spin_angle_rad = 250 * 2 * M_PI / 60 * k / rate_hz;
    poses.push_back(pose);
  }
  scene.motion.poses = PoseSequence(std::move(poses));
  return scene;
}

const ComplianceSettings kSoft{{30, 40, 60}, 1};

std::vector<double> values_of(const FrameRows& sink) {
  std::vector<double> out;
  for (const FrameResult& r : sink.rows) {
    for (const Vec3& v : {r.pose.position_mm, r.force_n, r.torque_nmm, r.deflection_mm.value_or(Vec3(9, 9, 9))})
      out.insert(out.end(), v.begin(), v.end());
    out.push_back(r.removed_mm3);
  }
  return out;
}

TEST(Compliance, SameOnSerialAndBothShapesOfKernels) {
  const FrameRows serial = run_rows(scene_of(kSoft, "serial"));
  ASSERT_EQ(serial.rows.size(), 71U);
  for (const KernelShape shape : {KernelShape::cpu, KernelShape::gpu}) {
    SimulationInput scene = scene_of(kSoft, "auto");
    scene.scenario.engine.tuning.kernel_shape = shape;
    EXPECT_EQ(values_of(run_rows(scene)), values_of(serial)) << name_of(shape);
  }
}

TEST(Compliance, BonePushesTheToolAwayAndTheSpringHoldsTheForce) {
  // Bone on the side of −x only: the normal force points to +x, and cutting edges that go clockwise press against bone
  // towards +y there, so that it pushes to −y.
  const FrameRows sink = run_rows(scene_of(kSoft, "auto"));
  const FrameResult& last = sink.rows.back();
  const Vec3 d = *last.deflection_mm;
  EXPECT_GT(d.x(), 0.01);
  EXPECT_LT(d.y(), -0.05);
  EXPECT_GT(d.z(), 0.05);
  const Vec3 speed = (d - *sink.rows[sink.rows.size() - 2].deflection_mm) * 200;
  const Vec3 spring = kSoft.stiffness_n_mm.cwiseProduct(d) + kSoft.damping_n_s_mm * speed;
  EXPECT_LT((spring - last.force_n).norm(), 2e-3 * last.force_n.norm());
  EXPECT_NEAR(last.pose.position_mm.x(), 6.03 + d.x(), 1e-12);
  EXPECT_NEAR(last.pose.position_mm.z(), -0.3 + d.z(), 1e-12);
}

TEST(Compliance, InterruptedAndContinuedIsTheSame) {
  const FrameRows whole = run_rows(scene_of(kSoft, "auto"));
  SimulationInput scene = scene_of(kSoft, "auto");
  auto engine = make_engine(scene.scenario, scene.bone, scene.tool);
  FrameRows sink;
  Diagnostics report;
  std::optional<SimulationState> saved;
  RunControl control;
  control.stop = [&] { return sink.rows.size() == 43 && !saved; };
  control.save = [&](const SimulationState& state) { saved = state; };
  EXPECT_THROW(simulate(scene, *engine, sink, control, report), Interrupted);
  ASSERT_TRUE(saved);
  EXPECT_NE(saved->springs.deflection_mm[1], 0) << "in contact";
  engine = make_engine(scene.scenario, scene.bone, scene.tool);
  control.from = saved;
  simulate(scene, *engine, sink, control, report);
  EXPECT_EQ(values_of(sink), values_of(whole));
}

TEST(Compliance, StandsWithinContactAtRest) {
  // Fed, then held: the spring presses the tool on until its force is nearly zero, without chatter.
  SimulationInput scene = scene_of({{400, 400, 400}, 2}, "auto", 1000);
  std::vector<ToolPose> poses = scene.motion.poses.all();
  const std::size_t fed = poses.size();
  for (int k = 0; k < 600; ++k) {
    poses.push_back(poses.back());
    poses.back().spin_angle_rad += 250 * 2 * M_PI / 60 * 1e-3;
  }
  scene.motion.poses = PoseSequence(std::move(poses));
  const FrameRows sink = run_rows(std::move(scene));
  double before = sink.rows[fed].deflection_mm->norm();
  EXPECT_GT(before, 0.005);
  for (std::size_t k = fed + 1; k < sink.rows.size(); ++k) {
    const double now = sink.rows[k].deflection_mm->norm();
    EXPECT_LT(now, before + 2e-5) << "frame " << k;
    before = now;
  }
  EXPECT_LT(before, 0.1 * sink.rows[fed].deflection_mm->norm());
}

TEST(Compliance, WithAnEdgeForceTheSpringsAreLongerByIt) {
  const auto deflection = [](double normal_n_mm) {
    SimulationInput scene = scene_of({{1e6, 1e6, 60}, 1}, "auto");
    if (normal_n_mm > 0) scene.scenario.cutting.edge_force = {.tangential_n_mm = 1e-6, .normal_n_mm = normal_n_mm};
    return run_rows(std::move(scene)).rows.back().deflection_mm->z();
  };
  EXPECT_GT(deflection(3), deflection(0) + 0.01);
}

}  // namespace
}  // namespace reamsim::test::compliant_tests
