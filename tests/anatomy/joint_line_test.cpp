// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Orientation and place of the joint face, before and after reaming, against what the phantoms are made of.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <iostream>
#include <tuple>

#include "sim/bone/bone.h"
#include "sim/scenario/parse.h"
#include "sim/scene/load_bone.h"
#include "tests/anatomy/reamed_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

constexpr double kReamerCurvature_mm = 29;
constexpr double kReamerRadius_mm = 15;
constexpr double kCannula_mm = 1.25;

/// A glenoid phantom that can be reamed.
struct Glenoid {
  explicit Glenoid(const BoneSettings& settings) {
    Diagnostics report;
    bone = load_bone(settings, report);
  }

  /// A direction out of the face with this version and inclination, in B.
  [[nodiscard]] Vec3 direction(const FaceAngles& angles) const {
    const double v = angles.version_deg * kDegree;
    const double i = angles.inclination_deg * kDegree;
    return std::cos(v) * std::cos(i) * bone.scapula->lateral + std::sin(i) * bone.scapula->superior -
           std::sin(v) * std::cos(i) * bone.scapula->anterior;
  }
  [[nodiscard]] Vec3 center() const { return bone.landmarks->glenoid_center_mm; }

  void ream(const Solid& solid) {
    std::vector<std::pair<Vec3i, std::uint16_t>> changed;
    for_each_bone_voxel(bone, [&](const Vec3i& voxel, std::uint8_t, std::uint16_t fill) {
      const VoxelGrid& grid = bone.voxmap->grid;
      const Vec3 place = grid.center_mm(voxel);
      const double outside = fraction_outside(solid, place, grid.voxel_mm);
      const auto most = static_cast<std::uint16_t>(std::lround(outside * FillBricks::kWhole));
      if (most < fill) changed.emplace_back(voxel, most);
    });
    for (const auto& [voxel, fill] : changed) bone.fill.set(voxel, fill);
  }
  /// The convex reamer with a bore, its lowest point at `apex`, looking along `axis` out of the bone.
  void ream_convex(const Vec3& apex, const Vec3& axis) {
    ream(without(both(cap_along(apex, axis), rod(apex, axis, kReamerRadius_mm)), rod(apex, axis, kCannula_mm)));
    pose.linear() = smallest_rotation(Vec3::UnitZ(), axis).toRotationMatrix();
    pose.translation() = apex;
  }
  static Solid cap_along(const Vec3& apex, const Vec3& axis) {
    return ball(apex + kReamerCurvature_mm * axis, kReamerCurvature_mm);
  }

  [[nodiscard]] BoneAxes axes() const {
    BoneAxes out{.scapula = bone.scapula, .glenoid = {}};
    out.face_center_mm = center();
    out.rim_mm = bone.rim_mm;
    return out;
  }
  [[nodiscard]] BoneMetrics measure(const BoneAxes& known, const MetricSettings& settings = {}) const {
    return measure_bone(bone, pose, known, settings);
  }
  [[nodiscard]] BoneMetrics measure() const { return measure(axes()); }

  Bone bone;
  Rigid pose = Rigid::Identity();
};

BoneSettings glenoid(Walch walch, BodySide side, double version, double inclination, double voxel_mm) {
  BoneSettings out;
  out.source = BoneSource::phantom;
  out.side = side;
  out.voxel_mm = voxel_mm;
  out.surface_voxels = SurfaceVoxels::partial;
  out.phantom.shape = PhantomShape::glenoid;
  out.phantom.walch = walch;
  apply_walch_defaults(out.phantom);
  out.phantom.version_deg = version;
  out.phantom.inclination_deg = inclination;
  return out;
}

void expect_angles(const Measured<FaceAngles>& found, const FaceAngles& expected, double tolerance_deg) {
  ASSERT_TRUE(found.value) << found.reason;
  EXPECT_NEAR(found.value->version_deg, expected.version_deg, tolerance_deg);
  EXPECT_NEAR(found.value->inclination_deg, expected.inclination_deg, tolerance_deg);
}

using Case = std::tuple<Walch, BodySide, FaceAngles>;

class SphericalFace : public ::testing::TestWithParam<Case> {};

/// How far a line from `on_line` along −`along` goes until it leaves a sphere: the sphere's surface on the bone's side.
double down_to_sphere(const Vec3& on_line, const Vec3& along, const Vec3& center, double radius) {
  const Vec3 from = on_line - center;
  const double at = from.dot(along);
  return at + std::sqrt(at * at - from.squaredNorm() + radius * radius);
}

