// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The glenoid from one point: phantoms of every Walch type, and bones without a face.
#include "sim/anatomy/find_glenoid.h"

#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <iostream>
#include <random>

#include "sim/scenario/parse.h"
#include "tests/bone/phantom_truth.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

BoneSettings walch(Walch type) {
  BoneSettings settings = phantom(PhantomShape::glenoid, 0.5);
  settings.surface_voxels = SurfaceVoxels::partial;
  settings.phantom.walch = type;
  apply_walch_defaults(settings.phantom);
  return settings;
}

/// Phantoms or points of a test. REAMSIM_CAMPAIGN: a longer one.
int draws() {
  return std::getenv("REAMSIM_CAMPAIGN") == nullptr ? 3 : 24;
}

/// Largest distances from the truth over points within 8 mm of the centre.
struct Worst {
  double across_mm = 0, along_mm = 0, normal_deg = 0, superior_deg = 0;
};

/// `truth`: the frame to compare with.
Worst worst_of(const Bone& bone, const Rigid& truth, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Worst worst;
  for (int n = 0; n < draws();) {
    const Vec3 off(uniform(random), uniform(random), uniform(random));
    if (off.norm() > 1) continue;
    ++n;
    GlenoidSettings glenoid;
    glenoid.near_mm = bone.glenoid->bone_from_glenoid.translation() + 8 * off;
    const Rigid found = find_glenoid(bone, glenoid, BodySide::left).frame.bone_from_glenoid;
    const Vec3 away = truth.inverse() * found.translation();
    worst.across_mm = std::max(worst.across_mm, away.head<2>().norm());
    worst.along_mm = std::max(worst.along_mm, std::abs(away.z()));
    worst.normal_deg = std::max(worst.normal_deg, angle_deg(found.linear().col(2), truth.linear().col(2)));
    worst.superior_deg = std::max(worst.superior_deg, angle_deg(found.linear().col(1), truth.linear().col(1)));
  }
  std::cout << "seed " << seed << ": centre " << worst.across_mm << " mm across, " << worst.along_mm
            << " mm along the normal; normal " << worst.normal_deg << " deg, superior " << worst.superior_deg
            << " deg\n";
  return worst;
}

class FindGlenoid : public testing::TestWithParam<Walch> {};

TEST_P(FindGlenoid, FromAPointNearTheCentreOfAPhantom) {
  const Bone bone = make(walch(GetParam()));
  const Worst worst = worst_of(bone, bone.glenoid->bone_from_glenoid, 7);
  EXPECT_LE(std::hypot(worst.across_mm, worst.along_mm), 0.7);
  EXPECT_LE(worst.normal_deg, 1.5);
  EXPECT_LE(worst.superior_deg, 6);
}

INSTANTIATE_TEST_SUITE_P(Walch, FindGlenoid, testing::Values(Walch::none, Walch::a1, Walch::c),
                         [](const auto& chosen) { return name_of(chosen.param); });

/// Axes as those of the phantom, rotated least to the normal of the truth.
Rigid frame_of(const Bone& bone, const FaceTruth& truth) {
  Rigid out = bone.glenoid->bone_from_glenoid;
  out.linear() = smallest_rotation(out.linear().col(2), truth.normal).toRotationMatrix() * out.linear();
  out.translation() = truth.center_mm;
  return out;
}

class FindWornGlenoid : public testing::TestWithParam<Walch> {};

TEST_P(FindWornGlenoid, FromAPointNearTheCentreOfAPhantom) {
  const BoneSettings settings = walch(GetParam());
  const Bone bone = make(settings);
  const Worst worst = worst_of(bone, frame_of(bone, truth_of(settings.phantom)), 7);
  EXPECT_LE(std::hypot(worst.across_mm, worst.along_mm), 0.7);
  EXPECT_LE(worst.normal_deg, 1.5);
}

INSTANTIATE_TEST_SUITE_P(Walch, FindWornGlenoid, testing::Values(Walch::a2, Walch::b2),
                         [](const auto& chosen) { return name_of(chosen.param); });

TEST(FindGlenoid, OfAnyOrientationSizeAndSide) {
  std::mt19937 random(11);
  const auto between = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  for (int n = 0; n < 2 * draws(); ++n) {
    BoneSettings settings = walch(Walch::none);
    settings.side = n % 2 == 0 ? BodySide::left : BodySide::right;
    settings.phantom.version_deg = between(-15, 25);
    settings.phantom.inclination_deg = between(-10, 20);
    settings.phantom.height_mm = between(30, 42);
    settings.phantom.width_mm = between(0.68, 0.8) * settings.phantom.height_mm;
    settings.phantom.face_radius_mm = between(26, 45);
    const Bone bone = make(settings);
    const Rigid truth = bone.glenoid->bone_from_glenoid;
    GlenoidSettings glenoid;
    glenoid.near_mm = truth * Vec3(between(-5, 5), between(-5, 5), between(-3, 3));
    const Rigid found = find_glenoid(bone, glenoid, settings.side).frame.bone_from_glenoid;
    EXPECT_LE((found.translation() - truth.translation()).norm(), 0.7) << n;
    EXPECT_LE(angle_deg(found.linear().col(2), truth.linear().col(2)), 1.5) << n;
  }
}

TEST(FindGlenoid, TakesSuperiorFromTheScenario) {
  const Bone bone = make(walch(Walch::none));
  GlenoidSettings glenoid;
  glenoid.near_mm = Vec3(3, 2, -1);
  glenoid.superior = Vec3(0, -1, 0.2);
  const FoundGlenoid found = find_glenoid(bone, glenoid, BodySide::left);
  const Mat3 axes = found.frame.bone_from_glenoid.linear();
  EXPECT_NEAR(axes.col(1).dot(axes.col(2)), 0, 1e-12);
  EXPECT_LE(angle_deg(axes.col(1), *glenoid.superior), 1);
  EXPECT_GE(found.rim_mm.size(), 40U);
  EXPECT_TRUE(found.doubts.empty());
}

std::string refusal(const Bone& bone, const Vec3& near_mm) {
  GlenoidSettings glenoid;
  glenoid.near_mm = near_mm;
  return input_error([&] { find_glenoid(bone, glenoid, BodySide::left); });
}

TEST(FindGlenoid, RefusesBonesWithoutAFace) {
  EXPECT_THAT(refusal(make(phantom(PhantomShape::sphere, 1)), {0, 0, 20}),
              HasSubstr("bone.glenoid.near_mm: (0.0, 0.0, 20.0): no joint face round the point"));
  EXPECT_THAT(refusal(make(walch(Walch::none)), {40, 0, 0}), HasSubstr("no surface of the bone within 15 mm"));
  EXPECT_THAT(refusal(make(walch(Walch::none)), {-40, 0, -20}), HasSubstr("no joint face round the point"));
}

}  // namespace
}  // namespace reamsim::test
