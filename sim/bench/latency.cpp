// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bench/latency.h"

#include <algorithm>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/statistics.h"
#include "sim/base/stopwatch.h"

namespace reamsim::bench {

namespace {

/// Keeps nothing: what becomes of the rows is no part of the latency.
class NoSink final : public FrameSink {
 public:
  void frame(const FrameResult&, const FrameTimes&) override {}
  void snapshot(std::int64_t, FillBricks&) override {}
  void removed(const RemovedFrames&) override {}
};

}  // namespace

Latency frame_latency(SimulationInput& scene, Engine& engine, std::int64_t most, const std::function<bool()>& stop) {
  const Motion& motion = scene.motion;
  NoSink sink;
  Diagnostics ignored;
  FrameStepper stepper(scene, engine, sink, ignored);
  const auto frame_of = [&](std::int64_t k) {
    return FrameMotion{.frame = k,
                       .before = motion.pose_of(std::max<std::int64_t>(k - 1, 0)),
                       .pose = motion.pose_of(k),
                       .duration_s = motion.frame_s(),
                       .time_s = static_cast<double>(k) * motion.frame_s()};
  };
  stepper.start(frame_of(0));
  std::vector<double> ms;
  for (std::int64_t k = 1; k <= motion.last_frame() && std::ssize(ms) < most; ++k) {
    if (stop()) throw Interrupted();
    const FrameMotion frame = frame_of(k);
    const Stopwatch watch;
    stepper.add(frame);
    stepper.finish_batch();
    const double frame_ms = 1e3 * watch.seconds();
    if (stepper.last().contacts > 0) ms.push_back(frame_ms);
  }
  ms.erase(ms.begin(), ms.begin() + static_cast<std::ptrdiff_t>(std::min(kWarmUpFrames, ms.size())));
  if (ms.empty()) return {};
  return {.frames = std::ssize(ms),
          .median_ms = quantile(ms, 0.5),
          .p99_ms = quantile(ms, 0.99),
          .p999_ms = quantile(ms, 0.999),
          .most_ms = *std::ranges::max_element(ms)};
}

}  // namespace reamsim::bench
