// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The glenoid from one point on phantoms of every Walch type, turned at random: 2 of each, or REAMSIM_TURNED_GLENOIDS.
#include <cstdlib>
#include <iostream>
#include <random>

#include "sim/anatomy/find_glenoid.h"
#include "sim/bone/phantom.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scenario/parse.h"
#include "tests/bone/phantom_truth.h"

namespace reamsim::test {
namespace {

constexpr unsigned kTurnedSeed = 22;
constexpr double kTurnedVoxel_mm = 0.5;

int turned_count() {
  const char* asked = std::getenv("REAMSIM_TURNED_GLENOIDS");
  return asked == nullptr ? 2 : std::atoi(asked);
}

PhantomSettings phantom_of(Walch type) {
  PhantomSettings out;
  out.shape = PhantomShape::glenoid;
  out.walch = type;
  apply_walch_defaults(out);
  return out;
}

/// The exact shape, sampled on a lattice in which it is turned.
FilledVoxmap sampled(const PhantomSettings& settings, const Rigid& scan_from_bone, double voxel_mm) {
  const GlenoidShape shape(settings);
  const Rigid bone_from_scan = scan_from_bone.inverse();
  const auto anatomy = [&](const Vec3& p) { return anatomy_from_left(bone_from_scan * p); };
  const auto solid = [&](const Vec3& p) {
    const Vec3 at = anatomy(p);
    return std::max(shape.solid(at), shape.medial_end_mm() - at.x());
  };
  const auto fraction = [&](const Vec3& p, bool) {
    constexpr double kStep_mm = 1e-3;
    const double here = solid(p);
    Vec3 slope;
    for (int axis = 0; axis < 3; ++axis) slope[axis] = (solid(p + kStep_mm * Vec3::Unit(axis)) - here) / kStep_mm;
    return PartialVoxel{std::clamp(0.5 - here / (slope.norm() * voxel_mm), 0.0, 1.0), 1.0};
  };
  Aabb box = Aabb::none();
  const Aabb& upright = shape.bounds_mm();
  for_each_voxel(Vec3i::Constant(2), [&](const Vec3i& c) {
    const Vec3 corner = (c.array() == 0).select(upright.min, upright.max);
    box.extend(scan_from_bone * left_from_anatomy(corner));
  });
  const VoxelGrid grid = lattice_around("turned phantom", box, voxel_mm, 2);
  return sample_phantom(
      grid, DensitySettings(), [&](const Vec3& p) { return solid(p) < 0 ? 1.0 : kAir; }, fraction,
      [&](const Vec3& p, double radius_mm) { return shape.solid(anatomy(p)) > GlenoidShape::kMaxSlope * radius_mm; });
}

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}

  Vec3 in_unit_ball() {
    for (;;) {
      const Vec3 out(uniform_(engine_), uniform_(engine_), uniform_(engine_));
      if (out.norm() <= 1) return out;
    }
  }
  Rigid turn() {
    Rigid out = Rigid::Identity();
    const Vec3 axis = in_unit_ball().normalized();
    out.linear() = Eigen::AngleAxisd(std::numbers::pi * uniform_(engine_), axis).toRotationMatrix();
    out.translation() = 20 * in_unit_ball();
    return out;
  }

 private:
  std::mt19937 engine_;
  std::uniform_real_distribution<double> uniform_{-1, 1};
};

class TurnedGlenoid : public testing::TestWithParam<Walch> {};

TEST_P(TurnedGlenoid, IsFoundFromAPointNearItsCentre) {
  const PhantomSettings settings = phantom_of(GetParam());
  const FaceTruth truth = truth_of(settings);
  Random random(kTurnedSeed);
  double worst_mm = 0, worst_deg = 0;
  for (int n = 0; n < turned_count(); ++n) {
    const Rigid scan_from_bone = random.turn();
    const FilledVoxmap bone = sampled(settings, scan_from_bone, kTurnedVoxel_mm);
    GlenoidSettings glenoid;
    glenoid.near_mm = scan_from_bone * Vec3(truth.center_mm + 8 * random.in_unit_ball());
    const Rigid found = scan_from_bone.inverse() * find_glenoid(bone, glenoid, BodySide::left).frame.bone_from_glenoid;
    worst_mm = std::max(worst_mm, (found.translation() - truth.center_mm).norm());
    worst_deg = std::max(worst_deg, angle_deg(found.linear().col(2), truth.normal));
  }
  std::cout << name_of(GetParam()) << ", seed " << kTurnedSeed << ", " << turned_count() << " phantoms: centre "
            << worst_mm << " mm, normal " << worst_deg << " deg at worst\n";
  EXPECT_LE(worst_mm, 0.7);
  EXPECT_LE(worst_deg, 1.5);
}

TEST_P(TurnedGlenoid, IsFoundWithoutAPoint) {
  const PhantomSettings settings = phantom_of(GetParam());
  const FaceTruth truth = truth_of(settings);
  Random random(kTurnedSeed + 1);
  const Rigid scan_from_bone = random.turn();
  const std::vector<FacePlace> places = search_faces(sampled(settings, scan_from_bone, 1));
  ASSERT_FALSE(places.empty());
  const Vec3 center = scan_from_bone.inverse() * places[0].center_mm;
  EXPECT_LE((center - truth.center_mm).norm(), 2);
  EXPECT_GE(places[0].confidence, 0.6);
  for (std::size_t i = 1; i < places.size(); ++i) EXPECT_LT(places[i].confidence, 0.8 * places[0].confidence) << i;
}

INSTANTIATE_TEST_SUITE_P(Walch, TurnedGlenoid, testing::Values(Walch::none, Walch::a1, Walch::a2, Walch::b2, Walch::c),
                         [](const auto& chosen) { return name_of(chosen.param); });

}  // namespace
}  // namespace reamsim::test
