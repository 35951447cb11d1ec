// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The benchmark's scene: sizes of the shells, the bone at several resolutions, and what the stored poses touch.
#include <gtest/gtest.h>

#include <iostream>

#include "sim/bench/paper.h"
#include "sim/bench/scene.h"
#include "sim/engine/common/substep.h"
#include "sim/tool/point_shell.h"

namespace reamsim::bench {
namespace {

TEST(BenchScene, ShellsHaveThePapersPoints) {
  for (const int side : {64, 128, 256, 512}) {
    const Tool tool = cap_tool(side);
    const double paper = kPaperPoints[*place(kShells, side)];
    const auto points = static_cast<double>(tool.shell.codes.size());
    std::cout << side << ": " << points << " points, the paper " << paper << '\n';
    // The paper's sizes are known to two digits of MB: 0.05 MB at 64 cells.
    EXPECT_NEAR(points / paper, 1, side == 64 ? 0.1 : 0.05) << side;
  }
}

TEST(BenchScene, ShellIsAHemisphereWithoutLid) {
  const Tool tool = cap_tool(64);
  const Vec3 center(0, 0, kReamerMm);
  int high = 0;
  for (const std::uint64_t code : tool.shell.codes) {
    const Vec3 cell = morton_decode(code).cast<double>();
    const Vec3 point = tool.shell.origin_mm + tool.shell.cell_mm * (cell + Vec3::Constant(0.5));
    EXPECT_NEAR((point - center).norm(), kReamerMm, tool.shell.cell_mm);
    high += point.z() > kReamerMm - 2 * tool.shell.cell_mm ? 1 : 0;
  }
  // A lid would add π·R² over a cell's square.
  EXPECT_LT(high, 800);
}

TEST(BenchScene, BoneIsTheSameAtEveryResolution) {
  const BoneSeries series(64);
  const double at_sampled = series.at(64).bone_mm3();
  EXPECT_GT(at_sampled, 5000);
  for (const int side : {32, 128, 256})
    EXPECT_NEAR(series.at(side).bone_mm3() / at_sampled, 1, side < 64 ? 0.04 : 0.01) << side;
}

TEST(BenchScene, BoneLiesInItsBox) {
  const BoneSeries series(64);
  for (const int side : {32, 64, 128}) {
    const FilledVoxmap bone = series.at(side);
    const Aabb box = series.box(side);
    for (std::int64_t e = 0; e < bone.grid.size(); ++e) {
      const Vec3i voxel = bone.grid.coord(e);
      if (bone.grade.get(voxel) == 0) continue;
      const Vec3 center = bone.grid.center_mm(voxel);
      ASSERT_TRUE((center.array() > box.min.array()).all() && (center.array() < box.max.array()).all()) << side;
    }
  }
}

TEST(BenchScene, PosesTouchWhatTheyShouldAtASmallSize) {
  const BoneSeries series(128);
  const FilledVoxmap bone = series.at(256);
  const Tool tool = cap_tool(256);
  const auto points = static_cast<double>(tool.shell.codes.size());
  for (const Contact contact : kContacts) {
    double sum = 0;
    for (const Substep& frame : substeps_of(contact)) {
      const auto touching = static_cast<double>(count_touching(bone, tool, frame));
      const auto voi = broad_phase(shell_box(tool), series.box(256), frame.pose.bone_from_tool().inverse());
      EXPECT_TRUE(voi) << name_of(contact) << ": the boxes overlap in every case";
      sum += touching / static_cast<double>(kApproaches.size());
    }
    const double wanted = wanted_points(contact, points);
    std::cout << name_of(contact) << ": " << sum << " points, wanted " << wanted << '\n';
    // A quarter of the resolution that the depths were found at: within what half a cell of depth is worth.
    EXPECT_NEAR(sum, wanted, contact == Contact::severe ? 0.1 * wanted : 0.6 * wanted) << name_of(contact);
  }
}

constexpr double kClearance_mm = 0.3;

/// Depth at which `wanted` points touch, within 0.2 %, by bisection; for wanted = 0 kClearance_mm above the first
/// contact. The depths of kApproaches were found with it.
double find_depth(const Voxmap& voxmap, const Tool& tool, const Approach& approach, double wanted) {
  double low = -8, high = 8;  // mm: clear of the bone, deep in it
  for (int i = 0; i < 40; ++i) {
    const double middle = (low + high) / 2;
    const auto count = static_cast<double>(count_touching(voxmap, tool, substep_at(pose_at(approach, middle))));
    if (wanted > 0 && std::abs(count - wanted) < 0.002 * wanted) return middle;
    (count > wanted ? high : low) = middle;
  }
  return wanted > 0 ? (low + high) / 2 : low - kClearance_mm;
}

TEST(BenchScene, FoundDepthTouchesWhatWasAskedFor) {
  const BoneSeries series(64);
  const FilledVoxmap bone = series.at(64);
  const Tool tool = cap_tool(256);
  const double wanted = 5000;
  const double depth = find_depth(bone, tool, kApproaches[2], wanted);
  const auto touching = static_cast<double>(count_touching(bone, tool, substep_at(pose_at(kApproaches[2], depth))));
  EXPECT_NEAR(touching / wanted, 1, 0.02);
  const double clear = find_depth(bone, tool, kApproaches[2], 0);
  EXPECT_EQ(count_touching(bone, tool, substep_at(pose_at(kApproaches[2], clear))), 0);
  EXPECT_GT(count_touching(bone, tool, substep_at(pose_at(kApproaches[2], clear + 1.5 * kClearance_mm))), 0);
}

}  // namespace
}  // namespace reamsim::bench
