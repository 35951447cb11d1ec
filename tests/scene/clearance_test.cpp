// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The clearance of a holder that does not cut, against closed forms.
#include "sim/scene/clearance.h"

#include <gmock/gmock.h>

#include <cmath>

#include "sim/mesh/mesh_io.h"
#include "tests/bone/bone_fixture.h"
#include "tests/engine/outcome.h"
#include "tests/support/mesh_shapes.h"

namespace reamsim::test::clearance_tests {
namespace {

constexpr double kVoxel_mm = 0.5;
constexpr double kTolerance_mm = 0.1 * kVoxel_mm;
constexpr double kHead_mm = 6;  ///< height of the reamer

HolderPartSettings part(double from, double to, double diameter, double end = 0) {
  return {.name = "", .from_z_mm = from, .to_z_mm = to, .diameter_mm = diameter, .end_diameter_mm = end};
}

Bone phantom_bone(PhantomShape shape) {
  BoneSettings settings = phantom(shape, kVoxel_mm);
  settings.surface_voxels = SurfaceVoxels::partial;
  settings.phantom.size_mm = {48, 48, 20};
  settings.phantom.radius_mm = 15;
  return make(settings);
}

/// A flat reamer of 8 mm radius that moves straight, with a holder.
SimulationInput scene_of(const Bone& bone, const Vec3& from, const Vec3& to, std::vector<HolderPartSettings> holder,
                         const Quat& orientation = Quat::Identity(), int frames = 200) {
  SimulationInput scene;
  scene.scenario = quiet_scenario("auto");
  scene.scenario.cutting.erosion = ErosionMode::exact;
  scene.scenario.tool.holder = std::move(holder);
  scene.bone = bone;
  scene.tool = make_tool(Profile{{{0, 0}, {8, 0}, {8, kHead_mm}, {0, kHead_mm}}}, 64);
  scene.tool.holder = scene.scenario.tool.holder;
  scene.motion = straight(from, to, frames, 100, 250, orientation);
  return scene;
}

HolderClearance clearance_of(const SimulationInput& scene) {
  std::optional<HolderClearance> out = find_clearance(scene);
  if (!out) throw std::logic_error("no clearance");
  return *out;
}

TEST(Clearance, OfAWideHolderFromTheFaceOfABlock) {
  const Bone bone = phantom_bone(PhantomShape::half_space);
  // 2 mm over the face beside the hole, which is narrower than the holder.
  const HolderClearance found = clearance_of(scene_of(bone, {0.2, 0.1, 3}, {0.2, 0.1, -4}, {part(kHead_mm, 40, 24)}));
  EXPECT_NEAR(found.least.mm, 2, kTolerance_mm);
  EXPECT_EQ(found.least.frame, 200);
  EXPECT_EQ(found.least.obstacle, Obstacle::bone);
  EXPECT_NEAR(found.least.point_mm.z(), 0, kTolerance_mm);
  EXPECT_GT((found.least.point_mm - Vec3(0.2, 0.1, 0)).norm(), 8 - kVoxel_mm) << "beside the hole";
  EXPECT_FALSE(found.first_below);
}

TEST(Clearance, CountsRemovedBoneAsRemoved) {
  const Bone bone = phantom_bone(PhantomShape::half_space);
  const SimulationInput scene = scene_of(bone, {0.2, 0.1, 3}, {0.2, 0.1, -10}, {part(kHead_mm, 60, 10)});
  const HolderClearance found = clearance_of(scene);
  ASSERT_EQ(found.frames.size(), 201U);
  double most = 0;
  for (const FrameClearance& here : found.frames) {
    // Under the holder the floor of the hole, at first the face; beside it the rim of the hole, then its wall.
    const double bottom = 3 - 0.065 * static_cast<double>(here.frame) + kHead_mm;
    const bool hole = bottom < kHead_mm;
    const double beside = std::hypot(3, std::max(0.0, bottom));
    const double truth = hole ? std::min(kHead_mm, beside) : bottom;
    most = std::max(most, std::abs(here.mm - truth));
  }
  EXPECT_LT(most, kTolerance_mm);
  EXPECT_NEAR(found.least.mm, 3, kTolerance_mm) << "the wall";
}

TEST(Clearance, OfATiltedConeFromABlockAndOfAShaftBesideASphere) {
  const double tilt = 0.4;
  const Quat tilted(Eigen::AngleAxisd(tilt, Vec3::UnitY()));
  const Bone block = phantom_bone(PhantomShape::half_space);
  // The lowest point of a cone whose lower rim has a radius of 3 mm, 20 mm along the axis.
  const HolderClearance cone = clearance_of(scene_of(block, {0, 0, 20}, {-2, 1, 4}, {part(20, 50, 6, 14)}, tilted));
  EXPECT_NEAR(cone.least.mm, 4 + 20 * std::cos(tilt) - 3 * std::sin(tilt), kTolerance_mm);
  // A shaft that passes a sphere of 15 mm, from -x to +x, upright, 21 mm beside its middle.
  const Bone sphere = phantom_bone(PhantomShape::sphere);
  const HolderClearance shaft =
      clearance_of(scene_of(sphere, {-40, 21, -60}, {40, 21, -60}, {part(10, 20, 4), part(30, 90, 5)}));
  EXPECT_NEAR(shaft.least.mm, 21 - 15 - 2.5, kTolerance_mm);
  EXPECT_EQ(shaft.least.part, 1U);
  EXPECT_NEAR(static_cast<double>(shaft.least.frame), 100, 1);
  EXPECT_LT((shaft.least.point_mm - Vec3(0, 15, 0)).norm(), 1);
}

TEST(Clearance, WarnsOfTooLittle) {
  SimulationInput scene =
      scene_of(phantom_bone(PhantomShape::half_space), {0, 0, 3}, {0, 0, -4}, {part(kHead_mm, 40, 24)});
  scene.scenario.tool.holder[0].name = "handpiece";
  scene.scenario.clearance.least_mm = 3;
  Diagnostics report;
  warn_of_clearance(clearance_of(scene), scene, report);
  ASSERT_EQ(report.warnings.size(), 1U);
  EXPECT_THAT(report.warnings[0],
              testing::StartsWith("clearance of the holder: at least 2.00 mm, handpiece from the bone at ("));
  // 3 mm are left 3 mm below the face.
  EXPECT_THAT(report.warnings[0], testing::HasSubstr("less than clearance.least_mm (3 mm) between frames 172 and 200"));
  scene.scenario.clearance.least_mm = 2 - kTolerance_mm;
  EXPECT_FALSE(clearance_of(scene).first_below);
  // Deeper than the reamer is high: the holder touches, 1.5 mm deep.
  scene.motion = straight({0, 0, 3}, {0, 0, -7.5}, 200, 100, 250);
  const HolderClearance touching = clearance_of(scene);
  EXPECT_NEAR(touching.least.mm, -1.5, kVoxel_mm);
  Diagnostics alarm;
  warn_of_clearance(touching, scene, alarm);
  ASSERT_EQ(alarm.warnings.size(), 1U);
  EXPECT_THAT(alarm.warnings[0], testing::StartsWith("clearance of the holder: none, handpiece touches the bone at ("));
}

TEST(Clearance, FromAnEnvelopeOfSoftTissue) {
  const TempDir dir;
  SimulationInput scene =
      scene_of(phantom_bone(PhantomShape::half_space), {0, 0, 3}, {0, 0, -4}, {part(kHead_mm, 40, 10)});
  // A wall in metres, 12.5 mm from the axis.
  write_stl(dir.path() + "/skin.stl", box_mesh(1e-3 * Vec3(12.5, -30, 5), 1e-3 * Vec3(14, 30, 60)));
  scene.scenario.clearance.envelope = ClearanceEnvelopeSettings{.path = dir.path() + "/skin.stl", .scale = 1000};
  const HolderClearance found = clearance_of(scene);
  // The rim of the hole is nearer at the end: 3 mm beside the holder, 2 mm below it.
  EXPECT_NEAR(found.least.mm, std::hypot(3, 2), kTolerance_mm);
  EXPECT_EQ(found.frames.front().obstacle, Obstacle::envelope);
  EXPECT_NEAR(found.frames.front().mm, 7.5, 1e-3);
  scene.tool.holder[0].diameter_mm = 17;
  const HolderClearance wide = clearance_of(scene);
  EXPECT_EQ(wide.frames.front().obstacle, Obstacle::envelope);
  EXPECT_NEAR(wide.frames.front().mm, 4, 1e-3);
}

TEST(Clearance, IsNoneWithoutAHolderAndTheSameForLongMotions) {
  const Bone bone = phantom_bone(PhantomShape::half_space);
  EXPECT_FALSE(find_clearance(scene_of(bone, {0, 0, 3}, {0, 0, -4}, {})));
  const HolderClearance found =
      clearance_of(scene_of(bone, {0, 0, 3}, {0, 0, -4}, {part(kHead_mm, 40, 24)}, Quat::Identity(), 20'000));
  EXPECT_LT(found.frames.size(), 4001U);
  EXPECT_EQ(found.frames.back().frame, 20'000);
  EXPECT_NEAR(found.least.mm, 2, kTolerance_mm);
}

TEST(Clearance, LaterPassesMeetTheBoneThatEarlierOnesLeave) {
  // The first pass cuts a hole of 8 mm radius; the second one enters it with a holder of 5 mm radius.
  const Bone bone = phantom_bone(PhantomShape::half_space);
  SimulationInput scene = scene_of(bone, {0.2, 0.1, 3}, {0.2, 0.1, -12}, {});
  const SimulationInput second = scene_of(bone, {0.2, 0.1, 3}, {0.2, 0.1, -8}, {part(kHead_mm, 60, 10)});
  scene.scenario.motion.passes = {{scene.scenario.tool, {}}, {second.scenario.tool, {}}};
  scene.later_passes.push_back({second.tool, second.motion});
  scene.later_passes[0].motion.first_frame = scene.motion.last_frame() + 1;
  scene.later_passes[0].motion.pass = 2;
  const HolderClearance found = clearance_of(scene);
  EXPECT_EQ(found.frames.front().frame, scene.motion.last_frame() + 1);
  EXPECT_NEAR(found.frames.front().mm, std::hypot(3, 3 + kHead_mm), kTolerance_mm) << "the rim of the hole";
  EXPECT_EQ(found.least.pass, 2);
  EXPECT_NEAR(found.least.mm, 3, kTolerance_mm) << "its wall";
}

}  // namespace
}  // namespace reamsim::test::clearance_tests
