// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The quick suite, every figure within its tolerance, and windows of smooth motion against exact erosion frame by
// frame: the largest differences over its scenes and a tool that tilts.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <iostream>

#include "sim/engine/common/engine.h"
#include "sim/scenario/parse.h"
#include "sim/scene/scene.h"
#include "sim/verify/suite.h"
#include "tests/engine/outcome.h"
#include "tests/support/real_data.h"
#include "tests/verify/findings.h"

namespace reamsim::verify {
namespace {

/// Sums by substep of a run in windows, and of the same run frame by frame.
struct Runs {
  std::vector<SubstepSums> windowed, framed;
  bool any_window = false;
};

/// Runs every substep twice: on an engine with windows, whose results it gives, and on one without.
class BothEngines final : public Engine {
 public:
  BothEngines(std::unique_ptr<Engine> windowed, std::unique_ptr<Engine> framed, std::shared_ptr<Runs> runs)
      : windowed_(std::move(windowed)), framed_(std::move(framed)), runs_(std::move(runs)) {}

  void enqueue(const SubstepArgs& args, std::shared_ptr<const MotionWindow> window) override {
    runs_->any_window |= window != nullptr;
    windowed_->enqueue(args, std::move(window));
    framed_->enqueue(args, nullptr);
  }
  Batch collect() override {
    Batch batch = windowed_->collect();
    const auto append = [](auto& to, const auto& from) { to.insert(to.end(), from.begin(), from.end()); };
    append(runs_->windowed, batch.sums);
    append(runs_->framed, framed_->collect().sums);
    return batch;
  }
  [[nodiscard]] bool full() const override { return windowed_->full() || framed_->full(); }
  RemovedFrames take_removed() override {
    framed_->take_removed();
    return windowed_->take_removed();
  }
  void read_fill(const Voxmap& voxmap, FillBricks& fill) override { windowed_->read_fill(voxmap, fill); }
  void restore(const BoneView& bone) override {
    windowed_->restore(bone);
    framed_->restore(bone);
  }
  [[nodiscard]] std::string device() const override { return windowed_->device(); }
  [[nodiscard]] std::size_t device_bytes() const override { return windowed_->device_bytes(); }
  [[nodiscard]] StructureBytes structure_bytes() const override { return windowed_->structure_bytes(); }

