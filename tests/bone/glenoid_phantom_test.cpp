// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <numbers>

#include "bone_fixture.h"
#include "sim/bone/phantom.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;

/// The default left glenoid at 0.25 mm, made once.
const Bone& standard() {
  static const Bone bone = make(phantom(PhantomShape::glenoid, 0.25));
  return bone;
}

double density_at(const BoneView& bone, const Vec3& point_mm) {
  return DensityMapping::density_from_grade(static_cast<std::uint8_t>(grade_at(bone, point_mm)));
}

/// First and last distance along a ray at which `inside` holds for the first time without a break.
struct Stretch {
  double begin_mm = -1;
  double end_mm = -1;
  [[nodiscard]] double length_mm() const { return end_mm - begin_mm; }
};

Stretch first_run(const Vec3& from, const Vec3& along, double reach_mm,
                  const std::function<bool(const Vec3&)>& inside) {
  constexpr double kStep_mm = 0.02;
  Stretch out;
  for (double t = 0; t < reach_mm; t += kStep_mm) {
    const bool here = inside(from + t * along);
    if (here && out.begin_mm < 0) out.begin_mm = t;
    if (!here && out.begin_mm >= 0) return {out.begin_mm, t};
  }
  return out;
}

/// Away from rim and notch.
bool well_inside_face(double anterior, double superior) {
  return std::hypot(anterior / 9, (superior + 2) / 12.5) < 1;
}

/// Length of dense bone that a ray meets first: from the metrics' default threshold on, which lies between the plate
/// and what is under it.
Stretch plate(const BoneView& bone, const Vec3& from, const Vec3& along) {
  return first_run(from, along, 45, [&](const Vec3& p) { return density_at(bone, p) > MetricSettings{}.dense_g_cm3; });
}

TEST(GlenoidPhantom, FaceIsASphereOfTheGivenRadius) {
  const Vec3 center(32, 0, 0);  // default face radius, left: +x is lateral
  for (const double a : {-8.0, 0.0, 8.0}) {
    for (const double s : {-10.0, -4.0, 3.0, 9.0}) {
      if (!well_inside_face(a, s)) continue;
      const Vec3 along = (Vec3(0, a, s) - center).normalized();
      const Stretch bone = first_run(center, along, 40, [&](const Vec3& p) { return grade_at(standard(), p) != 0; });
      EXPECT_NEAR(bone.begin_mm, 32, 0.25) << a << ", " << s;
    }
  }
}

TEST(GlenoidPhantom, FaceHasTheGivenSizeAndIsWiderBelow) {
  const VoxelGrid& grid = standard().voxmap->grid;
  double low = 0, high = 0, width_below = 0, width_above = 0;
  for_each_bone_voxel(standard(), [&](const Vec3i& c, std::uint8_t, std::uint16_t) {
    const Vec3 p = grid.center_mm(c);
    if (p.x() < 0.5 || std::abs(p.y()) > 15) return;  // the rim stands out of the face's plane; no coracoid
    if (std::abs(p.y()) < 3) {
      low = std::min(low, p.z());
      if (p.z() < 19) high = std::max(high, p.z());
    }
    if (std::abs(p.z() + 4.5) < 0.2) width_below = std::max(width_below, 2 * std::abs(p.y()));
    if (std::abs(p.z() - 8) < 0.2) width_above = std::max(width_above, 2 * std::abs(p.y()));
  });
  EXPECT_NEAR(high - low, 35, 1.5);
  EXPECT_NEAR(width_below, 26, 1.5);
  EXPECT_NEAR(width_above, 18, 2);
}

TEST(GlenoidPhantom, SubchondralPlateIsAsThickAsInLife) {
  const Vec3 center(32, 0, 0);
  double sum = 0;
  int count = 0;
  for (double a = -8; a <= 8; a += 2) {
    for (double s = -12; s <= 10; s += 2) {
      if (!well_inside_face(a, s)) continue;
      const Vec3 along = (Vec3(0, a, s) - center).normalized();
      const Stretch run = plate(standard(), center, along);
      EXPECT_GE(run.length_mm(), 1.2) << a << ", " << s;
      EXPECT_LE(run.length_mm(), 2.9) << a << ", " << s;
      sum += run.length_mm();
      ++count;
    }
  }
  EXPECT_NEAR(sum / count, 2.0, 0.15);
}

