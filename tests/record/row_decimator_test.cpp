// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "sim/record/force_log.h"
#include "sim/record/run_totals.h"

namespace reamsim {
namespace {

constexpr unsigned kSeed = 7;

ForceRow row_at(std::int64_t frame, double axial_n, double torque_nmm) {
  ForceRow row;
  row.frame = frame;
  row.time_s = 1e-3 * static_cast<double>(frame);
  row.axial_force_n = axial_n;
  row.spin_torque_nmm = torque_nmm;
  return row;
}

bool has(const std::vector<ForceRow>& rows, std::int64_t frame) {
  return std::ranges::binary_search(rows, frame, {}, &ForceRow::frame);
}

TEST(RowDecimatorTest, KeepsEveryRowOfAShortLog) {
  RowDecimator decimator({}, 5000);
  for (int i = 0; i < 5000; ++i) decimator.add(row_at(i, 1, 2));
  EXPECT_EQ(decimator.bucket_rows(), 1);
  EXPECT_EQ(decimator.finish().size(), 5000u);
}

TEST(RowDecimatorTest, KeepsPeaksEndsAndGivenFramesOfALongLog) {
  RecordProperty("seed", kSeed);
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> noise(0, 1);
  constexpr std::int64_t kRows = 1'000'000;
  RowDecimator decimator({4'321, 765'432}, 50'000);
  for (std::int64_t i = 0; i < kRows; ++i) {
    ForceRow row = row_at(i, 10 * noise(random), 100 * noise(random));
    if (i == 333'333) row.axial_force_n = 500;
    if (i == 777) row.spin_torque_nmm = -40;
    if (i == 999'000) row.balance = -0.3;
    if (i == 50'001) row.depth_mm = 9;
    if (i == 250'000) row.layer_spin_torque_nmm = 900;
    decimator.add(row);
  }
  EXPECT_GE(decimator.bucket_rows(), kRows / 4096);
  EXPECT_LE(decimator.bucket_rows(), kRows / 2048);
  const std::vector<ForceRow> rows = decimator.finish();
  EXPECT_LE(rows.size(), 15u * 4096);
  EXPECT_TRUE(std::ranges::is_sorted(rows, {}, &ForceRow::frame));
  for (const std::int64_t frame : {0L, 777L, 4'321L, 50'001L, 250'000L, 333'333L, 765'432L, 999'000L, kRows - 1}) {
    EXPECT_TRUE(has(rows, frame)) << "frame " << frame << ", seed " << kSeed;
  }
}

TEST(LayerMeanTest, TakesManyFramesInAVoxel) {
  // A voxel of travel takes 300,000 frames; the force rises linearly.
  constexpr int kPerVoxel = 300'000;
  constexpr double kVoxel_mm = 0.25;
  LayerMean mean(kVoxel_mm);
  LayerMean::Means last;
  constexpr int kFrames = 2 * kPerVoxel;
  for (int i = 0; i < kFrames; ++i) {
    last = mean.add({0, 0, -kVoxel_mm * i / kPerVoxel}, static_cast<double>(i) / kPerVoxel, 3);
  }
  EXPECT_NEAR(static_cast<double>(last.frames), kPerVoxel, 1e-4 * kPerVoxel);
  EXPECT_NEAR(last.axial_force_n, 1.5, 1e-4);
  EXPECT_NEAR(last.spin_torque_nmm, 3, 1e-9);
  // Standing still replaces the oldest frames.
  const std::size_t frames = last.frames;
  for (int i = 0; i < kPerVoxel; ++i) last = mean.add({0, 0, -2 * kVoxel_mm}, 7, 3);
  EXPECT_NEAR(static_cast<double>(last.frames), static_cast<double>(frames), 1e-4 * kPerVoxel);
  EXPECT_NEAR(last.axial_force_n, 7, 1e-2);
  // Faster again, single frames count: 100 per voxel.
  for (int i = 0; i < 1000; ++i)
    last = mean.add({0, 0, -2 * kVoxel_mm - kVoxel_mm * (i + 1) / 100}, i < 900 ? 1 : 2, 3);
  EXPECT_EQ(last.frames, 100u);
  EXPECT_NEAR(last.axial_force_n, 2, 1e-9);
}

}  // namespace
}  // namespace reamsim
