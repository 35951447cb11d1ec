// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// reamsim/simulation.h gives what `reamsim run` gives.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <reamsim/simulation.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "sim/run/simulation.h"
#include "sim/scenario/parse.h"
#include "tests/engine/frame_rows.h"
#include "tests/support/temp_dir.h"

namespace reamsim::library_tests {
namespace {

class Library : public ::testing::Test {
 protected:
  Library() {
    std::ofstream(scenario()) << R"(version: 2
bone: {source: phantom, voxel_mm: 0.5, phantom: {shape: half_space, density_g_cm3: 0.6, size_mm: [36, 36, 6]}}
tool: {mesh: )" REAMSIM_ASSETS R"(/reamer_convex.stl}
motion:
  frame_rate_hz: 500
  plunge: {approach_mm: 0.2, depth_mm: 1, feed_mm_s: 2, dwell_s: 0.05, retract_mm: 2, retract_mm_s: 20}
)";
  }
  [[nodiscard]] std::string scenario() const { return dir_.path() + "/s.yaml"; }

  /// The rows of the main loop.
  [[nodiscard]] std::vector<FrameResult> rows_of_run(bool windows) const {
    Diagnostics report;
    SimulationInput scene = load_scene(parse_scenario(scenario(), {}), report);
    scene.scenario.engine.tuning.windows = windows;
    const auto engine = load_engine(scene);
    test::FrameRows sink;
    simulate(scene, *engine, sink, {}, report);
    return sink.rows;
  }

  static void expect_same(const std::vector<StepResult>& steps, const std::vector<FrameResult>& rows) {
    ASSERT_EQ(steps.size(), rows.size());
    for (std::size_t k = 0; k < rows.size(); ++k) {
      const StepResult& a = steps[k];
      const FrameResult& b = rows[k];
      ASSERT_EQ(a.frame, b.frame);
      ASSERT_EQ(a.time_s, b.time_s) << k;
      ASSERT_EQ(a.axial_force_n, b.axial_force_n) << k;
      ASSERT_EQ(Vec3(a.torque_nmm.data()), b.torque_nmm) << k;
      ASSERT_EQ(a.removed_mm3, b.removed_mm3) << k;
      ASSERT_EQ(a.depth_mm, b.depth_mm) << k;
      ASSERT_EQ(a.balance, b.balance) << k;
      ASSERT_EQ(Vec3(a.pose.position_mm.data()), b.pose.position_mm) << k;
      ASSERT_EQ(a.pose.spin_angle_rad, b.pose.spin_angle_rad) << k;
    }
  }