TEST(GlenoidPhantom, PlateAndWallHaveDensitiesOfTheirOwn) {
  const Bone& bone = standard();
  const Vec3 center(32, 0, 0);
  for (const double a : {-6.0, 0.0, 6.0}) {
    for (const double s : {-8.0, 0.0, 6.0}) {
      const Vec3 along = (Vec3(0, a, s) - center).normalized();
      EXPECT_NEAR(density_at(bone, center + 33 * along), 1.1, 0.005) << a << ", " << s;
    }
  }
  for (const double depth : {8.0, 12.0, 16.0}) {
    const Stretch wall = plate(bone, {-depth, 14, -4}, {0, -1, 0});
    EXPECT_NEAR(density_at(bone, {-depth, 14 - wall.begin_mm - 0.6, -4}), 1.8, 0.01) << depth;
  }
  BoneSettings settings = phantom(PhantomShape::glenoid, 0.5);
  settings.phantom.subchondral_density_g_cm3 = 0.8;
  EXPECT_NEAR(density_at(make(settings), {-1, 0, 0}), 0.8, 0.005);
}

TEST(GlenoidPhantom, UniformFoamHasOneDensity) {
  for (const SurfaceVoxels surface : {SurfaceVoxels::whole, SurfaceVoxels::partial}) {
    BoneSettings settings = phantom(PhantomShape::glenoid, 0.8);
    settings.surface_voxels = surface;
    settings.phantom.cortical_density_g_cm3 = 0.32;
    settings.phantom.subchondral_density_g_cm3 = 0.32;
    settings.phantom.trabecular_density_g_cm3 = 0.32;
    settings.phantom.trabecular_gradient = 0;
    settings.phantom.texture = 0;
    const FilledVoxmap foam = make(settings).copy_voxels();
    EXPECT_GT(foam.count_bone(), 10000);
    EXPECT_EQ(count_grade(foam, 40), foam.count_bone()) << name_of(surface);
  }
}

TEST(GlenoidPhantom, CorticalWallOfTheVault) {
  for (const double depth : {8.0, 12.0, 16.0, 20.0}) {
    for (const double side : {-1.0, 1.0}) {
      const Stretch run = plate(standard(), {-depth, 14 * side, -4}, {0, -side, 0});
      EXPECT_GE(run.length_mm(), 1.2) << depth << ", " << side;
      EXPECT_LE(run.length_mm(), 2.9) << depth << ", " << side;
    }
  }
}

TEST(GlenoidPhantom, VaultNarrowsToTheNeck) {
  const auto width = [](double depth) {
    double out = 0;
    for (double y = -20; y < 20; y += 0.1) out += grade_at(standard(), {-depth, y, -4}) != 0 ? 0.1 : 0;
    return out;
  };
  EXPECT_GT(width(2), 22);
  EXPECT_LT(width(10), width(2));
  EXPECT_LT(width(20), width(10));
  EXPECT_GT(width(20), 8);
  EXPECT_LT(width(38), 6) << "the blade is thin";
}

TEST(GlenoidPhantom, TrabecularBoneThinsOutBehindThePlate) {
  const auto mean = [](double from, double to) {
    double sum = 0;
    int count = 0;
    for (double x = from; x < to; x += 0.25) {
      for (double y = -4; y <= 4; y += 0.5) {
        for (double z = -8; z <= 4; z += 0.5, ++count) sum += density_at(standard(), {-x, y, z});
      }
    }
    return sum / count;
  };
  const double near_plate = mean(3.5, 5.5);
  const double deep = mean(16, 20);
  EXPECT_GT(near_plate, 1.3 * deep);
  EXPECT_GT(deep, 0.15);
  EXPECT_LT(near_plate, 0.9);
}

TEST(GlenoidPhantom, LeftAndRightAreMirrorImages) {
  BoneSettings settings = phantom(PhantomShape::glenoid, 0.8);
  settings.phantom.version_deg = 7;
  settings.phantom.inclination_deg = 9;
  const Bone left = make(settings);
  settings.side = BodySide::right;
  const Bone right = make(settings);
  EXPECT_EQ(left.view().count_bone(), right.view().count_bone());
  const VoxelGrid& grid = left.voxmap->grid;
  for (std::int64_t i = 0; i < grid.size(); ++i) {
    const Vec3i c = grid.coord(i);
    const Vec3 p = grid.center_mm(c);
    ASSERT_EQ(left.voxmap->grade.get(c), grade_at(right, {-p.x(), p.y(), p.z()}));
  }
  const Mat3 l = left.glenoid->bone_from_glenoid.linear();
  const Mat3 r = right.glenoid->bone_from_glenoid.linear();
  EXPECT_NEAR((Vec3(-l(0, 2), l(1, 2), l(2, 2)) - r.col(2)).norm(), 0, 1e-12);
  EXPECT_NEAR(l.determinant(), 1, 1e-12);
  EXPECT_NEAR(r.determinant(), 1, 1e-12);
}

