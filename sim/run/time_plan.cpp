// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/run/time_plan.h"

#include <algorithm>
#include <limits>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/stopwatch.h"
#include "sim/scenario/picture_frames.h"

namespace reamsim {

namespace {

constexpr int kWindows = 10;
constexpr std::int64_t kWindowFrames = 64;
/// Batches of the serial engine are small, because it is slow.
constexpr int kSerialBatch = 4;

/// Records the times at which batches of frames finish.
class BatchTimes : public FrameSink {
 public:
  void frame(const FrameResult& result, const FrameTimes&) override {
    frames_ = result.frame;
    last_s_ = watch_.seconds();
    if (begins_) ends_.emplace_back(last_s_, 0);
    ends_.back().second = frames_;
    begins_ = frames_ == 0;  // frame 0 is a batch of its own
  }
  /// The next frame belongs to another batch.
  void end_batch() { begins_ = true; }
  void snapshot(std::int64_t, FillBricks&) override {
    read_s_ = std::max(read_s_, watch_.seconds() - last_s_);
    last_s_ = watch_.seconds();
  }
  void removed(const RemovedFrames&) override {}

  /// That of the fastest batch; the first may include the compilation of kernels.
  [[nodiscard]] double seconds_per_frame() const {
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t i = 1; i < ends_.size(); ++i) {
      const auto frames = static_cast<double>(ends_[i].second - ends_[i - 1].second);
      if (frames > 0) best = std::min(best, (ends_[i].first - ends_[i - 1].first) / frames);
    }
    return best;
  }
  [[nodiscard]] std::int64_t frames() const { return frames_; }
  /// Longest read-back of the bone for a snapshot.
  [[nodiscard]] double read_s() const { return read_s_; }

 private:
  Stopwatch watch_;
  double last_s_ = 0;
  double read_s_ = 0;
  bool begins_ = true;
  std::int64_t frames_ = 0;
  std::vector<std::pair<double, std::int64_t>> ends_;  // per batch: time, last frame
};

/// The middle of a window, and its time per frame.
struct Timed {
  double frame;
  double seconds_per_frame;
};

/// Integral of the time per frame: linear between the windows, constant before the first and after the last.
double integrate_s(const std::vector<Timed>& timed, double frames) {
  double sum = timed.front().frame * timed.front().seconds_per_frame +
               (frames - timed.back().frame) * timed.back().seconds_per_frame;
  for (std::size_t i = 1; i < timed.size(); ++i) {
    sum += 0.5 * (timed[i].frame - timed[i - 1].frame) * (timed[i].seconds_per_frame + timed[i - 1].seconds_per_frame);
  }
  return sum;
}

/// Runs the frames of the scene for at most `most_s` seconds.
BatchTimes time_window(SimulationInput& scene, Engine& engine, double most_s) {
  BatchTimes times;
  Diagnostics discarded;
  RunControl control;
  const Stopwatch watch;
  control.progress = [&](std::int64_t, std::int64_t) { times.end_batch(); };
  control.stop = [&] { return watch.seconds() > most_s; };
  try {
    simulate(scene, engine, times, control, discarded);
  } catch (const Interrupted&) {
    // The window has used its time.
  }
  return times;
}

}  // namespace

TimePlan plan_time(SimulationInput& scene, Engine& engine, double budget_s) {
  const Motion motion = scene.motion;
  const PoseSequence& poses = motion.poses;
  std::vector<Pass> later_passes = std::exchange(scene.later_passes, {});
  scene.motion.first_frame = 0;
  scene.motion.push.reset();  // its way without resistance is timed
  const Scenario original = scene.scenario;
  scene.scenario.render.every_frames = std::numeric_limits<int>::max();  // no snapshots in between
  if (original.engine.device == "serial") scene.scenario.engine.batch_frames = kSerialBatch;
  const auto all = static_cast<std::int64_t>(poses.size()) - 1;
  const std::int64_t window = std::min(all, kWindowFrames);
  const auto first_of = [&](int i) { return (all - window) * i / (kWindows - 1); };
  TimePlan plan;
  std::vector<Timed> timed;
  double read_s = 0;
  const Stopwatch watch;
  for (int i = 0; i < kWindows && window > 0 && watch.seconds() < budget_s; ++i) {
    const std::int64_t first = first_of(i);
    if (i > 0 && first == first_of(i - 1)) continue;  // a run shorter than the windows
    scene.motion.poses = poses.part(static_cast<std::size_t>(first), static_cast<std::size_t>(window) + 1);
    const BatchTimes times = time_window(scene, engine, budget_s / kWindows);
    read_s = std::max(read_s, times.read_s());
    const auto frames = static_cast<double>(times.frames());
    if (frames == 0) continue;
    timed.push_back({static_cast<double>(first) + 0.5 * frames, times.seconds_per_frame()});
    plan.timed_frames += times.frames();
  }
  plan.windows = static_cast<int>(timed.size());
  scene.motion = motion;
  scene.later_passes = std::move(later_passes);
  scene.scenario = original;
  if (timed.empty()) return plan;
  // A snapshot is read back and written to disk, which takes about as long.
  const auto in_pass = [&](std::int64_t frame) { return frame >= motion.first_frame && frame <= motion.last_frame(); };
  const auto snapshots = static_cast<double>(
      std::ranges::count_if(picture_frames(original.render, scene.last_frame(), scene.contact), in_pass));
  plan.simulate_s = integrate_s(timed, static_cast<double>(all)) + 2 * snapshots * read_s;
  return plan;
}

}  // namespace reamsim