 private:
  std::unique_ptr<Engine> windowed_, framed_;
  std::shared_ptr<Runs> runs_;
};

/// Force, torque, energy and volume of a substep.
using Loads = std::array<double, 8>;

Loads loads_of(const SubstepSums& s) {
  return {double(s.force[0]),  double(s.force[1]),  double(s.force[2]), double(s.torque[0]),
          double(s.torque[1]), double(s.torque[2]), double(s.energy),   double(s.removed)};
}

/// Largest differences of a run. Force and torque relative to the peak of their magnitude.
struct Difference {
  double volume = 0, energy = 0, mean = 0, single = 0;
};

/// Magnitude of force (0) or torque (3), or the energy (6).
double size_of(const Loads& loads, std::size_t first) {
  if (first == 6) return std::abs(loads[6]);
  return std::hypot(loads[first], loads[first + 1], loads[first + 2]);
}

Loads minus(const Loads& a, const Loads& b) {
  Loads out{};
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = a[i] - b[i];
  return out;
}

Difference difference_of(const Runs& runs) {
  constexpr std::size_t kMean = 64;
  Loads total{}, total_framed{}, peak{};
  std::vector<Loads> off;
  for (std::size_t i = 0; i < runs.framed.size(); ++i) {
    const Loads windowed = loads_of(runs.windowed[i]), framed = loads_of(runs.framed[i]);
    off.push_back(minus(windowed, framed));
    for (std::size_t k = 0; k < total.size(); ++k) {
      total[k] += windowed[k];
      total_framed[k] += framed[k];
    }
    for (const std::size_t first : {0U, 3U, 6U}) peak[first] = std::max(peak[first], size_of(framed, first));
  }
  Difference out;
  if (total_framed[7] == 0) return out;
  out.volume = std::abs(total[7] / total_framed[7] - 1);
  if (total_framed[6] != 0) out.energy = std::abs(total[6] / total_framed[6] - 1);
  for (const std::size_t first : {0U, 3U, 6U}) {
    if (peak[first] == 0) continue;
    Loads mean{};
    for (std::size_t i = 0; i < off.size(); ++i) {
      out.single = std::max(out.single, size_of(off[i], first) / peak[first]);
      for (std::size_t k = 0; k < mean.size(); ++k) mean[k] += off[i][k] / kMean;
      if ((i + 1) % kMean != 0) continue;
      out.mean = std::max(out.mean, size_of(mean, first) / peak[first]);
      mean = {};
    }
  }
  return out;
}

/// Makes both engines, and keeps their sums in `all`.
EngineMaker both_engines(std::vector<std::shared_ptr<Runs>>& all) {
  return [&all](const Scenario& scenario, const BoneView& bone, const Tool& tool) -> std::unique_ptr<Engine> {
    auto engine = make_engine(scenario, bone, tool);
    if (scenario.cutting.erosion != ErosionMode::exact) return engine;
    all.push_back(std::make_shared<Runs>());
    return std::make_unique<BothEngines>(std::move(engine), make_engine(scenario, bone, tool), all.back());
  };
}

/// Bounds of force, torque and energy, of the peak.
struct Bounds {
  double single = 3e-4;  ///< of a frame
  double mean = 1e-5;    ///< of the mean of 64 frames
};

/// Checks the runs, and prints their largest differences.
void expect_agreement(const std::string& name, const std::vector<std::shared_ptr<Runs>>& all,
                      const Bounds& bounds = {}) {
  Difference worst;
  bool any_window = false;
  for (const auto& runs : all) {
    const Difference found = difference_of(*runs);
    worst.volume = std::max(worst.volume, found.volume);
    worst.energy = std::max(worst.energy, found.energy);
    worst.mean = std::max(worst.mean, found.mean);
    worst.single = std::max(worst.single, found.single);
    any_window |= runs->any_window;
  }
  std::cout << name << (any_window ? "" : " (no windows)") << ": volume " << worst.volume << ", energy " << worst.energy
            << ", mean of 64 frames " << worst.mean << ", single frame " << worst.single << '\n';
  EXPECT_LE(worst.volume, 1e-5) << name;
  EXPECT_LE(worst.energy, 1e-5) << name;
  EXPECT_LE(worst.mean, bounds.mean) << name;
  EXPECT_LE(worst.single, bounds.single) << name;
}

class WindowsAgree : public testing::TestWithParam<std::string> {};

TEST_P(WindowsAgree, WithFrameByFrame) {
  std::vector<std::shared_ptr<Runs>> all;
  Setting setting;
  setting.engine = both_engines(all);
  expect_complete_and_passed(run_case(GetParam(), setting), GetParam());
  expect_agreement(GetParam(), all);
}

std::vector<std::string> rigid_ids() {
  std::vector<std::string> out = case_ids();
  std::erase_if(out, [](const std::string& id) { return id.starts_with("compliance_"); });  // they never have windows
  return out;
}

INSTANTIATE_TEST_SUITE_P(Verify, WindowsAgree, testing::ValuesIn(rigid_ids()),
                         [](const auto& chosen) { return chosen.param; });

TEST(WindowsAgree, WithFrameByFrameWhereTheToolTilts) {
  // 512 frames of feed, sideways motion and tilt at the rates of a hand.
  SimulationInput scene;
  scene.scenario = test::quiet_scenario("auto");
  scene.scenario.cutting.erosion = ErosionMode::exact;
  scene.bone.set_voxels(test::block({36, 36, 8}, 0.25, 1.2));
  scene.tool = test::make_tool(test::cap_profile(29, 30, 9, 0), 61);
  ToolPose begin{.position_mm = {0.3, 0.2, -2}, .orientation = Quat::Identity(), .spin_angle_rad = 0, .spin_rpm = 250};
  ToolPose end = begin;
  end.position_mm += Vec3(0.05, 0.03, -0.2);
  end.orientation = Eigen::AngleAxisd(0.01, Vec3(1, 0.3, 0).normalized());
  end.spin_angle_rad = 250 * 2 * M_PI / 60 * 0.512;
  constexpr int kFrames = 512;
  std::vector<ToolPose> poses;
  for (int k = 0; k <= kFrames; ++k) poses.push_back(interpolate(begin, end, double(k) / kFrames));
  scene.motion.poses = std::move(poses);
  std::vector<std::shared_ptr<Runs>> all;
  const auto engine = both_engines(all)(scene.scenario, scene.bone.view(), scene.tool);
  test::run_on(*engine, scene);
  ASSERT_TRUE(all.front()->any_window);
  // Here the tool advances by 100 units of fill per frame. Both ways round fill to units, and single precision decides
  // some of these roundings differently: forces of single frames differ by 1.4e-4 RMS.
  expect_agreement("tilting", all, {.single = 3.5e-4});
}

TEST(WindowsAgree, WithFrameByFrameOnAScan) {
  const std::string scan = test::data_file("shoulder_ct/shoulder_left.nrrd");
  if (!std::filesystem::exists(scan)) GTEST_SKIP() << "no " << scan << "; set REAMSIM_DATA";
  Diagnostics report;
  const SimulationInput scene = load_scene(parse_scenario(REAMSIM_TRAJECTORIES "/ct_shoulder.yaml", {}), report);
  std::vector<std::shared_ptr<Runs>> all;
  const auto engine = both_engines(all)(scene.scenario, scene.bone.view(), scene.tool);
  test::run_on(*engine, scene);
  ASSERT_TRUE(all.front()->any_window);
  // Near the spin axis a voxel passes from one piece of the outline to the next: it then loses up to 0.7 % of its
  // volume in one frame of the path without windows. At the rim a voxel loses up to 3 % when the tool reaches its bone,
  // which can be a frame earlier or later. Where the tool is slow, one voxel has a large force.
  expect_agreement("shoulder", all, {.single = 3e-3, .mean = 2e-5});
}

}  // namespace
}  // namespace reamsim::verify
