// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The C++ frame that `bricked` is measured against computes the same: sums and voxels, on every instruction set that
// this processor has.
#include "tests/bench/reference/reference.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <ostream>

#include "sim/base/error.h"
#include "sim/bench/scene.h"
#include "sim/engine/common/engine.h"
#include "sim/engine/common/substep.h"

namespace reamsim {

bool operator==(const SubstepSums& a, const SubstepSums& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

namespace reference {
namespace {

using bench::Contact;

struct Scene {
  FilledVoxmap bone = bench::BoneSeries(64).at(256);
  Tool tool = bench::cap_tool(256);
};

std::unique_ptr<Engine> bricked(const Scene& scene) {
  Scenario scenario;
  scenario.name = "reference";
  scenario.engine.type = EngineKind::bricked;
  scenario.cutting = bench::bench_cutting();
  return make_engine(scenario, scene.bone, scene.tool);
}

struct Outcome {
  SubstepSums sums;
  std::vector<std::int64_t> gone;
};

Outcome run(Engine& engine, const SubstepArgs& args) {
  engine.enqueue(args);
  Outcome out{engine.collect().sums.at(0), {}};
  for (const auto& [voxel, frame] : engine.take_removed()) out.gone.push_back(voxel);
  std::sort(out.gone.begin(), out.gone.end());
  return out;
}

/// From none to severe, so that every frame but the first ones finds bone that others have left.
std::vector<SubstepArgs> all_frames(const Scene& scene) {
  const Aabb bone = bench::BoneSeries(64).box(256);
  std::vector<SubstepArgs> out;
  for (const Contact contact : {Contact::none, Contact::light, Contact::severe}) {
    for (const Substep& frame : bench::substeps_of(contact)) {
      const auto voi = broad_phase(bench::shell_box(scene.tool), bone, frame.pose.bone_from_tool().inverse());
      if (!voi) continue;
      out.push_back(make_args(frame, *voi, scene.tool.shell, scene.bone.grid, bench::bench_cutting(), false));
    }
  }
  return out;
}

TEST(BenchReference, AgreesWithBrickedToTheLastBit) {
  const Scene scene;
  const auto frames = all_frames(scene);
  ASSERT_EQ(frames.size(), bench::kContacts.size() * bench::kApproaches.size());
  const auto engine = bricked(scene);
  std::vector<Outcome> expected;
  for (const SubstepArgs& args : frames) expected.push_back(run(*engine, args));
  EXPECT_GT(expected.back().sums.contacts, 1000);
  for (const Target target : usable_targets()) {
    for (const unsigned threads : {1U, 3U}) {
      Reference reference(scene.bone, scene.tool, bench::bench_cutting(), target, threads);
      for (std::size_t i = 0; i < frames.size(); ++i) {
        EXPECT_TRUE(reference.run(frames[i]) == expected[i].sums) << name_of(target) << ", frame " << i;
        EXPECT_EQ(reference.removed_voxels(), expected[i].gone) << name_of(target) << ", frame " << i;
      }
    }
  }
}

TEST(BenchReference, RestoredBoneGivesTheSameFrameAgain) {
  const Scene scene;
  const auto frames = all_frames(scene);
  Reference reference(scene.bone, scene.tool, bench::bench_cutting(), usable_targets().back(), 2);
  const SubstepSums first = reference.run(frames.back());
  const auto gone = reference.removed_voxels();
  EXPECT_EQ(static_cast<std::int64_t>(gone.size()), first.contacts);
  reference.restore();
  EXPECT_TRUE(reference.run(frames.back()) == first);
  EXPECT_EQ(reference.removed_voxels(), gone);
  // Without: the bone that the first frame took is no longer there.
  EXPECT_EQ(reference.run(frames.back()).contacts, 0);
}

TEST(BenchReference, RefusesWhatItDoesNotCompute) {
  const Scene scene;
  CuttingSettings wear = bench::bench_cutting(), per_point = wear;
  wear.erosion = ErosionMode::wear;
  per_point.law = CuttingLaw::per_point;
  EXPECT_THROW(Reference(scene.bone, scene.tool, wear, Target::plain, 1), RunError);
  EXPECT_THROW(Reference(scene.bone, scene.tool, per_point, Target::plain, 1), RunError);
}

}  // namespace
}  // namespace reference
}  // namespace reamsim
