// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The worn and dysplastic faces of the glenoid phantom against their closed forms (docs/glenoid.md).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <map>
#include <numbers>

#include "bone_fixture.h"
#include "sim/bone/phantom.h"
#include "sim/scenario/parse.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

constexpr double kDegree = std::numbers::pi / 180;
constexpr double kVoxel_mm = 0.25;
constexpr double kCoarse_mm = 0.8;  // where no length is measured

BoneSettings walch(Walch type, double voxel_mm = kVoxel_mm) {
  BoneSettings settings = phantom(PhantomShape::glenoid, voxel_mm);
  settings.phantom.walch = type;
  apply_walch_defaults(settings.phantom);
  return settings;
}

/// The left bone of a type with its defaults, made once.
const Bone& standard(Walch type) {
  static std::map<Walch, Bone> bones;
  const auto found = bones.find(type);
  return found == bones.end() ? bones.emplace(type, make(walch(type))).first->second : found->second;
}

/// Anatomical coordinates (lateral, superior, anterior) to B and back, left side.
Vec3 to_bone(const Vec3& p) {
  return {p.x(), -p.z(), p.y()};
}

Vec3 to_anatomy(const Vec3& p) {
  return {p.x(), p.z(), -p.y()};
}

/// The scapular frame S of landmarks: rows lateral, superior, anterior.
Mat3 scapular_axes(const LandmarkSettings& marks, BodySide side) {
  const Vec3 lateral = (marks.glenoid_center_mm - marks.trigonum_spinae_mm).normalized();
  const Vec3 up = marks.glenoid_center_mm - marks.inferior_angle_mm;
  const Vec3 superior = (up - up.dot(lateral) * lateral).normalized();
  Mat3 axes;
  axes << lateral.transpose(), superior.transpose(),
      (side == BodySide::left ? 1 : -1) * lateral.cross(superior).transpose();
  return axes;
}

double version_deg(const Bone& bone, BodySide side, const Vec3& in_bone) {
  return version_of(scapular_axes(*bone.landmarks, side) * in_bone) / kDegree;
}

double inclination_deg(const Bone& bone, BodySide side, const Vec3& in_bone) {
  return inclination_of(scapular_axes(*bone.landmarks, side) * in_bone) / kDegree;
}

/// A patch of one part of the face: an ellipse, its middle and half axes in anatomical coordinates.
struct Patch {
  std::size_t part = 0;
  Vec3 middle_mm;
  Vec3 across;  ///< of the half axis `across_mm`; the other lies across this one and lateral
  double across_mm = 6;
  double along_mm = 6;

  [[nodiscard]] bool holds(const Vec3& anatomy) const {
    const Vec3 from = anatomy - middle_mm;
    const Vec3 along = across.cross(Vec3::UnitX()).normalized();
    return std::hypot(from.dot(across) / across_mm, from.dot(along) / along_mm) < 1 && from.norm() < 9;
  }
};

/// Patches that neither the rounded rim nor the other part reaches.
std::vector<Patch> patches_of(const GlenoidFace& face) {
  const auto& both = face.biconcavity;
  if (!both) return {{face.balls.size() - 1, face.center_mm, Vec3::UnitY()}};
  const Vec3 neo = (both->neo_rim_mm - both->ridge_mm).normalized();
  return {{0, both->ridge_mm - 4.5 * both->wear, both->wear, 4, 8}, {1, both->ridge_mm + 5.5 * neo, both->wear, 4, 6}};
}