  [[nodiscard]] static std::string text_of(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  test::TempDir dir_;
};

TEST_F(Library, StepsGiveTheRowsOfARunWithoutWindows) {
  Simulation simulation(scenario());
  const std::vector<Pose> poses = simulation.planned_poses();
  std::vector<StepResult> steps{simulation.start(poses.front())};
  for (std::size_t k = 1; k < poses.size(); ++k) steps.push_back(simulation.step(poses[k]));
  expect_same(steps, rows_of_run(false));
  EXPECT_GT(simulation.removed_mm3(), 10);
}

TEST_F(Library, RunOfPosesGivesTheRowsOfARun) {
  Simulation simulation(scenario());
  const std::vector<Pose> poses = simulation.planned_poses();
  std::vector<StepResult> steps{simulation.start(poses.front())};
  const auto more = simulation.run(std::span(poses).subspan(1));
  steps.insert(steps.end(), more.begin(), more.end());
  expect_same(steps, rows_of_run(true));
}

TEST_F(Library, StateGoesBackInTime) {
  Simulation simulation(scenario());
  const std::vector<Pose> poses = simulation.planned_poses();
  simulation.start(poses.front());
  simulation.run(std::span(poses).subspan(1, 150));
  const Simulation::State state = simulation.state();
  const auto first = simulation.run(std::span(poses).subspan(151, 100));
  const Volume after = simulation.fill();
  simulation.restore(state);
  const auto again = simulation.run(std::span(poses).subspan(151, 100));
  ASSERT_EQ(first.size(), again.size());
  for (std::size_t k = 0; k < first.size(); ++k) {
    EXPECT_EQ(first[k].axial_force_n, again[k].axial_force_n);
    EXPECT_EQ(first[k].balance, again[k].balance);
    EXPECT_EQ(first[k].frame, again[k].frame);
  }
  EXPECT_EQ(simulation.fill().values, after.values);
  Simulation other(scenario());
  other.restore(state);
  EXPECT_EQ(other.run(std::span(poses).subspan(151, 1))[0].axial_force_n, first[0].axial_force_n);
}

TEST_F(Library, StateGoesThroughAFile) {
  Simulation simulation(scenario());
  const std::vector<Pose> poses = simulation.planned_poses();
  simulation.run(std::span(poses).first(151));
  const std::string path = dir_.path() + "/a.state";
  simulation.state().save(path);
  const auto first = simulation.run(std::span(poses).subspan(151, 100));
  Simulation other(scenario());
  other.restore(Simulation::State::load(path));
  EXPECT_EQ(other.frame(), 150);
  EXPECT_EQ(other.pose()->position_mm, poses[150].position_mm);
  const auto again = other.run(std::span(poses).subspan(151, 100));
  for (std::size_t k = 0; k < first.size(); ++k) ASSERT_EQ(first[k].axial_force_n, again[k].axial_force_n);
  EXPECT_EQ(other.fill().values, simulation.fill().values);
  EXPECT_EQ(other.removed_mm3(), simulation.removed_mm3());

  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 1);
  EXPECT_THROW(Simulation::State::load(path), BadInput);
  EXPECT_THROW(Simulation::State::load(dir_.path() + "/none"), BadInput);
  EXPECT_THROW(simulation.state().save(dir_.path() + "/none/a.state"), RunFailure);
}

TEST_F(Library, ARunBeginsWithItsFirstPoseAndEndsWhereItIsAskedTo) {
  Simulation simulation(scenario());
  const std::vector<Pose> poses = simulation.planned_poses();
  const auto steps = simulation.run(poses);
  expect_same(steps, rows_of_run(true));
  Simulation stopped(scenario());
  int batches = 0;
  const auto some = stopped.run(poses, [&batches] { return ++batches == 2; });
  ASSERT_LT(some.size(), poses.size());
  ASSERT_GT(some.size(), 1U);
  EXPECT_EQ(stopped.frame(), std::ssize(some) - 1);
  for (std::size_t k = 0; k < some.size(); ++k) ASSERT_EQ(some[k].axial_force_n, steps[k].axial_force_n) << k;
  const StepResult next = stopped.step(poses[some.size()]);
  EXPECT_EQ(next.frame, std::ssize(some));
  EXPECT_EQ(next.pose.position_mm, poses[some.size()].position_mm);
}

TEST_F(Library, PeekIsTheStepThatFollowsAndRemovesNothing) {
  Simulation simulation(scenario());
  const std::vector<Pose> poses = simulation.planned_poses();
  simulation.start(poses.front());
  simulation.run(std::span(poses).subspan(1, 200));
  const Volume before = simulation.fill();
  const StepResult peeked = simulation.peek(poses[201]);
  EXPECT_EQ(simulation.fill().values, before.values);
  const StepResult done = simulation.step(poses[201]);
  EXPECT_GT(done.removed_mm3, 0);
  EXPECT_EQ(peeked.axial_force_n, done.axial_force_n);
  EXPECT_EQ(peeked.removed_mm3, done.removed_mm3);
}

/// Every number of a step.
std::vector<double> numbers_of(const StepResult& step) {
  std::vector<double> out{static_cast<double>(step.frame),
                          step.time_s,
                          step.axial_force_n,
                          step.spin_torque_nmm,
                          step.depth_mm,
                          static_cast<double>(step.contacts),
                          step.removed_mm3,
                          step.energy_mj,
                          step.floor_energy_mj,
                          step.balance,
                          step.pose.spin_rpm,
                          step.pose.spin_angle_rad.value_or(-1)};
  for (const auto& v : {step.force_n, step.torque_nmm, step.pose.position_mm})
    out.insert(out.end(), v.begin(), v.end());
  out.insert(out.end(), step.pose.quaternion.begin(), step.pose.quaternion.end());
  return out;
}

// The bone that a substep meets is the one that the substeps before it leave.
TEST_F(Library, PeekHasTheSubstepsOfTheStep) {
  for (const char* change : {"engine.device=auto", "engine.device=serial", "engine.max_step_voxels=0.25",
                             "cutting.edge_force={tangential_n_mm: 2, normal_n_mm: 3, cutting_edges: 6}"}) {
    Simulation simulation(scenario(), {change});
    Pose at = simulation.planned_poses().front();
    at.spin_rpm = 300;
    const auto moved = [&at](double x, double z) {
      at.position_mm = {x, 0, z};
      return at;
    };
    simulation.start(moved(0, 1));
    for (const auto& [pose, dt] :
         std::vector<std::pair<Pose, std::optional<double>>>{{moved(0, -3), 0.5},    // from outside, many substeps
                                                             {moved(0, -3.01), {}},  // a single one
                                                             {moved(3, -4), 2.0},    // sideways within the bone
                                                             {moved(3, 6), 0.1},     // out of it
                                                             {moved(90, 40), 0.1},   // far from it
                                                             {moved(0, -4.5), 1.0}}) {
      const Volume before = simulation.fill();
      const std::vector<double> peeked = numbers_of(simulation.peek(pose, dt));
      EXPECT_EQ(simulation.fill().values, before.values);
      EXPECT_EQ(numbers_of(simulation.peek(pose, dt)), peeked) << "a second time";
      EXPECT_EQ(peeked, numbers_of(simulation.step(pose, dt))) << change << ", frame " << simulation.frame();
    }
    EXPECT_GT(simulation.removed_mm3(), 100);
  }
}

TEST_F(Library, FillAndDensityCoverTheBone) {
  Simulation simulation(scenario());
  const Volume fill = simulation.fill(), density = simulation.density();
  ASSERT_EQ(fill.values.size(), density.values.size());
  double mm3 = 0;
  for (const float f : fill.values) mm3 += f * fill.voxel_mm * fill.voxel_mm * fill.voxel_mm;
  EXPECT_NEAR(mm3, 36 * 36 * 6, 1);
  EXPECT_NEAR(*std::max_element(density.values.begin(), density.values.end()), 0.6, 0.008);
}

TEST_F(Library, SpringsAreLeftOutWithAWarning) {
  const Simulation rigid(scenario()), springs(scenario(), {"motion.compliance={stiffness_n_mm: [10, 10, 10]}"});
  EXPECT_THAT(rigid.warnings(), ::testing::Not(::testing::Contains(::testing::HasSubstr("motion.compliance"))));
  EXPECT_THAT(springs.warnings(), ::testing::Contains(::testing::HasSubstr("motion.compliance")));
}

TEST_F(Library, APushIsLeftOutWithAWarning) {
  const Simulation push(scenario(),
                        {"motion.plunge=null", "motion.push={thrust_n: 60, depth_mm: 1, approach_mm: 0.2}"});
  EXPECT_THAT(push.warnings(), ::testing::Contains(::testing::HasSubstr("motion.push: without a hand here")));
  EXPECT_GT(push.planned_poses().size(), 10U);
}

TEST_F(Library, MistakesAreTyped) {
  EXPECT_THROW(Simulation("no such file.yaml"), BadInput);
  EXPECT_THROW(Simulation(scenario(), {"bone.voxel_mm=-1"}), BadInput);
  Simulation simulation(scenario());
  const Pose start = simulation.planned_poses().front();
  EXPECT_THROW(simulation.step(start), BadInput);
  simulation.start(start);
  EXPECT_THROW(simulation.start(start), BadInput);
  Pose wrong = start;
  wrong.quaternion = {0, 0, 0, 0};
  EXPECT_THROW(simulation.step(wrong), BadInput);
  wrong = start;
  wrong.position_mm[1] = std::nan("");
  EXPECT_THROW(simulation.step(wrong), BadInput);
  EXPECT_THROW(simulation.step(start, 0.0), BadInput);
  for (const char* change : {"bone.voxel_mm=0.6", "bone.phantom.density_g_cm3=0.7"}) {
    Simulation other(scenario(), {change});
    EXPECT_THROW(other.restore(simulation.state()), BadInput) << change;
  }
  try {
    const Simulation wrong_feed(scenario(), {"motion.plunge.feed_mm_s=fast"});
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("motion.plunge.feed_mm_s"));
  }
}