/// The reams of one phantom: along the face's own axis, and an eccentric one.
TEST_P(SphericalFace, NativeAndReamedAngles) {
  const auto& [walch, side, native] = GetParam();
  for (const auto& [turn, depth_mm] : {std::pair{FaceAngles{0, 0}, 1.5}, {FaceAngles{-10, -4}, 2.5}}) {
    SCOPED_TRACE("turned by " + std::to_string(turn.version_deg));
    Glenoid phantom(glenoid(walch, side, native.version_deg, native.inclination_deg, 0.5));
    const FaceAngles aim{native.version_deg + turn.version_deg, native.inclination_deg + turn.inclination_deg};
    const Vec3 axis = phantom.direction(aim);
    const Vec3 apex = phantom.center() - depth_mm * axis + 0.4 * phantom.bone.scapula->anterior;
    phantom.ream_convex(apex, axis);
    const BoneMetrics found = phantom.measure();
    ASSERT_TRUE(found.orientation && found.joint_line && found.joint_line->native_face);
    EXPECT_TRUE(found.joint_line->native_face->surface->spherical);
    EXPECT_TRUE(found.joint_line->reamed_surface->spherical);
    expect_angles(found.orientation->native, native, 0.1);
    expect_angles(found.orientation->reamed, aim, 0.1);
    ASSERT_TRUE(found.orientation->corrected.value) << found.orientation->corrected.reason;
    EXPECT_NEAR(found.orientation->corrected.value->version_deg, -turn.version_deg, 0.1);
    EXPECT_NEAR(found.orientation->corrected.value->inclination_deg, -turn.inclination_deg, 0.1);
    // The Friedman axis meets the native face in its centre, and then the reamer's sphere.
    ASSERT_TRUE(found.joint_line->medialization_mm.value) << found.joint_line->medialization_mm.reason;
    const double closed_form_mm = down_to_sphere(phantom.center(), phantom.bone.scapula->lateral,
                                                 apex + kReamerCurvature_mm * axis, kReamerCurvature_mm);
    EXPECT_NEAR(*found.joint_line->medialization_mm.value, closed_form_mm, 0.05);
    std::cout << name_of(walch) << ' ' << name_of(side) << ": native " << found.orientation->native.value->version_deg
              << '/' << found.orientation->native.value->inclination_deg << ", reamed "
              << found.orientation->reamed.value->version_deg << '/' << found.orientation->reamed.value->inclination_deg
              << " (" << aim.version_deg << '/' << aim.inclination_deg << "), medialization "
              << *found.joint_line->medialization_mm.value << " (" << closed_form_mm << ")\n";
  }
}

/// Wear moves the joint line by what the scenario says: from the face before wear, through the origin of B.
TEST_P(SphericalFace, TheNativeJointLineIsWhereWearHasMovedIt) {
  const auto& [walch, side, native] = GetParam();
  const BoneSettings settings = glenoid(walch, side, native.version_deg, native.inclination_deg, 0.5);
  const Glenoid phantom(settings);
  const auto outline = FaceOutline::of(phantom.bone.rim_mm, phantom.bone.scapula->lateral);
  ASSERT_TRUE(outline);
  const NativeFace face = measure_native_face(phantom.bone, *outline);
  const Vec3& lateral = phantom.bone.scapula->lateral;
  const auto meets = meeting_point(*face.surface, Vec3::Zero(), lateral);
  ASSERT_TRUE(meets);
  const bool worn = walch == Walch::a1 || walch == Walch::a2;
  EXPECT_NEAR(-meets->dot(lateral), worn ? settings.phantom.medialization_mm : 0, 0.05);
  EXPECT_NEAR(face.surface->sphere->radius_mm, worn ? settings.phantom.wear_radius_mm : settings.phantom.face_radius_mm,
              0.1);
}

INSTANTIATE_TEST_SUITE_P(
    Phantoms, SphericalFace,
    ::testing::Values(Case{Walch::none, BodySide::left, {5, 6}}, Case{Walch::none, BodySide::right, {12, -3}},
                      Case{Walch::a1, BodySide::left, {15, 8}}, Case{Walch::a1, BodySide::right, {5, 6}},
                      Case{Walch::a2, BodySide::right, {15, 8}}, Case{Walch::a2, BodySide::left, {12, -3}},
                      Case{Walch::c, BodySide::left, {37, 3}}));

