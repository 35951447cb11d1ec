// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// `spin: resolved`: the teeth themselves turn through the bone, and push back as the surface that they sweep.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <sstream>

#include "sim/engine/common/engine.h"
#include "sim/tool/point_shell.h"
#include "tests/engine/sweep.h"

namespace reamsim::test::teeth_tests {
namespace {

constexpr double kRadius = 29;  // of the face of reamer_convex_edges: six cutting edges, a slot before each

Tool toothed_reamer(double voxel_mm) {
  ToolSettings settings;
  settings.mesh = REAMSIM_ASSETS "/reamer_convex_edges.stl";
  settings.spin = ToolSpin::resolved;
  Diagnostics report;
  Tool tool = load_tool(settings, voxel_mm, ShellUse::touches_voxels, report);
  EXPECT_TRUE(report.warnings.empty());
  return tool;
}

struct Contact {
  std::int64_t frame = 0;
  Vec3 force = Vec3::Zero();
  Vec3 torque = Vec3::Zero();
};

/// Frames with contact, from forces.csv.
std::vector<Contact> contacts_of(const std::string& path) {
  std::ifstream in(path);
  std::string line;
  std::getline(in, line);
  std::vector<Contact> out;
  while (std::getline(in, line)) {
    std::stringstream fields(line);
    std::vector<double> v;
    for (std::string f; std::getline(fields, f, ',');) v.push_back(std::stod(f));
    if (v[20] > 0) out.push_back({static_cast<std::int64_t>(v[0]), {v[12], v[13], v[14]}, {v[15], v[16], v[17]}});
  }
  return out;
}

/// The least spin angle at which a lip has just left the voxel about `center`.
double angle_behind_a_lip(const Tool& tool, const Vec3& center, double voxel_mm) {
  const auto touches = [&](double angle) {
    ToolPose pose;
    pose.spin_angle_rad = angle;
    const Rigid bone_from_tool = bone_from_shell(pose, true);
    return std::any_of(tool.shell.codes.begin(), tool.shell.codes.end(), [&](std::uint64_t code) {
      const Vec3 cell = morton_decode(code).cast<double>() + Vec3::Constant(0.5);
      const Vec3 p = bone_from_tool * (tool.shell.origin_mm + tool.shell.cell_mm * cell);
      return (p - center).cwiseAbs().maxCoeff() < voxel_mm / 2;
    });
  };
  constexpr double kStep = 0.01;
  double angle = 0;
  while (!touches(angle)) angle += kStep;
  while (touches(angle)) angle += kStep;
  return angle;
}

TEST(Teeth, OneVoxelFeelsTheEnvelopesNormal) {
  // A lip's flank strikes the only voxel there is, while the tool does nothing but turn. Of all the tooth's surfaces it
  // is the flank that gets there first, and its own normal lies along the motion; the envelope's does not.
  constexpr double kVoxel = 0.5, kRateHz = 1000, kRpm = 60;
  const Vec3 at(10, 0, kRadius - std::sqrt(kRadius * kRadius - 100) + 0.05);
  SimulationInput scene;
  scene.scenario = quiet_scenario("auto");
  const std::uint8_t grade = DensityMapping::grade_from_density(1.8);
  scene.bone.set_voxels(one_voxel(kVoxel, at - Vec3::Constant(kVoxel / 2), grade));
  scene.tool = toothed_reamer(kVoxel);
  scene.motion = straight({0, 0, 0}, {0, 0, 0}, 200, kRateHz, kRpm);
  const double start = angle_behind_a_lip(scene.tool, at, kVoxel);
  std::vector<ToolPose> poses = scene.motion.poses.all();
  for (ToolPose& pose : poses) pose.spin_angle_rad += start;
  scene.motion.poses = poses;
  const TempDir dir;
  Diagnostics report;
  Recorder recorder(dir.path(), kVoxel);
  const auto engine = make_engine(scene.scenario, scene.bone, scene.tool);
  simulate(scene, *engine, recorder, {}, report);
  recorder.close();
  const auto contacts = contacts_of(dir.path() + "/forces.csv");
  ASSERT_EQ(contacts.size(), 1U);
  EXPECT_GT(contacts[0].frame, 10) << "the voxel should be in a slot at first";

  const double omega = 2 * M_PI * kRpm / 60, energy_mj = 150 * std::pow(kVoxel, 3);  // 150 N/mm² at 1.8 g/cm³
  const Vec3 way = Vec3(0, -1, 0);                                                   // clockwise seen from above
  const Vec3 normal = (at - Vec3(0, 0, kRadius)).normalized();
  const double tangential = energy_mj * kRateHz / (omega * at.x());  // mean over the frame
  const Vec3 force = -tangential * way - 0.5 * tangential * normal;
  // The profile is a polygon of 18 chords: its normal is within 1° of the sphere's.
  EXPECT_NEAR((contacts[0].force - force).norm() / force.norm(), 0, 0.01)
      << contacts[0].force.transpose() << " instead of " << force.transpose();
  EXPECT_NEAR((contacts[0].torque - at.cross(force)).norm() / at.cross(force).norm(), 0, 0.01);
}

TEST(Teeth, NothingIsLeftOfWhatTheySweep) {
  constexpr double kVoxel = 0.5, kRpm = 500, kFeed = 0.8, kDepth = 0.8;
  SimulationInput scene;
  scene.scenario = quiet_scenario("auto");
  scene.bone.set_voxels(block({20, 20, 2.5}, kVoxel, 1.2));
  scene.tool = toothed_reamer(kVoxel);
  scene.tool.spin = ToolSpin::resolved;
  constexpr double kRateHz = 200, kAbove = 0.1;
  const int frames = static_cast<int>((kDepth + kAbove) / kFeed * kRateHz);
  scene.motion = straight({0.02, 0.03, kAbove}, {0.02, 0.03, -kDepth}, frames, kRateHz, kRpm);
  // From one cutting edge to the next the tool advances by a sixth of its feed per turn; the last such layer is
  // swept only when the edges come round again.
  const double lag_voxels = kFeed / (kRpm / 60) / 6 / kVoxel;
  ASSERT_LT(lag_voxels, 0.05);
  const Leftovers found = ream_and_look(scene, 0.5 + lag_voxels);
  EXPECT_GT(found.swept, 100);
  EXPECT_EQ(found.left, 0) << "of " << found.swept << ", the deepest by " << found.deepest_voxels << " voxels";
}

TEST(Teeth, ATurnTakesAsManySubstepsAsTheRimIsHalfVoxelsLong) {
  SimulationInput scene;
  scene.scenario = quiet_scenario("serial");
  scene.bone.set_voxels(block({4, 4, 2}, 0.5, 1.2));
  scene.tool = toothed_reamer(0.5);
  scene.tool.spin = ToolSpin::envelope;
  scene.motion = straight({0, 0, 9}, {0, 0, 9}, 100, 100, 60);
  EXPECT_EQ(count_all_substeps(scene), 100) << "the envelope does not move";
  scene.tool.spin = ToolSpin::resolved;
  const double rim_mm = 2 * M_PI * 15;
  EXPECT_GE(static_cast<double>(count_all_substeps(scene)), rim_mm / 0.25);
  EXPECT_LE(static_cast<double>(count_all_substeps(scene)), rim_mm / 0.25 + 100) << "rounded up per frame";
}

}  // namespace
}  // namespace reamsim::test::teeth_tests