/// Points of the face in a patch: halfway between a voxel of bone and its lateral neighbour of air, so right on
/// average. `margin_mm` keeps them away from the other part.
std::vector<Vec3> face_points(const BoneView& bone, const GlenoidFace& face, const Patch& patch, double margin_mm) {
  const VoxelGrid& grid = bone.voxmap.grid;
  const Vec3i first = grid.voxel_of(to_bone(patch.middle_mm) - Vec3::Constant(10));
  const Vec3i last = grid.voxel_of(to_bone(patch.middle_mm) + Vec3::Constant(10));
  std::vector<Vec3> out;
  for (int z = first.z(); z <= last.z(); ++z) {
    for (int y = first.y(); y <= last.y(); ++y) {
      for (int x = first.x(); x <= last.x(); ++x) {
        if (bone.voxmap.grade.get({x, y, z}) == 0 || bone.voxmap.grade.get({x + 1, y, z}) != 0) continue;
        const Vec3 p = to_anatomy(0.5 * (grid.center_mm({x, y, z}) + grid.center_mm({x + 1, y, z})));
        bool own = patch.holds(p);
        for (std::size_t i = 0; i < face.balls.size(); ++i) {
          const GlenoidFace::Ball& ball = face.balls[i];
          own = own && (i == patch.part || (p - ball.center_mm).norm() > ball.radius_mm + margin_mm);
        }
        if (own) out.push_back(p);
      }
    }
  }
  return out;
}

struct Sphere {
  Vec3 center_mm;
  double radius_mm;
};

/// The sphere with the least sum of squared distances from points; Gauss and Newton's way from a plausible start. (The
/// linear fit would be biased: on a patch so flat, errors of half a voxel make the radius some 8 % too small.)
Sphere fitted_sphere(const std::vector<Vec3>& points, const Vec3& start) {
  Sphere out{start, (points.front() - start).norm()};
  for (int step = 0; step < 30; ++step) {
    Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (const Vec3& p : points) {
      const Vec3 away = p - out.center_mm;
      Eigen::Vector4d slope;
      slope << away.normalized(), 1;
      normal += slope * slope.transpose();
      right += slope * (away.norm() - out.radius_mm);
    }
    const Eigen::Vector4d change = normal.ldlt().solve(right);
    out.center_mm += change.head<3>();
    out.radius_mm += change(3);
  }
  return out;
}

/// Sphere through a patch of the bone's face, in anatomical coordinates, found from the voxels alone.
Sphere sphere_of(const Bone& bone, const GlenoidFace& face, std::size_t patch) {
  const std::vector<Vec3> points = face_points(bone, face, patches_of(face)[patch], 0.3);
  EXPECT_GT(points.size(), 500u);
  return fitted_sphere(points, {20, 0, 0});
}

TEST(Walch, DefaultsAreTheTypesOwn) {
  EXPECT_EQ(walch(Walch::a1).phantom.version_deg, 8);
  EXPECT_LT(walch(Walch::a1).phantom.medialization_mm, walch(Walch::a2).phantom.medialization_mm);
  EXPECT_GT(walch(Walch::c).phantom.version_deg, 25) << "what Walch's type C is";
  EXPECT_EQ(walch(Walch::none).phantom.version_deg, 0);
}

TEST(Walch, ConcentricWearIsTheHumeralHeadPushedIn) {
  for (const Walch type : {Walch::a1, Walch::a2}) {
    const BoneSettings settings = walch(type);
    const Bone& bone = standard(type);
    const double depth = settings.phantom.medialization_mm;
    EXPECT_NEAR((bone.landmarks->glenoid_center_mm - Vec3(-depth, 0, 0)).norm(), 0, 1e-12) << name_of(type);
    EXPECT_NEAR((bone.glenoid->bone_from_glenoid.translation() - Vec3(-depth, 0, 0)).norm(), 0, 1e-12) << name_of(type);
    const GlenoidFace face(settings.phantom);
    const Sphere worn = sphere_of(bone, face, 0);
    EXPECT_NEAR(worn.radius_mm, 24, 0.25) << name_of(type);
    const Vec3 normal = to_bone(worn.center_mm) - bone.landmarks->glenoid_center_mm;
    EXPECT_NEAR(version_deg(bone, BodySide::left, normal), 8, 0.3) << name_of(type);
    EXPECT_NEAR(inclination_deg(bone, BodySide::left, normal), 8, 0.3) << name_of(type);
  }
}

