// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scene/swept_bone.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "render/gl/camera.h"
#include "render/pictures/run_view.h"
#include "render/surface/scalar_grid.h"
#include "sim/tool/profile.h"
#include "tests/render/results_fixture.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

constexpr double kVoxel_mm = 0.5;
constexpr double kRadius_mm = 4;

/// Bone below z = 0: 24 × 24 mm, 10 mm thick.
FilledVoxmap slab() {
  VoxelGrid grid;
  grid.voxel_mm = kVoxel_mm;
  grid.dims = {48, 48, 24};
  grid.origin_mm = {-12, -12, -10};
  FilledVoxmap out(grid);
  for (int k = 0; k < 20; ++k) {
    for (int j = 0; j < 48; ++j) {
      for (int i = 0; i < 48; ++i) out.grade.set({i, j, k}, 100);
    }
  }
  return out;
}

/// A ball that stands on the origin of T.
Profile ball_profile() {
  Profile out;
  constexpr int kEdges = 90;
  for (int i = 0; i <= kEdges; ++i) {
    const double angle = std::numbers::pi * i / kEdges;
    out.points.emplace_back(i == kEdges ? 0 : kRadius_mm * std::sin(angle), kRadius_mm * (1 - std::cos(angle)));
  }
  return out;
}

ToolPose pose_at(const Vec3& position_mm) {
  return {.position_mm = position_mm};
}

double removed_mm3(const BoneView& bone) {
  double sum = 0;
  for_each_bone_voxel(bone, [&](const Vec3i&, std::uint8_t, std::uint16_t fill) {
    sum += 1 - static_cast<double>(fill) / FillBricks::kWhole;
  });
  return sum * bone.voxmap.grid.voxel_mm3();
}

double cap_mm3(double depth_mm) {
  return std::numbers::pi * depth_mm * depth_mm * (3 * kRadius_mm - depth_mm) / 3;
}

TEST(PredictedBoneTest, APlungeTakesTheCapOfItsDeepestPose) {
  const FilledVoxmap bone = slab();
  // By steps of which several go into half a voxel; the deepest pose stands between two others.
  std::vector<ToolPose> poses;
  for (int k = 0; k <= 31; ++k) poses.push_back(pose_at({0.1, 0.2, 1 - 0.1 * k}));
  for (int k = 0; k <= 40; ++k) poses.push_back(pose_at({0.1, 0.2, -2.1 + 0.13 * k}));
  const PredictedBone predicted = predict_swept_bone(bone, bone.fill, ball_profile(), poses, false);
  EXPECT_DOUBLE_EQ(predicted.deepest.position_mm.z(), -2.1);
  EXPECT_NEAR(removed_mm3({bone, predicted.fill}) / cap_mm3(2.1), 1, 0.01);
  const UnreamedSurface unreamed(bone, bone.fill, predicted.fill);
  EXPECT_NEAR(unreamed.deepest_mm, 2.1, 0.05);
}

TEST(PredictedBoneTest, BetweenTwoPosesFarApartTheToolIsEverywhere) {
  const FilledVoxmap bone = slab();
  const PredictedBone predicted =
      predict_swept_bone(bone, bone.fill, ball_profile(), {pose_at({-6, 0, -2}), pose_at({6, 0, -2})}, false);
  // A trench, with half a cap at either end. Its section is the circle's segment.
  const double half = std::acos((kRadius_mm - 2) / kRadius_mm);
  const double segment_mm2 = kRadius_mm * kRadius_mm * (half - std::sin(half) * std::cos(half));
  EXPECT_NEAR(removed_mm3({bone, predicted.fill}) / (12 * segment_mm2 + cap_mm3(2)), 1, 0.01);
}