TEST_F(Library, RunsAScenarioIntoAFolder) {
  const std::string dir = dir_.path() + "/results";
  std::int64_t last = 0, all = 0;
  RunOptions options{.set = {"motion.plunge.dwell_s=0"}, .dir = dir, .overwrite = false, .resume = false};
  options.progress = [&](std::int64_t done, std::int64_t total) { last = done, all = total; };
  EXPECT_EQ(run_scenario(scenario(), options).dir, dir);
  EXPECT_GT(all, 0);
  EXPECT_EQ(last, all);
  for (const char* name : {"forces.csv", "summary.json", "reamed.vdb", "scenario.yaml", "manifest.json"})
    EXPECT_TRUE(std::filesystem::exists(dir + "/" + name)) << name;
  EXPECT_FALSE(std::filesystem::exists(dir + "/reamed.png"));
  EXPECT_THROW(run_scenario(scenario(), options), BadInput) << "the folder exists";
  options.overwrite = true;
  options.set = {"motion.plunge.depth_mm=-1"};
  EXPECT_THROW(run_scenario(scenario(), options), BadInput);
}

TEST_F(Library, AStoppedRunGoesOnAndEndsTheSame) {
  const std::string whole = dir_.path() + "/whole", cut = dir_.path() + "/cut";
  run_scenario(scenario(), {.set = {}, .dir = whole});
  RunOptions options{.set = {"engine.batch_frames=10"}, .dir = cut, .overwrite = false, .resume = false};
  int calls = 0;
  options.stop = [&calls] { return ++calls > 3; };
  EXPECT_THROW(run_scenario(scenario(), options), Stopped);
  EXPECT_FALSE(std::filesystem::exists(cut));
  options.stop = nullptr;
  options.resume = true;
  run_scenario(scenario(), options);
  EXPECT_EQ(text_of(cut + "/forces.csv"), text_of(whole + "/forces.csv"));
}

}  // namespace
}  // namespace reamsim::library_tests