TEST(GlenoidPhantom, VersionAndInclinationTurnTheFace) {
  BoneSettings settings = phantom(PhantomShape::glenoid, 0.5);
  settings.phantom.version_deg = 12;
  settings.phantom.inclination_deg = 8;
  const Bone bone = make(settings);
  const double v = 12 * std::numbers::pi / 180;
  const double i = 8 * std::numbers::pi / 180;
  const Vec3 normal = bone.glenoid->bone_from_glenoid.linear().col(2);
  // Retroversion: the face looks posteriorly (+y in B); inclination: superiorly (+z).
  EXPECT_NEAR((normal - Vec3(std::cos(v) * std::cos(i), std::sin(v) * std::cos(i), std::sin(i))).norm(), 0, 1e-12);
  EXPECT_NEAR(bone.glenoid->bone_from_glenoid.translation().norm(), 0, 1e-12);
  const Rigid& frame = bone.glenoid->bone_from_glenoid;
  for (const Vec3& q : {Vec3(6, 0, 0), Vec3(-6, 0, 0), Vec3(0, 8, 0), Vec3(0, -8, 0)}) {
    const Vec3 center = frame * Vec3(0, 0, 32);
    const Vec3 along = (frame * q - center).normalized();
    const Stretch run = first_run(center, along, 40, [&](const Vec3& p) { return grade_at(bone, p) != 0; });
    EXPECT_NEAR(run.begin_mm, 32, 0.45) << q.transpose();
  }
}

TEST(GlenoidPhantom, SameSeedSameBoneOtherSeedOtherTexture) {
  BoneSettings settings = phantom(PhantomShape::glenoid, 0.8);
  const FilledVoxmap first = make(settings).copy_voxels();
  EXPECT_EQ(first.grade, make(settings).voxmap->grade);
  settings.phantom.seed = 2;
  const FilledVoxmap other = make(settings).copy_voxels();
  EXPECT_NE(first.grade, other.grade);
  EXPECT_EQ(first.count_bone(), other.count_bone()) << "the shape is not random";
}

TEST(GlenoidPhantom, SkippedBricksHoldNoBone) {
  BoneSettings settings = phantom(PhantomShape::glenoid, 0.8);
  settings.phantom.version_deg = 25;
  settings.phantom.inclination_deg = -20;
  const FilledVoxmap voxmap = make(settings).copy_voxels();
  const GlenoidShape shape(settings.phantom);
  const VoxelGrid& grid = voxmap.grid;
  for (std::int64_t e = 0; e < grid.size(); ++e) {
    const Vec3i c = grid.coord(e);
    const Vec3 p = grid.center_mm(c);
    const Vec3 anatomy(p.x(), p.z(), -p.y());
    const bool inside = anatomy.x() >= shape.medial_end_mm() && shape.solid(anatomy) <= 0;
    ASSERT_EQ(inside, voxmap.grade.get(c) != 0) << p.transpose();
  }
}

TEST(GlenoidPhantom, NoBoneBeyondTheLattice) {
  for (const double version : {-30.0, 0.0, 30.0}) {
    BoneSettings settings = phantom(PhantomShape::glenoid, 1);
    settings.phantom.version_deg = version;
    settings.phantom.inclination_deg = 0.7 * version;
    const FilledVoxmap voxmap = make(settings).copy_voxels();
    for (std::int64_t e = 0; e < voxmap.grid.size(); ++e) {
      const Vec3i c = voxmap.grid.coord(e);
      const bool border = (c.array() == 0).any() || (c.array() == voxmap.grid.dims.array() - 1).any();
      ASSERT_TRUE(!border || voxmap.grade.get(c) == 0) << version << ": " << c.transpose();
    }
  }
}

TEST(GlenoidPhantom, RefusesWhatHasNoShape) {
  BoneSettings settings = phantom(PhantomShape::glenoid, 1);
  settings.phantom.face_radius_mm = 15;
  EXPECT_THAT(input_error([&] { make(settings); }), HasSubstr("bone.phantom.face_radius_mm: 15 mm"));
  settings.phantom.face_radius_mm = 32;
  settings.phantom.width_mm = 13;
  EXPECT_THAT(input_error([&] { make(settings); }), HasSubstr("bone.phantom.width_mm: 13 mm"));
}

TEST(ValueNoise, IsSmoothBoundedAndFixed) {
  EXPECT_EQ(value_noise({1.25, -3.5, 0.75}, 1), value_noise({1.25, -3.5, 0.75}, 1));
  EXPECT_NE(value_noise({1.25, -3.5, 0.75}, 1), value_noise({1.25, -3.5, 0.75}, 2));
  double sum = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p(0.137 * i, -0.211 * i, 0.093 * i);
    const double here = value_noise(p, 5);
    ASSERT_LE(std::abs(here), 1);
    ASSERT_NEAR(value_noise(p + Vec3(1e-4, 0, 0), 5), here, 5e-4);
    sum += here;
  }
  EXPECT_NEAR(sum / 20000, 0, 0.02);
}

}  // namespace
}  // namespace reamsim::test
