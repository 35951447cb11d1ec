// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The C++ visits that `exact` is measured against compute the same: sums, removed voxels and fill, on every instruction
// set that this processor has.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "sim/base/error.h"
#include "sim/bench/scene.h"
#include "sim/bone/voxmap/sample_voxels.h"
#include "sim/engine/common/engine.h"
#include "sim/engine/common/substep.h"
#include "tests/bench/reference/exact.h"

namespace reamsim::reference {
namespace {

constexpr double kVoxelMm = 0.5;
constexpr std::int64_t kLastFrame = 330;

CuttingSettings exact_cutting() {
  CuttingSettings cutting = bench::bench_cutting();
  cutting.erosion = ErosionMode::exact;
  return cutting;
}

/// A sphere of 6 mm radius with a sharp rim at a radius of 5 mm. It cuts two bricks deep with all of its face.
Tool small_sphere() {
  constexpr double kRadius = 6, kRim = 5;
  constexpr int kSteps = 24;
  Tool tool;
  for (int i = 0; i <= kSteps; ++i) {
    const double angle = std::asin(kRim / kRadius) * i / kSteps;
    tool.profile.points.emplace_back(kRadius * std::sin(angle), kRadius * (1 - std::cos(angle)));
  }
  tool.profile.points.emplace_back(kRim, 8);
  tool.profile.points.emplace_back(0, 8);
  return tool;
}

/// Two kinds of bone in layers of bricks, and air in some voxels.
FilledVoxmap layered_block() {
  VoxelGrid grid;
  grid.voxel_mm = kVoxelMm;
  grid.dims = {32, 40, 24};
  grid.origin_mm = {-8.1, -10.2, -12};
  FilledVoxmap voxmap(grid);
  const std::uint8_t dense = DensityMapping::grade_from_density(1.8), soft = DensityMapping::grade_from_density(0.6);
  for (int z = 0; z < grid.dims.z(); ++z) {
    for (int y = 0; y < grid.dims.y(); ++y) {
      for (int x = 0; x < grid.dims.x(); ++x) {
        if ((x + 3 * y + 5 * z) % 17 == 0) continue;
        voxmap.grade.set({x, y, z}, (x / 8 + z / 4) % 2 == 0 ? dense : soft);
      }
    }
  }
  voxmap.frame = "phantom";
  return voxmap;
}

struct Plunge {
  FilledVoxmap bone = layered_block();
  Tool tool = small_sphere();
  std::vector<SubstepArgs> args;
  std::vector<std::shared_ptr<const MotionWindow>> windows;
};

/// A tilted plunge: slow at first, in whole windows; faster, in parts of windows; at last too fast for windows.
Plunge make_plunge() {
  Plunge out;
  const Aabb tool_box = out.tool.clip_bounds();
  const auto depth = [](std::int64_t frame) {
    const auto t = static_cast<double>(frame);
    return 1.5 + 3e-4 * t + (frame > 128 ? 2.5e-3 * (t - 128) : 0) + (frame > 256 ? 0.02 * (t - 256) : 0);
  };
  const auto args_of = [&](std::int64_t frame) -> std::optional<SubstepArgs> {
    ToolPose pose;
    pose.orientation = Eigen::AngleAxisd(0.2, Vec3(1, 0.4, 0).normalized());
    pose.position_mm = -depth(frame) * (pose.orientation * Vec3::UnitZ());
    pose.spin_rpm = 250;
    Substep substep = bench::substep_at(pose);
    substep.duration_s = 1e-3;
    substep.origin_velocity_mm_s =
        (depth(frame - 1) - depth(frame)) / substep.duration_s * (pose.orientation * Vec3::UnitZ());
    substep.frame = frame;
    return make_args(substep, tool_box, out.tool.shell, out.bone.grid, exact_cutting(), false);
  };
  MotionWindows windows(args_of, kLastFrame, tool_box);
  for (std::int64_t frame = 0; frame <= kLastFrame; ++frame) {
    out.args.push_back(*args_of(frame));
    out.windows.push_back(frame == 0 ? nullptr : windows.of(frame));
  }
  return out;
}

struct PlungeResults {
  std::vector<SubstepSums> sums;
  RemovedFrames removed;
  FillBricks fill;
};

PlungeResults run_plunge(Engine& engine, const Plunge& plunge) {
  PlungeResults out;
  for (std::size_t i = 0; i < plunge.args.size(); ++i) engine.enqueue(plunge.args[i], plunge.windows[i]);
  out.sums = engine.collect().sums;
  out.removed = engine.take_removed();
  std::ranges::sort(out.removed);
  out.fill = plunge.bone.fill;
  engine.read_fill(plunge.bone, out.fill);
  return out;
}

/// Number of the first substep with different bytes; -1 where all are the same.
int first_difference(const std::vector<SubstepSums>& a, const std::vector<SubstepSums>& b) {
  if (a.size() != b.size()) return static_cast<int>(std::min(a.size(), b.size()));
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::memcmp(&a[i], &b[i], sizeof a[i]) != 0) return static_cast<int>(i);
  }
  return -1;
}