TEST(Walch, DysplasticFaceIsUniconcaveAndRetroverted) {
  const Bone& bone = standard(Walch::c);
  const GlenoidFace face(walch(Walch::c).phantom);
  ASSERT_EQ(face.balls.size(), 1u);
  const Sphere found = sphere_of(bone, face, 0);
  EXPECT_NEAR(found.radius_mm, 37, 0.4);
  const Vec3 normal = to_bone(found.center_mm) - bone.landmarks->glenoid_center_mm;
  EXPECT_NEAR(version_deg(bone, BodySide::left, normal), 37, 0.3);
  EXPECT_NEAR(inclination_deg(bone, BodySide::left, normal), 3, 0.3);
}

TEST(Walch, DysplasticRimIsRoundedPosteroinferiorlyOnly) {
  BoneSettings sharp = walch(Walch::c);
  sharp.phantom.rim_rounding_mm = 2.4;
  const GlenoidShape round_rim(walch(Walch::c).phantom);
  const GlenoidShape sharp_rim(sharp.phantom);
  const Mat3 anatomy_from_face = round_rim.face().face_from_anatomy.transpose();
  const auto lost_mm = [&](double superior, double anterior) {
    const Vec3 at = anatomy_from_face * Vec3(-1, superior, anterior);
    return round_rim.solid(at) - sharp_rim.solid(at);
  };
  EXPECT_GT(lost_mm(-13, -11), 1);
  EXPECT_NEAR(lost_mm(-13, 13), 0, 1e-12);
  EXPECT_NEAR(lost_mm(13, -11), 0, 0.3);
  EXPECT_NEAR(lost_mm(0, 0), 0, 1e-12);
}

TEST(Walch, BiconcaveFaceHasTwoSpheresThatMeetAtTheRidge) {
  const BoneSettings settings = walch(Walch::b2);
  const Bone& bone = standard(Walch::b2);
  const GlenoidFace face(settings.phantom);
  const auto& both = *face.biconcavity;
  for (const GlenoidFace::Ball& ball : face.balls) {
    EXPECT_NEAR((both.ridge_mm - ball.center_mm).norm(), ball.radius_mm, 1e-12);
  }
  EXPECT_NEAR((both.neo_rim_mm - face.balls[1].center_mm).norm(), 24, 1e-12);
  const Sphere paleo = sphere_of(bone, face, 0);
  const Sphere neo = sphere_of(bone, face, 1);
  EXPECT_NEAR(paleo.radius_mm, 32, 0.7);
  EXPECT_NEAR(neo.radius_mm, 24, 0.5);
  const double angle =
      std::acos((paleo.center_mm - both.ridge_mm).normalized().dot((neo.center_mm - both.ridge_mm).normalized())) /
      kDegree;
  EXPECT_NEAR(angle, both.angle / kDegree, 0.6);
  // tilt + half the neoglenoid's arc + slope of the native face at the ridge, which lies at the centre here
  const double chord_mm = (both.neo_rim_mm - both.ridge_mm).norm();
  EXPECT_NEAR(both.angle / kDegree, 15 + std::asin(chord_mm / 48) / kDegree, 1e-9);
}

