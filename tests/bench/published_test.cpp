// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The published programs against the engine: same contacts, same force where each point has a voxel to itself.
#include <gtest/gtest.h>

#include "sim/bench/measure.h"
#include "sim/engine/common/engine.h"

namespace reamsim::bench {
namespace {

class Published : public ::testing::Test {
 protected:
  /// The exact sum of elemental forces over every point that touches, as if none raced.
  Vec3 race_free_force(const Substep& frame) const {
    Scenario scenario;
    scenario.engine.device = "serial";
    scenario.cutting.law = CuttingLaw::per_point;
    scenario.cutting.erosion = ErosionMode::remove;
    scenario.cutting.force_per_point_n = 1;
    const auto engine = make_engine(scenario, bone_, tool_);
    SubstepArgs args = args_without_voi(frame, tool_, bone_.grid);
    args.law = RS_LAW_PER_POINT;
    args.force_per_point = 1;
    engine->enqueue(args);
    const Batch batch = engine->collect();
    Vec3 force;
    for (int i = 0; i < 3; ++i) force[i] = static_cast<double>(batch.sums[0].force[i]) / RS_FORCE_SCALE;
    return frame.pose.orientation * force;  // the engine sums in T
  }

  void expect_near_race_free(Program& program) const {
    for (const Substep& frame : substeps_of(Contact::severe)) {
      const BatchSample sample = program.run({&frame, 1}, true);
      program.restore();
      const auto touching = static_cast<double>(count_touching(bone_, tool_, frame));
      ASSERT_GT(touching, 300);
      const Vec3 expected = race_free_force(frame);
      EXPECT_NEAR((sample.force - expected).norm() / expected.norm(), 0, 0.1);
      // Float positions and points that share a voxel take some away.
      EXPECT_LE(static_cast<double>(sample.contacts), 1.01 * touching);
      EXPECT_GE(static_cast<double>(sample.contacts), 0.85 * touching);
    }
  }

  const BoneSeries series_{64};
  // Voxels far smaller than the shell's spacing, so that hardly two points share one.
  const FilledVoxmap bone_ = series_.at(256);
  const Tool tool_ = cap_tool(64);
  const BenchSetup setup_{&bone_, &tool_, series_.box(256), shell_box(tool_)};
};

TEST_F(Published, DirectForceIsNearTheRaceFreeOne) {
  const auto program = make_program({"direct", "published"}, "auto", setup_, true);
  expect_near_race_free(*program);
  EXPECT_EQ(program->bytes().voxmap, 256U * 256 * 256);
  EXPECT_EQ(program->bytes().shell, 4 * tool_.shell.codes.size());
}

TEST_F(Published, OctreeForceIsNearTheRaceFreeOne) {
  const auto program = make_program({"octree", "published"}, "auto", setup_);
  expect_near_race_free(*program);
  EXPECT_EQ(program->bytes().voxmap, 5U * 256 * 256 * 256);
  EXPECT_EQ(program->bytes().shell, 12 * tool_.shell.codes.size());
}

TEST_F(Published, RestoringPutsTheBoneBack) {
  const Substep frame = substeps_of(Contact::severe)[0];
  for (const char* engine : {"direct", "octree"}) {
    const auto program = make_program({engine, "published"}, "auto", setup_, true);
    const auto first = program->run({&frame, 1}, true).contacts;
    EXPECT_LT(program->run({&frame, 1}, true).contacts, first / 100) << "the bone is gone there";
    for (const char* after : {"two frames", "one"}) {
      program->restore();
      EXPECT_NEAR(static_cast<double>(program->run({&frame, 1}, true).contacts), static_cast<double>(first),
                  0.05 * static_cast<double>(first))
          << after;
    }
  }
}

TEST_F(Published, EngineRestoresVoxelByVoxel) {
  const auto program = make_program({"direct", "deterministic"}, "auto", setup_);
  const Substep frame = substeps_of(Contact::severe)[0];
  const auto first = program->run({&frame, 1}, true);
  EXPECT_GT(first.voxels, 300);
  EXPECT_EQ(program->run({&frame, 1}, true).voxels, 0);
  program->restore();
  const auto again = program->run({&frame, 1}, false);
  EXPECT_EQ(again.voxels, first.voxels) << "with and without VOI";
  EXPECT_EQ(again.force, first.force);
}

}  // namespace
}  // namespace reamsim::bench