/// The fill of every voxel with bone; removed voxels have none.
std::vector<std::uint16_t> fills_of(const PlungeResults& results, const Plunge& plunge) {
  std::vector<std::uint16_t> out = dense_fill({plunge.bone, results.fill});
  for (const auto& [voxel, frame] : results.removed) out[static_cast<std::size_t>(voxel)] = 0;
  return out;
}

PlungeResults expected_results(const Plunge& plunge) {
  Scenario scenario;
  scenario.name = "reference";
  scenario.engine.type = EngineKind::exact;
  scenario.cutting = exact_cutting();
  const auto engine = make_engine(scenario, plunge.bone, plunge.tool);
  return run_plunge(*engine, plunge);
}

TEST(ExactReference, ThePlungeHasWindowsOfAllKinds) {
  const Plunge plunge = make_plunge();
  EXPECT_EQ(plunge.windows[1], plunge.windows[63]);  // a whole one
  EXPECT_NE(plunge.windows[200], nullptr);           // a part
  EXPECT_NE(plunge.windows[200], plunge.windows[255]);
  EXPECT_EQ(plunge.windows[300], nullptr);
  const PlungeResults results = expected_results(plunge);
  EXPECT_GT(results.removed.size(), 500U);
  EXPECT_GT(results.sums.at(100).contacts, 300);
  EXPECT_LT(results.sums.at(100).removed, results.sums.at(200).removed);
  EXPECT_GT(results.sums.at(300).contacts, 300);
}

TEST(ExactReference, AgreesWithExactToTheLastBit) {
  const Plunge plunge = make_plunge();
  const PlungeResults expected = expected_results(plunge);
  for (const Target target : usable_targets()) {
    for (const unsigned threads : {1U, 3U}) {
      ExactReference reference(plunge.bone, plunge.tool, exact_cutting(), target, threads);
      const PlungeResults found = run_plunge(reference, plunge);
      EXPECT_EQ(first_difference(found.sums, expected.sums), -1) << name_of(target);
      EXPECT_TRUE(found.removed == expected.removed) << name_of(target);
      EXPECT_TRUE(fills_of(found, plunge) == fills_of(expected, plunge)) << name_of(target);
    }
  }
}

TEST(ExactReference, RestoredBoneGivesTheSameSumsAgain) {
  const Plunge plunge = make_plunge();
  ExactReference reference(plunge.bone, plunge.tool, exact_cutting(), usable_targets().back(), 2);
  const PlungeResults first = run_plunge(reference, plunge);
  reference.restore(plunge.bone);
  EXPECT_EQ(first_difference(run_plunge(reference, plunge).sums, first.sums), -1);
  // Without that, nothing remains to be cut.
  EXPECT_EQ(run_plunge(reference, plunge).sums.back().contacts, 0);
}

TEST(ExactReference, RefusesWhatItDoesNotCompute) {
  const Plunge plunge = make_plunge();
  CuttingSettings edge = exact_cutting();
  edge.edge_force.emplace();
  EXPECT_THROW(ExactReference(plunge.bone, plunge.tool, bench::bench_cutting(), Target::plain, 1), RunError);
  EXPECT_THROW(ExactReference(plunge.bone, plunge.tool, edge, Target::plain, 1), RunError);
  FilledVoxmap partial = plunge.bone;
  partial.fill.set({3, 3, 3}, 1);
  EXPECT_THROW(ExactReference(partial, plunge.tool, exact_cutting(), Target::plain, 1), RunError);
}

}  // namespace
}  // namespace reamsim::reference