TEST(PredictedBoneTest, ATiltedToolIsFollowed) {
  const FilledVoxmap bone = slab();
  const Quat tilt(Eigen::AngleAxisd(0.4, Vec3::UnitX()));
  // About the ball's middle, so that nothing but the tool's axis changes.
  const Vec3 middle(0, 0, kRadius_mm - 2);
  ToolPose tilted{.position_mm = middle - kRadius_mm * (tilt * Vec3::UnitZ()), .orientation = tilt};
  const PredictedBone predicted = predict_swept_bone(bone, bone.fill, ball_profile(), {tilted}, false);
  EXPECT_NEAR(removed_mm3({bone, predicted.fill}) / cap_mm3(2), 1, 0.01);
}

TEST(PredictedBoneTest, WhatTheToolNeverMeetsStaysAsItWas) {
  FilledVoxmap bone = slab();
  bone.fill.set({3, 3, 19}, 1000);
  const PredictedBone predicted =
      predict_swept_bone(bone, bone.fill, ball_profile(), {pose_at({0, 0, 9}), pose_at({0, 0, 0.4})}, false);
  EXPECT_EQ(predicted.deepest.position_mm.z(), 9) << "the first pose, as nothing else is known";
  EXPECT_EQ(predicted.fill.get({3, 3, 19}), 1000);
  EXPECT_NEAR(removed_mm3({bone, predicted.fill}), (1 - 1000.0 / FillBricks::kWhole) * bone.grid.voxel_mm3(), 1e-9);
}

TEST(PredictedBoneTest, NeverFillsAgainWhatWasGone) {
  FilledVoxmap bone = slab();
  bone.fill.set({24, 24, 19}, 0);
  bone.fill.set({24, 24, 12}, 30000);
  const PredictedBone predicted =
      predict_swept_bone(bone, bone.fill, ball_profile(), {pose_at({0, 0, 1}), pose_at({0, 0, -1})}, false);
  for_each_bone_voxel(bone, [&](const Vec3i& voxel, std::uint8_t, std::uint16_t fill) {
    ASSERT_LE(predicted.fill.get(voxel), fill) << voxel.transpose();
  });
}

TEST(PredictedBoneTest, ARunIsPredictedAsItHappens) {
  const test::TempDir dir;
  const FixtureTruth truth = write_results(dir.path(), {});
  const RunData run(dir.path());
  const RunInputs& inputs = run.inputs();
  const Voxmap& bone = run.voxmap();
  const Profile tool = envelope_of_revolution(inputs.passes.front().tool).profile;
  std::vector<ToolPose> poses;
  for (const PathSample& at : inputs.passes.front().path) poses.push_back(at.pose);
  const PredictedBone predicted = predict_swept_bone(bone, inputs.fill, tool, poses, inputs.whole_voxels);
  EXPECT_NEAR(removed_mm3({bone, predicted.fill}) / removed_mm3({bone, run.last_fill()}), 1, 0.01);
  EXPECT_NEAR(run.unreamed().deepest_mm, truth.deepest_mm, 0.1);
}

TEST(PredictedBoneTest, WhereVoxelsGoWholeEachOneThatIsTouchedGoes) {
  const FilledVoxmap bone = slab();
  const Vec3 middle(0.13, 0.21, kRadius_mm - 2.2);
  const PredictedBone predicted = predict_swept_bone(bone, bone.fill, ball_profile(),
                                                     {pose_at({0.13, 0.21, 3}), pose_at({0.13, 0.21, -2.2})}, true);
  int wrong = 0, gone = 0;
  for_each_bone_voxel(bone, [&](const Vec3i& voxel, std::uint8_t, std::uint16_t) {
    const Vec3 center = bone.grid.center_mm(voxel);
    // The nearest point of the voxel to the ball's middle. The ball has come from above, where nothing is left to take.
    const Vec3 half = Vec3::Constant(0.5 * kVoxel_mm);
    const Vec3 nearest = middle.cwiseMax(center - half).cwiseMin(center + half);
    const bool touched = (nearest - middle).norm() < kRadius_mm;
    gone += touched ? 1 : 0;
    wrong += predicted.fill.get(voxel) != (touched ? 0 : FillBricks::kWhole) ? 1 : 0;
  });
  EXPECT_GT(gone, 500);
  EXPECT_LT(wrong, 0.01 * gone) << "voxels that the ball meets with a side, not with a corner";
}

