// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "sim/tool/tool_path.h"

namespace reamsim {
namespace {

ToolPose at_height(double z_mm) {
  ToolPose pose;
  pose.position_mm.z() = z_mm;
  return pose;
}

TEST(BoundedPathTest, KeepsAllPosesOfAShortPath) {
  BoundedPath path(10, 0.5, {}, 1000);
  for (std::size_t k = 0; k < 1000; ++k) path.add(at_height(1e-4 * static_cast<double>(k)), k);
  EXPECT_EQ(path.finish().size(), 1000u);
  EXPECT_EQ(path.step_mm(), 0.5);
  EXPECT_EQ(path.deviation_mm(), 0);
}

TEST(BoundedPathTest, ALongPathKeepsItsEndsItsDepthAndGivenFrames) {
  // Pecks of growing depth: 300 periods of 1000 frames.
  const auto height = [](std::size_t k) {
    const double period = static_cast<double>(k) / 1000;
    return -0.01 * std::floor(period) * (1 - std::cos(2 * M_PI * period));
  };
  constexpr std::size_t kFrames = 300'000, kMost = 2000;
  const std::vector<std::int64_t> keep{12'345, 123'456};
  BoundedPath path(10, 0.01, keep, kMost);
  for (std::size_t k = 0; k < kFrames; ++k) path.add(at_height(height(k)), k);
  const double step_mm = path.step_mm(), deviation_mm = path.deviation_mm();
  const std::vector<PathSample> kept = path.finish();
  EXPECT_LE(kept.size(), kMost + keep.size() + 1);
  EXPECT_GT(step_mm, 0.01);
  EXPECT_EQ(kept.front().frame, 0u);
  EXPECT_EQ(kept.back().frame, kFrames - 1);
  for (const std::int64_t frame : keep) {
    EXPECT_TRUE(std::ranges::any_of(kept, [&](const PathSample& s) { return std::cmp_equal(s.frame, frame); }))
        << frame;
  }
  const auto deepest = std::ranges::min_element(kept, {}, [](const PathSample& s) { return s.pose.position_mm.z(); });
  EXPECT_NEAR(deepest->pose.position_mm.z(), -0.01 * 299 * 2, step_mm);
  double farthest_mm = 0;
  for (std::size_t k = 0, i = 0; k < kFrames; ++k) {
    if (i + 1 < kept.size() && kept[i + 1].frame <= k) ++i;
    const double before_mm = kept[i].pose.position_mm.z(),
                 after_mm = kept[std::min(i + 1, kept.size() - 1)].pose.position_mm.z();
    farthest_mm = std::max(farthest_mm, std::min(std::abs(height(k) - before_mm), std::abs(height(k) - after_mm)));
  }
  EXPECT_LE(farthest_mm, deviation_mm);
  EXPECT_GT(farthest_mm, 0);
  EXPECT_TRUE(std::ranges::is_sorted(kept, {}, &PathSample::frame));
}

TEST(BoundedPathTest, ATrembleOfMillionsOfPosesIsBounded) {
  BoundedPath path(10, 0.01, {}, 1000);
  for (std::size_t k = 0; k < 200'000; ++k) path.add(at_height(k % 2 == 0 ? 0 : 5), k);
  EXPECT_LE(path.finish().size(), 1001u);
}

TEST(PoseSequenceTest, APartBeginsAtItsFirstPose) {
  const PoseSequence poses = {at_height(0), at_height(1), at_height(2), at_height(3)};
  const PoseSequence part = poses.part(1, 2);
  EXPECT_EQ(part.size(), 2u);
  EXPECT_EQ(part.front().position_mm.z(), 1);
  EXPECT_EQ(part.back().position_mm.z(), 2);
  EXPECT_EQ(part.part(1, 1)[0].position_mm.z(), 2);
  EXPECT_EQ(part.all().size(), 2u);
}

}  // namespace
}  // namespace reamsim