/// A phantom at 5°/6°, reamed along its own axis.
Glenoid reamed_phantom(double voxel_mm = 0.5) {
  Glenoid out(glenoid(Walch::none, BodySide::left, 5, 6, voxel_mm));
  const Vec3 axis = out.direction({5, 6});
  out.ream_convex(out.center() - 1.5 * axis, axis);
  return out;
}

TEST(JointLine, AnImplantOnTheReamedFace) {
  // Native 5°/6°, reamed and implanted at −3°/2°; the back fits the reamer, so that the implant rests where it cut.
  Glenoid phantom(glenoid(Walch::none, BodySide::left, 5, 6, 0.5));
  const Vec3 axis = phantom.direction({-3, 2});
  const Vec3 apex = phantom.center() - 2.5 * axis;
  phantom.ream_convex(apex, axis);
  MetricSettings settings;
  settings.implant = ImplantSettings{.backside_radius_mm = kReamerCurvature_mm, .diameter_mm = 20};
  for (const double thickness : {0.0, 4.0}) {
    settings.implant->thickness_mm = thickness;
    const auto found = phantom.measure(phantom.axes(), settings).planning;
    ASSERT_TRUE(found);
    EXPECT_NEAR((found->bone_from_implant.translation() - apex).norm(), 0, 0.05);
    expect_angles(found->native, {5, 6}, 0.1);
    expect_angles(found->planned, {-3, 2}, 1e-6);
    expect_angles(found->corrected, {8, 4}, 0.1);
    ASSERT_TRUE(found->medialization_mm.value) << found->medialization_mm.reason;
    const double closed_form_mm = down_to_sphere(phantom.center(), phantom.bone.scapula->lateral,
                                                 apex + (kReamerCurvature_mm + thickness) * axis, kReamerCurvature_mm);
    EXPECT_NEAR(*found->medialization_mm.value, closed_form_mm, 0.05) << "thickness " << thickness;
  }
}

TEST(JointLine, AreaOfTheNativeFace) {
  Block block({40, 40, 12}, kVoxel, 1.8);
  block.ream(cap({0.1, 0.2, -4}, 32));
  block.before = block.after.fill;
  block.ream(both(cap({0.1, 0.2, -5}, kReamerCurvature_mm), rod({0.1, 0.2, 0}, Vec3::UnitZ(), 9)));
  const auto cap_area = [](double out_to) { return 2 * kPi * 32 * (32 - std::sqrt(32 * 32 - out_to * out_to)); };
  BoneAxes axes;
  for (int i = 0; i < 60; ++i) {
    axes.rim_mm.emplace_back(0.1 + 14 * std::cos(i * kPi / 30), 0.2 + 14 * std::sin(i * kPi / 30), -0.8);
  }
  const JointLine found = *block.measure(Rigid::Identity(), {}, axes).joint_line;
  EXPECT_NEAR(found.native_face->area_mm2, cap_area(14), 0.01 * cap_area(14));
  EXPECT_NEAR(*found.reamed_fraction.value, cap_area(9) / cap_area(14), 0.02);
  EXPECT_NEAR(found.native_face->surface->sphere->radius_mm, 32, 0.05);
}

TEST(JointLine, ARimGivenByHand) {
  const Glenoid phantom = reamed_phantom();
  BoneAxes axes = phantom.axes();
  std::vector<Vec3> some;
  for (std::size_t i = 0; i < axes.rim_mm.size(); i += 10) some.push_back(axes.rim_mm[i] + Vec3(0.4, -0.3, 0.2));
  axes.rim_mm = some;
  const BoneMetrics found = phantom.measure(axes);
  expect_angles(found.orientation->native, {5, 6}, 0.1);
  std::reverse(axes.rim_mm.begin(), axes.rim_mm.end());
  expect_angles(phantom.measure(axes).orientation->native, {5, 6}, 0.1);
}

TEST(JointLine, WholeVoxelsAreStepsRoundTheSameFace) {
  BoneSettings settings = glenoid(Walch::none, BodySide::left, 5, 6, 0.5);
  settings.surface_voxels = SurfaceVoxels::whole;
  Glenoid phantom(settings);
  const Vec3 axis = phantom.direction({5, 6});
  phantom.ream_convex(phantom.center() - 1.5 * axis, axis);
  expect_angles(phantom.measure().orientation->native, {5, 6}, 0.3);
}

