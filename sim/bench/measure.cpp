// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bench/measure.h"

#include <algorithm>
#include <new>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/statistics.h"
#include "sim/base/stopwatch.h"

namespace reamsim::bench {

namespace {

/// The programs that touch voxels with a shell or the tool's surface, fastest engine first. `exact` needs the motion
/// before a frame (whole_frames.h).
const Label kPrograms[] = {{"bricked", "deterministic"}, {"direct", "deterministic"}, {"direct", "published"},
                           {"octree", "deterministic"},  {"octree", "published"},     {"implicit", "deterministic"}};

std::unique_ptr<Program> make_program(const Label& label, const cl::DeviceInfo& device, const Plan& plan,
                                      const BenchSetup& setup) {
  if (label.variant == "deterministic") return make_engine_program(label.engine, plan.device, setup);
  return label.engine == "octree" ? make_published_octree(device, setup) : make_published_direct(device, setup, false);
}

}  // namespace

const std::vector<std::string>& engine_names() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> out{"exact"};
    for (const Label& label : kPrograms) {
      if (out.empty() || out.back() != label.engine) out.push_back(label.engine);
    }
    return out;
  }();
  return names;
}

void measure_or_skip(const Place& at, std::vector<Skipped>& skipped, const std::function<void()>& measure) {
  try {
    measure();
  } catch (const InputError& error) {
    skipped.push_back({at, error.what()});
  } catch (const RunError& error) {
    skipped.push_back({at, error.what()});
  } catch (const std::bad_alloc&) {
    skipped.push_back({at, "not enough memory for the copy of the bone"});
  }
}

ProgramSet make_programs(const Plan& plan, const BenchSetup& setup, const SizePair& size, bool whole,
                         std::vector<Skipped>& skipped) {
  ProgramSet set{setup, size.voxmap, size.shell, {}};
  const cl::DeviceInfo device = cl::choose_device(plan.device);
  for (const Label& label : kPrograms) {
    if (std::ranges::count(plan.engines, label.engine) == 0) continue;
    if (!whole && label.engine == "implicit") continue;  // has no shell
    measure_or_skip({label, size.voxmap, size.shell, "all"}, skipped,
                    [&] { set.programs.push_back(make_program(label, device, plan, setup)); });
  }
  return set;
}

std::vector<Program*> pointers_to(const ProgramSet& set) {
  std::vector<Program*> out;
  for (const auto& program : set.programs) out.push_back(program.get());
  return out;
}

std::vector<std::vector<BatchSample>> run_alternately(const std::vector<Program*>& programs,
                                                      const std::vector<Substep>& frames, int repetitions, bool use_voi,
                                                      const BenchControl& control) {
  constexpr int kRounds = 2;
  std::vector<std::vector<BatchSample>> samples(programs.size());
  for (int round = 0; round < kRounds; ++round) {
    const int timed = repetitions * (round + 1) / kRounds - repetitions * round / kRounds;
    for (const Substep& frame : frames) {
      for (std::size_t i = 0; i < programs.size(); ++i) {
        if (control.stop()) throw Interrupted();
        for (int repetition = -1; repetition < timed; ++repetition) {
          programs[i]->prepare(frame);
          const BatchSample sample = programs[i]->run({&frame, 1}, use_voi);
          if (repetition >= 0) samples[i].push_back(sample);
          programs[i]->restore();
        }
      }
    }
  }
  return samples;
}

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