TEST(Walch, VersionOfEachPartOfABiconcaveFace) {
  const BoneSettings settings = walch(Walch::b2);
  const Bone& bone = standard(Walch::b2);
  const GlenoidFace face(settings.phantom);
  const auto& both = *face.biconcavity;
  const Vec3 paleo = to_bone(face.native_normal());
  EXPECT_NEAR(version_deg(bone, BodySide::left, paleo), 8, 1e-9);
  EXPECT_NEAR(inclination_deg(bone, BodySide::left, paleo), 8, 1e-9);
  EXPECT_NEAR(std::acos(face.native_normal().dot(both.neo_normal)) / kDegree, 15, 1e-9);
  const double neo_version = version_deg(bone, BodySide::left, to_bone(both.neo_normal));
  const double neo_inclination = inclination_deg(bone, BodySide::left, to_bone(both.neo_normal));
  EXPECT_GT(neo_version, 8) << "the neoglenoid is more retroverted";
  EXPECT_LT(neo_inclination, 8) << "and looks further down, because wear is posteroinferior";
  // The same from the voxels: the normal of the chord runs from its middle to the centre of the neoglenoid's sphere.
  const Sphere neo = sphere_of(bone, face, 1);
  const Vec3 found = to_bone(neo.center_mm - 0.5 * (both.ridge_mm + both.neo_rim_mm));
  EXPECT_NEAR(version_deg(bone, BodySide::left, found), neo_version, 0.5);
  EXPECT_NEAR(inclination_deg(bone, BodySide::left, found), neo_inclination, 0.5);
  // Rim to rim lies between the two, and is the glenoid frame's.
  const Vec3 whole = bone.glenoid->bone_from_glenoid.linear().col(2);
  EXPECT_NEAR((whole - to_bone(face.normal)).norm(), 0, 1e-12);
  EXPECT_GT(version_deg(bone, BodySide::left, whole), 8);
  EXPECT_LT(version_deg(bone, BodySide::left, whole), neo_version);
}

/// Length of dense bone along the face's normal, from the metrics' default threshold on.
double plate_mm(const BoneView& bone, const Vec3& from, const Vec3& inward) {
  constexpr double kStep_mm = 0.02;
  double out = 0;
  // Half a voxel in, where the voxel of `from` is bone whatever the rounding.
  const auto dense = [&](double at_mm) {
    const int grade = grade_at(bone, from + at_mm * inward);
    return DensityMapping::density_from_grade(static_cast<std::uint8_t>(grade)) > MetricSettings{}.dense_g_cm3;
  };
  while (out < kVoxel_mm || dense(out)) out += kStep_mm;
  return out;
}

TEST(Walch, PlateFollowsTheWornFace) {
  for (const Walch type : {Walch::a1, Walch::a2, Walch::b2, Walch::c}) {
    const GlenoidFace face(walch(type).phantom);
    double sum_mm = 0;
    int count = 0;
    for (const Patch& patch : patches_of(face)) {
      // Away from the ridge, behind which the plates of both parts run into each other, and from the vault's wall.
      Patch inner = patch;
      inner.across_mm = 2.5;
      inner.along_mm = 4;
      for (const Vec3& p : face_points(standard(type), face, inner, 1.2)) {
        const Vec3 inward = (p - face.balls[patch.part].center_mm).normalized();
        const double here_mm = plate_mm(standard(type), to_bone(p), to_bone(inward));
        EXPECT_GE(here_mm, 1.2) << name_of(type) << " at " << p.transpose();
        EXPECT_LE(here_mm, 2.9) << name_of(type) << " at " << p.transpose();
        sum_mm += here_mm;
        ++count;
      }
    }
    ASSERT_GT(count, 300) << name_of(type);
    EXPECT_NEAR(sum_mm / count, 2.0, 0.15) << name_of(type);
  }
}

TEST(Walch, WearOnlyTakes) {
  for (const Walch type : {Walch::a1, Walch::a2, Walch::b2}) {
    BoneSettings healthy = walch(type, kCoarse_mm);
    healthy.phantom.walch = Walch::none;
    const FilledVoxmap before = make(healthy).copy_voxels();
    const FilledVoxmap worn = make(walch(type, kCoarse_mm)).copy_voxels();
    ASSERT_EQ(before.grid.dims, worn.grid.dims);
    std::int64_t gone = 0;
    for (std::int64_t i = 0; i < before.grid.size(); ++i) {
      const Vec3i c = before.grid.coord(i);
      const bool was = before.grade.get(c) != 0;
      const bool is = worn.grade.get(c) != 0;
      ASSERT_TRUE(was || !is) << name_of(type);
      gone += was && !is ? 1 : 0;
    }
    EXPECT_GT(static_cast<double>(gone) * before.grid.voxel_mm3(), 300) << name_of(type);
  }
}

