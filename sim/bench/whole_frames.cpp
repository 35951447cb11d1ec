// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bench/whole_frames.h"

#include <cstdlib>
#include <filesystem>
#include <limits>

#include "sim/base/error.h"
#include "sim/base/stopwatch.h"
#include "sim/record/recorder.h"
#include "sim/run/simulation.h"

namespace reamsim::bench {

namespace {

constexpr std::int64_t kWindowFrames = 64;  // kernels/window.h
constexpr double kRateHz = 1000;

/// A folder that exists as long as this object.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    path_ = (std::filesystem::temp_directory_path() / "reamsim-bench-XXXXXX").string();
    if (mkdtemp(path_.data()) == nullptr) throw RunError(path_ + ": cannot be created");
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::string path_;
};

/// Writes rows and adds up what the frames report.
class CountingSink final : public FrameSink {
 public:
  CountingSink(double voxel_mm, const std::string& dir) : recorder_(dir, voxel_mm) {}

  void frame(const FrameResult& result, const FrameTimes& times) override {
    recorder_.frame(result, times);
    kernel_s += times.detect_s + times.cut_s;
    contacts += result.contacts;
    removed_mm3 += result.removed_mm3;
  }
  void snapshot(std::int64_t /*frame*/, FillBricks& /*fill*/) override {}
  void removed(const RemovedFrames& /*voxels*/) override {}

  double kernel_s = 0;
  std::int64_t contacts = 0;
  double removed_mm3 = 0;

 private:
  Recorder recorder_;
};

SimulationInput scene_of(const ExactRuns& runs, const Motion& motion) {
  SimulationInput scene;
  scene.scenario.name = "bench";
  scene.scenario.cutting = bench_cutting();
  scene.scenario.cutting.erosion = ErosionMode::exact;
  scene.scenario.engine.device = runs.device;
  scene.scenario.engine.tuning.compute_units = runs.cores;
  scene.scenario.engine.batch_frames = static_cast<int>(kWindowFrames);
  scene.scenario.render.every_frames = std::numeric_limits<int>::max();  // a snapshot ends a batch
  scene.bone.set_voxels(FilledVoxmap(*runs.bone));
  scene.tool = *runs.tool;
  scene.motion = motion;
  return scene;
}

/// Times a run, and adds its windows to `out`. Returns the voxels that lose bone, summed over the timed frames.
double time_run(const ExactRuns& runs, const Motion& motion, const BenchControl& control, WholeFrames& out) {
  SimulationInput scene = scene_of(runs, motion);
  const std::unique_ptr<Engine> engine = load_engine(scene);
  const TemporaryFolder folder;
  CountingSink sink(runs.bone->grid.voxel_mm, folder.path());
  Stopwatch watch;
  double kernel_before_s = 0;
  std::int64_t contacts_before = 0, contacts = 0;
  RunControl hooks;
  hooks.stop = control.stop;
  hooks.progress = [&](std::int64_t frame, std::int64_t last) {
    if (frame == last) return;
    if (frame >= kWindowFrames) {
      out.ms.push_back(1e3 * watch.seconds() / kWindowFrames);
      out.kernel_ms.push_back(1e3 * (sink.kernel_s - kernel_before_s) / kWindowFrames);
    } else {
      contacts_before = sink.contacts;
    }
    contacts = sink.contacts;
    kernel_before_s = sink.kernel_s;
    watch = Stopwatch();
  };
  Diagnostics report;
  simulate(scene, *engine, sink, hooks, report);
  out.removed_mm3 = sink.removed_mm3;
  out.bytes = engine->structure_bytes();
  return static_cast<double>(contacts - contacts_before);
}

}  // namespace

WholeFrames time_whole_frames(const ExactRuns& runs, const BenchControl& control) {
  WholeFrames out;
  double voxels = 0;
  for (const Motion& motion : runs.motions) voxels += time_run(runs, motion, control, out);
  out.voxels = voxels / static_cast<double>(kWindowFrames * std::ssize(out.ms));
  return out;
}

Motion straight_motion(const ToolPose& last, double feed_mm_s, int windows) {
  std::vector<ToolPose> poses;
  const std::int64_t frames = kWindowFrames * windows;
  const Vec3 up = last.orientation * Vec3::UnitZ();
  for (std::int64_t k = 0; k <= frames; ++k) {
    ToolPose pose = last;
    pose.position_mm += static_cast<double>(frames - 1 - k) * feed_mm_s / kRateHz * up;
    poses.push_back(pose);
  }
  return {kRateHz, std::move(poses)};
}

}  // namespace reamsim::bench
