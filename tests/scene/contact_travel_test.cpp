// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The first contact of a plunge, found beforehand, against closed forms and against the log of a run.
#include <gmock/gmock.h>

#include <cmath>
#include <iostream>

#include "sim/base/error.h"
#include "sim/scene/scene.h"
#include "tests/bone/bone_fixture.h"
#include "tests/engine/outcome.h"

namespace reamsim::test::contact_travel_tests {
namespace {

constexpr double kVoxel_mm = 0.5;
constexpr double kTolerance_mm = 0.1 * kVoxel_mm;

Profile ball(double radius) {
  Profile profile;
  constexpr int kSteps = 400;
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = M_PI * i / kSteps;
    profile.points.emplace_back(i % kSteps == 0 ? 0 : radius * std::sin(angle), radius * (1 - std::cos(angle)));
  }
  return profile;
}

Profile flat(double radius, double bore = 0) {
  return Profile{{{bore, 0}, {radius, 0}, {radius, 6}, {bore, 6}}};
}

Bone phantom_bone(PhantomShape shape, SurfaceVoxels voxels = SurfaceVoxels::partial) {
  BoneSettings settings = phantom(shape, kVoxel_mm);
  settings.surface_voxels = voxels;
  settings.phantom.size_mm = {40, 40, 12};
  settings.phantom.radius_mm = 15;
  return make(settings);
}

/// A phantom's sphere, or a plane below z = 0 turned about the origin, sampled on the lattice.
Bone tilted_block(const Quat& turned, double height_mm) {
  VoxelGrid grid{{80, 80, 60}, kVoxel_mm, {-20.1, -19.8, -14.9}};
  FilledVoxmap voxmap(grid);
  const Vec3 normal = turned * Vec3::UnitZ();
  const float n[3] = {static_cast<float>(normal.x()), static_cast<float>(normal.y()), static_cast<float>(normal.z())};
  for_each_voxel(grid.dims, [&](const Vec3i& voxel) {
    const double away = (normal.dot(grid.center_mm(voxel)) - height_mm) / kVoxel_mm;
    if (away > RS_CLIP_REACH) return;
    const double fraction = away < -RS_CLIP_REACH ? 1 : 1 - double{rs_outside_fraction(n, static_cast<float>(away))};
    if (std::lround(fraction * 65535) == 0) return;
    voxmap.grade.set(voxel, 100);
    voxmap.fill.set(voxel, static_cast<std::uint16_t>(std::lround(fraction * 65535)));
  });
  return Bone(std::move(voxmap));
}

double travel(const Bone& bone, const Profile& tool, const Vec3& through = Vec3::Zero(),
              const Vec3& axis = {0, 0, -1}) {
  const auto found = find_first_contact(bone, tool, through, axis.normalized());
  return found ? found->travel_mm : NAN;
}

TEST(ContactTravel, OnAHalfSpace) {
  const Bone bone = phantom_bone(PhantomShape::half_space);
  for (const Profile& tool : {ball(6), flat(7), flat(7, 1.2), cap_profile(29, 16, 6, 1.25)}) {
    // The bored cap begins at its bore's rim.
    const double low = tool.points.front().y();
    EXPECT_NEAR(travel(bone, tool, {1.3, -0.7, 3.2}), 3.2 + low, 1e-6);
    EXPECT_NEAR(travel(bone, tool, {1.3, -0.7, -4}), -4 + low, 1e-6) << "an entry within the bone changes nothing";
  }
}

TEST(ContactTravel, OfATiltedPlungeIntoAHalfSpace) {
  const Bone bone = phantom_bone(PhantomShape::half_space);
  for (const double tilt : {0.05, 0.2, 0.5}) {
    const Vec3 axis(std::sin(tilt), 0, -std::cos(tilt));
    // The ball's middle is R from the face at contact; the lowest point of the flat reamer is its rim.
    EXPECT_NEAR(travel(bone, ball(6), {0, 0.3, 5}, axis), (5 + 6 * std::cos(tilt) - 6) / std::cos(tilt), kTolerance_mm);
    EXPECT_NEAR(travel(bone, flat(7), {0, 0.3, 5}, axis), (5 - 7 * std::sin(tilt)) / std::cos(tilt), kTolerance_mm);
  }
}

TEST(ContactTravel, OnAPlaneAskewToTheVoxels) {
  double most = 0;
  for (int i = 0; i < 24; i += 3) {
    const Quat turned(Eigen::AngleAxisd(0.1 + 0.03 * i, Vec3(std::sin(i), std::cos(i), 0.2 * i - 2).normalized()));
    const double height = 0.05 * i;
    const Bone bone = tilted_block(turned, height);
    const Vec3 normal = turned * Vec3::UnitZ();
    // Square onto the face.
    most = std::max(most, std::abs(travel(bone, ball(6), 3 * normal, -normal) - (3 - height)));
    most = std::max(most, std::abs(travel(bone, flat(5), 3 * normal, -normal) - (3 - height)));
    // Along z.
    const double cosine = normal.z(), sine = std::hypot(normal.x(), normal.y());
    most = std::max(most, std::abs(travel(bone, ball(6), {0, 0, 9}) - (9 + 6 - (height + 6) / cosine)));
    most = std::max(most, std::abs(travel(bone, flat(5), {0, 0, 9}) - (9 - (height + 5 * sine) / cosine)));
  }
  EXPECT_LT(most, kTolerance_mm);
}

TEST(ContactTravel, OnASphere) {
  const Bone bone = phantom_bone(PhantomShape::sphere);  // of 15 mm
  double most = 0;
  for (int i = 0; i < 24; i += 2) {
    const Vec3 axis = Vec3(std::sin(2 * i), std::cos(3 * i), std::sin(5 * i + 1)).normalized();
    const Vec3 across = axis.unitOrthogonal();
    const double aside = 0.2 * i;
    const Vec3 through = aside * across - 30 * axis;
    // The middles of two balls are R + r apart at contact.
    const double middle = 30 - std::sqrt(21.0 * 21 - aside * aside);
    most = std::max(most, std::abs(travel(bone, ball(6), through, axis) - (middle + 6)));
    // The flat reamer is wider than it is aside: it touches the pole.
    most = std::max(most, std::abs(travel(bone, flat(7), through, axis) - 15));
    // Where it is farther aside than it is wide, its rim touches.
    const double rim = 9 + 0.1 * i;
    most = std::max(most, std::abs(travel(bone, flat(3), rim * across, axis) + std::sqrt(225 - (rim - 3) * (rim - 3))));
  }
  EXPECT_LT(most, kTolerance_mm);
}

TEST(ContactTravel, OnTheGlenoidPhantom) {
  BoneSettings settings = phantom(PhantomShape::glenoid, kVoxel_mm);
  settings.surface_voxels = SurfaceVoxels::partial;
  const Bone bone = make(settings);
  const Rigid& frame = bone.glenoid->bone_from_glenoid;
  const double face = settings.phantom.face_radius_mm;
  const auto find = [&](const Profile& tool) {
    return travel(bone, tool, frame * Vec3(0, 0, 0), -frame.linear().col(2));
  };
  // Within the face, whose sphere is wider than the tools: a flat reamer rests on its rim, a ball in the middle.
  const double radius = 10;
  EXPECT_NEAR(find(flat(radius)), -(face - std::sqrt(face * face - radius * radius)), kTolerance_mm);
  EXPECT_NEAR(find(ball(12)), 0, kTolerance_mm);
}

/// A half space below z = 0 with a hole of the shape of a tool, `depth_mm` deep; the fractions are of 8³ points.
Bone with_hole(const Profile& tool, double depth_mm) {
  VoxelGrid grid{{34, 34, 14}, kVoxel_mm, {-8.6, -8.3, -5.9}};
  FilledVoxmap voxmap(grid);
  constexpr int kParts = 8;
  const auto is_bone = [&](const Vec3& p) {
    const double r = p.head<2>().norm();
    double low = NAN;
    for (std::size_t i = 0; i + 1 < tool.points.size() && std::isnan(low); ++i) {
      const Vec2 &a = tool.points[i], &b = tool.points[i + 1];
      if (b.x() > a.x() && r >= a.x() && r <= b.x()) low = a.y() + (b.y() - a.y()) * (r - a.x()) / (b.x() - a.x());
    }
    return p.z() < 0 && !(p.z() >= low - depth_mm);
  };
  for_each_voxel(grid.dims, [&](const Vec3i& voxel) {
    int inside = 0;
    for_each_voxel(Vec3i::Constant(kParts), [&](const Vec3i& part) {
      const Vec3 off = (part.cast<double>() + Vec3::Constant(0.5)) / kParts - Vec3::Constant(0.5);
      inside += is_bone(grid.center_mm(voxel) + kVoxel_mm * off) ? 1 : 0;
    });
    if (inside == 0) return;
    voxmap.grade.set(voxel, 100);
    voxmap.fill.set(voxel, static_cast<std::uint16_t>(std::lround(65535.0 * inside / (kParts * kParts * kParts))));
  });
  return Bone(std::move(voxmap));
}

TEST(ContactTravel, InAHoleOfTheSameReamerIsItsFloor) {
  double most = 0;
  for (const Profile& tool : {flat(7), ball(6), cap_profile(29, 11, 6, 0)}) {
    for (const double depth : {1.3, 3.0}) {
      const double found = travel(with_hole(tool, depth), tool, {0, 0, 2});
      most = std::max(most, std::abs(found - (2 + depth)) / kVoxel_mm);
    }
  }
  std::cout << "largest error " << most << " voxels\n";
  EXPECT_LT(most, 1.1) << "the rim counts within a voxel of the floor";
}

TEST(ContactTravel, OnACornerThatNoCoarseRayMeets) {
  const Bone block = phantom_bone(PhantomShape::half_space);
  for (const double overlap_mm : {0.25, 0.3, 0.35, 0.6}) {
    const double beside_mm = 20 + (7 - overlap_mm) / std::sqrt(2.0);
    EXPECT_NEAR(travel(block, flat(7), {beside_mm, beside_mm, 2}), 2, kTolerance_mm) << overlap_mm;
  }
}

/// A half space with a hole of 6 mm diameter, 8 mm deep.
Bone drilled_block() {
  BoneSettings settings = phantom(PhantomShape::half_space, kVoxel_mm);
  settings.surface_voxels = SurfaceVoxels::partial;
  settings.phantom.size_mm = {40, 40, 12};
  settings.pilot_hole = PilotHoleSettings{.diameter_mm = 6, .depth_mm = 8};
  Diagnostics report;
  return load_bone(settings, report);
}

TEST(ContactTravel, SeesWholeVoxelsAsCubesAndPilotHoles) {
  const Bone whole = phantom_bone(PhantomShape::sphere, SurfaceVoxels::whole);
  const double found = travel(whole, flat(7), {0, 0, 20});
  EXPECT_NEAR(std::remainder(found - 20, kVoxel_mm), 0, 1e-6) << "a face of the lattice";
  const Bone drilled = drilled_block();
  // The ball rests on the edge of the hole.
  EXPECT_NEAR(travel(drilled, ball(6)), 6 - std::sqrt(36.0 - 9), 0.15 * kVoxel_mm);
  EXPECT_NEAR(travel(drilled, ball(2)), 8, kTolerance_mm) << "the bottom of the hole";
}

TEST(ContactTravel, WithoutBoneOnTheLineIsAMistakeAtTheEntry) {
  const Bone bone = phantom_bone(PhantomShape::half_space);
  Tool tool;
  tool.profile = flat(7);
  PlungeSettings plunge;
  plunge.entry_mm = {27.2, 0, 5};
  const auto contact = [&](const Bone& with) {
    return find_first_contact(with, tool, plunge.entry_mm, plunge.axis, PoseFrame::bone);
  };
  EXPECT_THAT(input_error([&] { contact(bone); }),
              testing::StartsWith("motion.plunge.entry_mm: the tool meets no bone on the line of the plunge"));
  plunge.entry_mm.x() = 26.9;
  EXPECT_NEAR(contact(bone).travel_mm, 5, kTolerance_mm);
  EXPECT_THAT(input_error([&] { contact(Bone(FilledVoxmap(bone.voxmap->grid))); }),
              testing::HasSubstr("meets no bone"));
}

/// The plunge of `tool` counted from contact, as a run logs it; the tool depth of its last frame.
double logged_depth(const Bone& bone, const Profile& profile, const Vec3& axis, double depth) {
  SimulationInput scene;
  scene.scenario = quiet_scenario("auto");
  scene.scenario.cutting.erosion = ErosionMode::exact;
  scene.bone = bone;
  scene.tool = make_tool(profile, 64);
  PlungeSettings plunge;
  plunge.axis = axis;
  plunge.entry_mm = {0.3, -0.2, 2};
  plunge.approach_mm = 0.7;
  plunge.depth_mm = depth;
  plunge.retract_mm = 0;
  plunge.from = PlungeStart::contact;
  scene.scenario.motion.plunge = plunge;
  scene.scenario.motion.frame_rate_hz = 200;
  MotionSettings counted = scene.scenario.motion;
  count_from(find_first_contact(bone, scene.tool, plunge.entry_mm, axis, PoseFrame::bone), *counted.plunge);
  Diagnostics report;
  scene.motion = build_motion(counted, {}, report);
  return run(scene).totals.max_depth_mm;
}

TEST(ContactTravel, TheLogCountsTheSameDepth) {
  const Bone block = phantom_bone(PhantomShape::half_space), round = phantom_bone(PhantomShape::sphere);
  for (const Vec3& axis : {Vec3(0, 0, -1), Vec3(0.2, 0.1, -1), Vec3(0.3, -0.5, -1)}) {
    for (const Profile& tool : {ball(6), flat(7), cap_profile(29, 16, 6, 1.25)}) {
      EXPECT_NEAR(logged_depth(block, tool, axis, 2), 2, kTolerance_mm);
      EXPECT_NEAR(logged_depth(round, tool, axis, 2), 2, kTolerance_mm);
    }
  }
}

// Where contact begins at an edge of the bone or of the tool, the planes of both cross in the voxel that is touched.
TEST(ContactTravel, TheLogCountsFromTheEdgeOfAHole) {
  const Bone drilled = drilled_block();
  for (const Profile& tool : {ball(6), cap_profile(12, 16, 6, 0)}) {
    EXPECT_NEAR(logged_depth(drilled, tool, {0, 0, -1}, 2), 2, 0.2 * kVoxel_mm);
  }
}

// A frame advances by two voxels here; the depth counts from the first of its substeps that touches.
TEST(ContactTravel, OfFastFramesTheLogCountsFromTheSubstep) {
  SimulationInput scene;
  scene.scenario = quiet_scenario("auto");
  scene.scenario.cutting.erosion = ErosionMode::exact;
  scene.bone = phantom_bone(PhantomShape::half_space);
  scene.tool = make_tool(flat(7), 64);
  scene.motion.frame_rate_hz = 20;
  std::vector<ToolPose> poses;
  for (int k = 0; k <= 6; ++k) {
    poses.push_back({.position_mm = {0, 0, 0.75 - k}, .orientation = Quat::Identity(), .spin_rpm = 250});
  }
  scene.motion.poses = PoseSequence(std::move(poses));
  const double depth_mm = run(scene).totals.max_depth_mm;
  EXPECT_GE(depth_mm, 5.25 - kTolerance_mm);
  EXPECT_LE(depth_mm, 5.25 + scene.scenario.engine.max_step_voxels * kVoxel_mm);
}

}  // namespace
}  // namespace reamsim::test::contact_travel_tests