/// A cylinder wider than the slab, so that nothing but its floor tells the depth.
double deepest_of_a_flat_cut(double depth_mm, bool whole_voxels) {
  const FilledVoxmap bone = slab();
  const Profile tool{{{0, 0}, {20, 0}, {20, 5}, {0, 5}}};
  const auto poses = {pose_at({0, 0, 1}), pose_at({0, 0, -depth_mm})};
  const PredictedBone predicted = predict_swept_bone(bone, bone.fill, tool, poses, whole_voxels);
  return UnreamedSurface(bone, bone.fill, predicted.fill).deepest_mm;
}

TEST(PredictedBoneTest, TheDepthOfAFlatFloorIsKnownWhereverItLiesInTheLattice) {
  for (const double depth_mm : {0.5, 0.75, 0.9, 1.0, 1.1, 1.25, 2.3}) {
    EXPECT_NEAR(deepest_of_a_flat_cut(depth_mm, false), depth_mm, 0.06) << depth_mm;
  }
  EXPECT_NEAR(deepest_of_a_flat_cut(1.1, true), 1.5, 0.06) << "the voxel that is touched has gone whole";
}

TEST(PredictedBoneTest, WhatAnEarlierRunTookIsReamedToo) {
  FilledVoxmap bone = slab();
  // A pit of 3 mm, far from where the ball comes.
  for (int k = 14; k < 20; ++k) {
    for (int j = 4; j < 16; ++j) {
      for (int i = 4; i < 16; ++i) bone.fill.set({i, j, k}, 0);
    }
  }
  RunInputs inputs;
  inputs.voxmap = std::make_shared<Voxmap>(bone);
  inputs.fill = bone.fill;
  inputs.passes = {{revolve(ball_profile(), 48), {{pose_at({7, 7, 1}), 0}, {pose_at({7, 7, -1}), 1}}}};
  inputs.frames = {0, 1};
  const RunData run(inputs);
  EXPECT_NEAR(run.unreamed().deepest_mm, 3, 0.3);
  const openvdb::Vec3d floor(kVoxel_mm * openvdb::Vec3d(9.5, 9.5, 13.5));
  EXPECT_NEAR(ReamingSampler(run.unreamed(), run.unreamed().field.grid()).depth_mm(floor), 3, 0.3);
}

TEST(PredictedBoneTest, LaterPassesFindTheBoneThatEarlierOnesLeave) {
  const FilledVoxmap bone = slab();
  RunInputs inputs;
  inputs.voxmap = std::make_shared<Voxmap>(bone);
  inputs.fill = bone.fill;
  const TriangleMesh tool = revolve(ball_profile(), 48);
  inputs.passes = {{tool, {{pose_at({0, 0, 1}), 0}, {pose_at({0, 0, -2}), 1}}},
                   {tool, {{pose_at({4, 0, 1}), 2}, {pose_at({4, 0, -1}), 3}}},
                   {tool, {{pose_at({0, 0, 8}), 4}, {pose_at({0, 0, 2}), 5}}}};
  inputs.frames = {0, 3, 5};
  EXPECT_EQ(inputs.pass_at(1), 0u);
  EXPECT_EQ(inputs.pass_at(2), 1u);
  EXPECT_EQ(inputs.pass_at(9), 2u);
  EXPECT_EQ(inputs.pose_at(4).position_mm, Vec3(0, 0, 8));
  const RunData run(inputs);
  EXPECT_NEAR(run.unreamed().deepest_mm, 2, 0.1) << "of the first pass";
  EXPECT_EQ(run.target().bone_from_tool.translation(), Vec3(4, 0, -1)) << "of the last one that removes bone";
}

}  // namespace
}  // namespace reamsim
