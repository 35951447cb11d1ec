// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/substep.h"

#include <gtest/gtest.h>

#include <iostream>
#include <random>

namespace reamsim {
namespace {

constexpr unsigned kSeed = 20200105;

Rigid random_pose(std::mt19937& random, double spread) {
  std::uniform_real_distribution<double> u(-1, 1);
  Rigid out = Rigid::Identity();
  out.linear() = Quat(u(random), u(random), u(random), u(random)).normalized().toRotationMatrix();
  out.translation() = spread * Vec3(u(random), u(random), u(random));
  return out;
}

Aabb random_box(std::mt19937& random) {
  std::uniform_real_distribution<double> u(0.2, 3);
  const Vec3 center(u(random), -u(random), u(random)), half(u(random), u(random), u(random));
  return {center - half, center + half};
}

/// Whether a convex combination search (alternating projections between the boxes) ends in contact: an answer that
/// knows nothing of separating axes.
double gap_by_projection(const Aabb& a, const Aabb& b, const Rigid& a_from_b) {
  Vec3 p = a.center();
  double gap = 0;
  for (int i = 0; i < 4000; ++i) {
    const Vec3 on_b = a_from_b * (a_from_b.inverse() * p).cwiseMax(b.min).cwiseMin(b.max);
    const Vec3 on_a = on_b.cwiseMax(a.min).cwiseMin(a.max);
    gap = (on_a - on_b).norm();
    p = on_a;
  }
  return gap;
}

TEST(BroadPhase, SeparatingAxesAgreeWithProjections) {
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  int apart = 0, together = 0;
  for (int trial = 0; trial < 400; ++trial) {
    const Aabb a = random_box(random), b = random_box(random);
    const Rigid a_from_b = random_pose(random, 5);
    const double gap = gap_by_projection(a, b, a_from_b);
    if (gap > 1e-2) {
      ++apart;
      EXPECT_FALSE(boxes_overlap(a, b, a_from_b)) << "trial " << trial << " gap " << gap;
    } else if (gap < 1e-6) {
      ++together;
      EXPECT_TRUE(boxes_overlap(a, b, a_from_b)) << "trial " << trial << " gap " << gap;
    }
  }
  EXPECT_GT(apart, 50);
  EXPECT_GT(together, 50);
}

TEST(BroadPhase, EdgeAgainstEdgeNeedsTheCrossProductAxes) {
  // Two bars crossed over each other's edges: no face normal separates them.
  const Aabb bar{{-5, -1, -1}, {5, 1, 1}};
  Rigid a_from_b = Rigid::Identity();
  a_from_b.linear() =
      (Eigen::AngleAxisd(M_PI / 2, Vec3::UnitZ()) * Eigen::AngleAxisd(M_PI / 4, Vec3::UnitX())).toRotationMatrix();
  Rigid turned = Rigid::Identity();
  turned.rotate(Eigen::AngleAxisd(M_PI / 4, Vec3::UnitX()));
  const auto at_height = [&](double z) {
    Rigid world_from_b = a_from_b;
    world_from_b.translation() = Vec3(0, 0, z);
    return turned.inverse() * world_from_b;
  };
  const double touching = 2 * std::sqrt(2.0);
  EXPECT_TRUE(boxes_overlap(bar, bar, at_height(touching - 0.01)));
  EXPECT_FALSE(boxes_overlap(bar, bar, at_height(touching + 0.01)));
}

TEST(BroadPhase, VoiHoldsEveryCommonPoint) {
  std::cout << "seed " << kSeed << '\n';
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> u(0, 1);
  int common = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const Aabb tool = random_box(random), bone = random_box(random);
    const Rigid tool_from_bone = random_pose(random, 3);
    const auto voi = broad_phase(tool, bone, tool_from_bone);
    for (int i = 0; i < 200; ++i) {
      const Vec3 p = tool.min + Vec3(u(random), u(random), u(random)).cwiseProduct(tool.max - tool.min);
      const Vec3 in_bone = tool_from_bone.inverse() * p;
      if ((in_bone.array() < bone.min.array()).any() || (in_bone.array() > bone.max.array()).any()) continue;
      ++common;
      ASSERT_TRUE(voi.has_value()) << "trial " << trial;
      EXPECT_TRUE((p.array() >= voi->min.array() - 1e-12).all() && (p.array() <= voi->max.array() + 1e-12).all());
    }
  }
  EXPECT_GT(common, 1000);
}

TEST(BroadPhase, VoiIsTheToolsBoxWhenTheBoneHoldsIt) {
  const Aabb tool{{-1, -2, -3}, {1, 2, 3}}, bone{{-50, -50, -50}, {50, 50, 50}};
  const auto voi = broad_phase(tool, bone, Rigid::Identity());
  ASSERT_TRUE(voi);
  EXPECT_EQ(voi->min, tool.min);
  EXPECT_EQ(voi->max, tool.max);
}

TEST(BroadPhase, NothingWhenApart) {
  Rigid far = Rigid::Identity();
  far.translation() = Vec3(0, 0, 10);
  const Aabb box{{-1, -1, -1}, {1, 1, 1}};
  EXPECT_FALSE(broad_phase(box, box, far));
}

}  // namespace
}  // namespace reamsim
