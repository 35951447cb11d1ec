// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <random>
#include <thread>

#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/tool/tool_path.h"
#include "tests/support/temp_dir.h"

namespace reamsim {
namespace {

using ::testing::HasSubstr;

constexpr unsigned kMotionSeed = 21;

/// A recorded motion at irregular times around 1 ms.
void write_rows(const std::string& path, int rows) {
  std::mt19937 random(kMotionSeed);
  std::uniform_real_distribution<double> noise(-1, 1);
  std::ofstream csv(path);
  csv << "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,spin_rpm\n";
  for (int i = 0; i < rows; ++i) {
    csv << shortest_text(2 + 1e-3 * i + 3e-4 * noise(random));
    for (int k = 0; k < 3; ++k) csv << ',' << shortest_text(5 * noise(random));
    csv << ",1";
    for (int k = 0; k < 3; ++k) csv << ',' << shortest_text(1e-2 * noise(random));
    csv << ',' << shortest_text(250 + 50 * noise(random)) << '\n';
  }
}

bool same(const ToolPose& a, const ToolPose& b) {
  return a.position_mm == b.position_mm && a.orientation.coeffs() == b.orientation.coeffs() &&
         a.spin_angle_rad == b.spin_angle_rad && a.spin_rpm == b.spin_rpm;
}

class LongCsv : public ::testing::Test {
 protected:
  static constexpr int kStored = 100'000;  ///< rows of the longest file that is held in memory

  Motion motion_of(const std::string& name, int rows) {
    MotionSettings settings;
    settings.csv.emplace().path = dir_.path() + "/" + name;
    settings.frame_rate_hz = 1000;
    write_rows(settings.csv->path, rows);
    return build_motion(settings, GlenoidFrame{}, report_);
  }

  test::TempDir dir_;
  Diagnostics report_;
};

TEST_F(LongCsv, StreamedPosesAreThoseInMemory) {
  RecordProperty("seed", kMotionSeed);
  const Motion stored = motion_of("stored.csv", kStored);
  const Motion streamed = motion_of("streamed.csv", kStored + 20'000);
  ASSERT_GT(streamed.poses.size(), stored.poses.size());
  const std::size_t compared = stored.poses.size() - 2;  // the next row follows
  for (std::size_t k = 0; k < compared; ++k) ASSERT_TRUE(same(stored.poses[k], streamed.poses[k])) << k;
  std::mt19937 random(kMotionSeed);
  for (int i = 0; i < 300; ++i) {
    const std::size_t k = random() % compared;
    ASSERT_TRUE(same(stored.poses[k], streamed.poses[k])) << k << ", seed " << kMotionSeed;
  }
}

TEST_F(LongCsv, ThreadsReadAtTheSameTime) {
  const Motion stored = motion_of("stored.csv", kStored);
  const Motion streamed = motion_of("streamed.csv", kStored + 1);
  std::vector<std::size_t> wrong(4, 0);
  std::vector<std::thread> threads;
  for (std::size_t t = 0; t < wrong.size(); ++t) {
    threads.emplace_back([&, t] {
      for (std::size_t i = 0; i < 5000; ++i) {
        const std::size_t k = t * 20'000 + i;
        wrong[t] += same(stored.poses[k], streamed.poses[k]) ? 0 : 1;
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_EQ(wrong, std::vector<std::size_t>(4, 0));
}

TEST_F(LongCsv, AFileThatChangesIsARunError) {
  const Motion motion = motion_of("poses.csv", kStored + 5000);
  const ToolPose first = motion.poses.front();
  EXPECT_TRUE(first.position_mm.allFinite());
  std::ofstream(dir_.path() + "/poses.csv", std::ios::app) << "1e6,0,0,0,1,0,0,0,0\n";
  try {
    (void)motion.poses.back();
    ADD_FAILURE() << "no complaint";
  } catch (const RunError& error) {
    EXPECT_THAT(error.what(), HasSubstr("poses.csv: the file changed"));
  }
}

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