TEST(Walch, RightIsTheMirrorImage) {
  for (const Walch type : {Walch::b2, Walch::c}) {
    BoneSettings settings = walch(type, kCoarse_mm);
    const Bone left = make(settings);
    settings.side = BodySide::right;
    const Bone right = make(settings);
    const VoxelGrid& grid = left.voxmap->grid;
    for (std::int64_t i = 0; i < grid.size(); ++i) {
      const Vec3i c = grid.coord(i);
      const Vec3 p = grid.center_mm(c);
      ASSERT_EQ(left.voxmap->grade.get(c), grade_at(right, {-p.x(), p.y(), p.z()}));
    }
    const Vec3 l = left.glenoid->bone_from_glenoid.linear().col(2);
    const Vec3 r = right.glenoid->bone_from_glenoid.linear().col(2);
    EXPECT_NEAR(version_deg(left, BodySide::left, l), version_deg(right, BodySide::right, r), 1e-9);
    EXPECT_NEAR(inclination_deg(left, BodySide::left, l), inclination_deg(right, BodySide::right, r), 1e-9);
  }
}

TEST(Walch, LatticeHoldsAllOfIt) {
  for (const Walch type : {Walch::a1, Walch::a2, Walch::b2, Walch::c}) {
    const BoneSettings settings = walch(type, kCoarse_mm);
    const FilledVoxmap voxmap = make(settings).copy_voxels();
    const GlenoidShape shape(settings.phantom);
    for (std::int64_t e = 0; e < voxmap.grid.size(); ++e) {
      const Vec3i c = voxmap.grid.coord(e);
      const Vec3 p = voxmap.grid.center_mm(c);
      const Vec3 anatomy(p.x(), p.z(), -p.y());
      const bool inside = anatomy.x() >= shape.medial_end_mm() && shape.solid(anatomy) <= 0;
      ASSERT_EQ(inside, voxmap.grade.get(c) != 0) << name_of(type) << " at " << p.transpose();
      const bool border = (c.array() == 0).any() || (c.array() == voxmap.grid.dims.array() - 1).any();
      ASSERT_TRUE(!border || !inside) << name_of(type) << " at " << p.transpose();
    }
  }
}

TEST(Walch, SaysHowTheFaceIsTurned) {
  Diagnostics report;
  bone_from_phantom(walch(Walch::b2, 1), report);
  std::string all;
  for (const std::string& line : report.notes) all += line + "\n";
  EXPECT_THAT(all, HasSubstr("Walch B2"));
  EXPECT_THAT(all, HasSubstr("paleoglenoid: radius 32 mm, retroversion 8.00 degrees"));
  EXPECT_THAT(all, HasSubstr("neoglenoid: radius 24 mm"));
}

TEST(Walch, RefusesWearWithoutRoom) {
  BoneSettings settings = walch(Walch::a2, 1);
  settings.phantom.medialization_mm = 15;
  EXPECT_THAT(input_error([&] { make(settings); }), HasSubstr("bone.phantom.medialization_mm: 15 mm"));
  settings = walch(Walch::b2, 1);
  settings.phantom.wear_ridge_mm = 14;
  EXPECT_THAT(input_error([&] { make(settings); }), HasSubstr("bone.phantom.wear_ridge_mm: 14 mm"));
  settings = walch(Walch::b2, 1);
  settings.phantom.wear_radius_mm = 8;
  settings.phantom.wear_tilt_deg = 30;
  EXPECT_THAT(input_error([&] { make(settings); }), HasSubstr("bone.phantom.wear_radius_mm: 8 mm"));
}

}  // namespace
}  // namespace reamsim::test