TEST(JointLine, WithoutARimThereIsNoNativeFace) {
  const Glenoid phantom = reamed_phantom();
  BoneAxes axes = phantom.axes();
  axes.rim_mm.clear();
  const BoneMetrics found = phantom.measure(axes);
  EXPECT_FALSE(found.orientation->native.value);
  EXPECT_THAT(found.orientation->native.reason, HasSubstr("bone.glenoid.rim_mm"));
  expect_angles(found.orientation->reamed, {5, 6}, 0.1);
  EXPECT_THAT(found.orientation->corrected.reason, HasSubstr("native face: the rim"));
  EXPECT_THAT(found.joint_line->medialization_mm.reason, HasSubstr("native face: the rim"));
  EXPECT_THAT(found.joint_line->reamed_fraction.reason, HasSubstr("the rim"));
}

TEST(JointLine, WithoutLandmarksOnlyTheChangeIsKnown) {
  Glenoid phantom(glenoid(Walch::none, BodySide::right, 5, 6, 0.5));
  const Vec3 axis = phantom.direction({1, 6});
  phantom.ream_convex(phantom.center() - 2 * axis, axis);
  BoneAxes axes = phantom.axes();
  axes.glenoid = axes_of(*phantom.bone.glenoid, BodySide::right);
  axes.scapula.reset();
  const BoneMetrics found = phantom.measure(axes);
  EXPECT_FALSE(found.orientation->native.value || found.orientation->reamed.value);
  EXPECT_THAT(found.orientation->native.reason, HasSubstr("bone.glenoid.landmarks"));
  ASSERT_TRUE(found.orientation->corrected.value) << found.orientation->corrected.reason;
  EXPECT_NEAR(found.orientation->corrected.value->version_deg, 4, 0.1);
  EXPECT_THAT(found.joint_line->medialization_mm.reason, HasSubstr("landmarks"));
}

/// Only the reamer's edge meets the face: what it leaves is too little to tell an axis from, or tells the right one.
TEST(JointLine, AFaceThatIsHardlyReamedSaysNothingWrong) {
  int measured = 0;
  int half_reamed = 0;
  for (const double beside_mm : {6.0, 12.0, 17.0, 20.0}) {
    Glenoid phantom(glenoid(Walch::none, BodySide::left, 5, 6, 0.5));
    const FaceAngles aim{-12, 6};
    const Vec3 axis = phantom.direction(aim);
    phantom.ream_convex(phantom.center() - 2 * axis + beside_mm * phantom.bone.scapula->anterior, axis);
    const BoneMetrics found = phantom.measure();
    if (!found.orientation) continue;  // met nothing
    SCOPED_TRACE("beside by " + std::to_string(beside_mm));
    if (found.orientation->reamed.value) {
      expect_angles(found.orientation->reamed, aim, 0.3);
      ++measured;
    } else {
      EXPECT_FALSE(found.orientation->reamed.reason.empty());
    }
    const Measured<double>& medial = found.joint_line->medialization_mm;
    EXPECT_TRUE(beside_mm < 15 || !medial.value);
    const Measured<FaceAngles>& corrected = found.orientation->corrected;
    if (found.orientation->reamed.value && *found.joint_line->reamed_fraction.value < 0.5) {
      EXPECT_FALSE(corrected.value);
      EXPECT_THAT(corrected.reason, HasSubstr("% of the face was reamed"));
      ++half_reamed;
    }
    EXPECT_NE(medial.value.has_value(), !medial.reason.empty());
  }
  EXPECT_GT(measured, 0);
  EXPECT_GT(half_reamed, 0);
}

/// A plate 3 mm thick with a glenoid's frame, and a face 30 mm wide on top.
BoneAxes plate_axes() {
  BoneAxes out{.scapula = ScapularAxes{.lateral = Vec3::UnitZ(), .superior = Vec3::UnitY(), .anterior = -Vec3::UnitX()},
               .glenoid = {}};
  out.face_center_mm = Vec3::Zero();
  for (int i = 0; i < 12; ++i) out.rim_mm.emplace_back(15 * std::cos(i * kPi / 6), 15 * std::sin(i * kPi / 6), 0);
  return out;
}

TEST(JointLine, AFlatFaceHasTheNormalOfItsPlane) {
  Block block({40, 40, 10}, kVoxel, 1.8);
  const Vec3 normal = Vec3(std::sin(8 * kDegree), 0, std::cos(8 * kDegree));
  block.ream(both(above_plane({0.1, 0, -2.2}, normal), rod({0.1, 0, -2.2}, normal, 13)));
  Rigid pose = Rigid::Identity();
  pose.linear() = smallest_rotation(Vec3::UnitZ(), normal).toRotationMatrix();
  pose.translation() = Vec3(0.1, 0, -2.2);
  const BoneMetrics found = block.measure(pose, {}, plate_axes());
  EXPECT_FALSE(found.joint_line->native_face->surface->spherical || found.joint_line->reamed_surface->spherical);
  expect_angles(found.orientation->native, {0, 0}, 0.02);
  expect_angles(found.orientation->reamed, {8, 0}, 0.02);
  EXPECT_NEAR(*found.joint_line->medialization_mm.value, 2.2 - 0.1 * std::tan(8 * kDegree), 0.02);
  EXPECT_NEAR(found.joint_line->native_face->area_mm2, 12 * 225 * std::sin(kPi / 6) / 2, 0.02 * 675);
}

TEST(JointLine, APerforatedFaceHasNoJointLineInItsHole) {
  Block block({40, 40, 3}, kVoxel, 1.8);
  block.ream(both(cap({0, 0, -3.6}, kReamerCurvature_mm), rod({0, 0, 0}, Vec3::UnitZ(), kReamerRadius_mm)));
  Rigid pose = Rigid::Identity();
  pose.translation() = Vec3(0, 0, -3.6);
  const BoneMetrics found = block.measure(pose, {}, plate_axes());
  EXPECT_GT(found.perforation->holes, 0);
  EXPECT_FALSE(found.joint_line->medialization_mm.value);
  EXPECT_THAT(found.joint_line->medialization_mm.reason, HasSubstr("perforated"));
  // What is left of the face is still part of the reamer's sphere.
  expect_angles(found.orientation->reamed, {0, 0}, 0.1);
}

/// A reamer that went two ways leaves two faces, and no axis.
TEST(JointLine, TwoFacesHaveNoAxis) {
  Block block({50, 40, 12}, kVoxel, 1.8);
  const Vec3 left = Vec3(-0.5, 0, 1).normalized();
  const Vec3 right = Vec3(0.5, 0, 1).normalized();
  const Solid both_sides = [=](const Vec3& p) {
    return std::max(-(p - Vec3(0, 0, -6)).dot(left), -(p - Vec3(0, 0, -6)).dot(right));
  };
  block.ream(both(both_sides, rod({0, 0, 0}, Vec3::UnitZ(), 14)));
  const BoneMetrics found = block.measure(Rigid::Identity(), {}, plate_axes());
  ASSERT_TRUE(found.orientation);
  EXPECT_FALSE(found.orientation->reamed.value);
  EXPECT_THAT(found.orientation->reamed.reason, HasSubstr("not a single sphere or plane"));
}

/// One sphere through two leans beyond both of them: there is no native axis.
TEST(JointLine, ABiconcaveFaceIsNoSphere) {
  Glenoid phantom(glenoid(Walch::b2, BodySide::left, 8, 8, 0.5));
  const Vec3 axis = phantom.direction({12, 6});
  phantom.ream_convex(phantom.center() - 2 * axis, axis);
  const BoneMetrics found = phantom.measure();
  EXPECT_FALSE(found.orientation->native.value);
  EXPECT_THAT(found.orientation->native.reason, HasSubstr("not a single sphere or plane"));
  expect_angles(found.orientation->reamed, {12, 6}, 0.1);
  EXPECT_GT(*found.joint_line->reamed_fraction.value, 0.5);
}

TEST(FaceSurface, StandsUpToAFifthOfWrongPoints) {
  FacePoints face{.points_mm = {}, .point_mm2 = 0.25, .voxel_mm = 0.25};
  const Vec3 center(3, -2, 30);
  int n = 0;
  for (double x = -10; x <= 10; x += 0.5) {
    for (double y = -10; y <= 10; y += 0.5, ++n) {
      const Vec3 away = (Vec3(x, y, 0) - center).normalized();
      // A bump over a corner of the face.
      const double bump = x > 1 && y > 1 ? 0.3 + 0.1 * x : 0.0;
      face.points_mm.push_back(center + (26 - bump + 0.01 * std::sin(12.9898 * n)) * away);
    }
  }
  const auto found = fit_face(face, Vec3::UnitZ());
  ASSERT_TRUE(found && found->spherical);
  EXPECT_TRUE(found->concave);
  EXPECT_LT((found->sphere->center_mm - center).norm(), 0.02);
  EXPECT_NEAR(found->fitted_fraction, 0.8, 0.05);
  EXPECT_FALSE(
      fit_face({.points_mm = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, .point_mm2 = 1, .voxel_mm = 1}, Vec3::UnitZ()));
}

}  // namespace
}  // namespace reamsim::test
