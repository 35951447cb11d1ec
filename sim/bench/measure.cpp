// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bench/measure.h"

#include <algorithm>
#include <cmath>
#include <new>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/statistics.h"
#include "sim/base/stopwatch.h"

namespace reamsim {
namespace embedded {
extern const char* const kernel_peaks;
}

namespace bench {

namespace {

/// The programs that touch voxels with a shell or the tool's surface, fastest engine first. `exact` needs the motion
/// before a frame (whole_frames.cpp).
const Label kPrograms[] = {{"bricked", "deterministic"}, {"direct", "deterministic"}, {"direct", "published"},
                           {"octree", "deterministic"},  {"octree", "published"},     {"implicit", "deterministic"}};

}  // namespace

const std::vector<std::string>& engine_names() {
  static const std::vector<std::string> names{"exact", "bricked", "direct", "octree", "implicit"};
  return names;
}

void measure_or_skip(Json row, Json& report, const std::function<void()>& measure) {
  const auto skip = [&](const char* reason) {
    row["reason"] = reason;
    report["skipped"].push_back(std::move(row));
  };
  try {
    measure();
  } catch (const InputError& error) {
    skip(error.what());
  } catch (const RunError& error) {
    skip(error.what());
  } catch (const std::bad_alloc&) {
    skip("not enough memory for the copy of the bone");
  }
}

void make_programs(ProgramSet& set, bool whole) {
  for (const Label& label : kPrograms) {
    if (std::ranges::count(set.plan.engines, label.engine) == 0) continue;
    if (!whole && label.engine == "implicit") continue;  // has no shell
    measure_or_skip(case_row(label, set.size, "all"), set.report,
                    [&] { set.programs.push_back(make_program(label, set.plan.device, set.setup)); });
  }
}

std::vector<std::vector<BatchSample>> run_alternately(const Programs& programs, const std::vector<Substep>& frames,
                                                      int repetitions, bool use_voi, const BenchControl& control) {
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

Latency frame_latency(SimulationInput& scene, Engine& engine, std::int64_t most, const std::function<bool()>& stop) {
  const Motion& motion = scene.motion;
  FrameSink sink;  // what becomes of the rows is no part of the latency
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

namespace {

constexpr int kRepetitions = 5;

/// The shortest time of a kernel, s.
double shortest(const cl::Kernel& kernel, const cl::Device& device, std::size_t items) {
  double best = INFINITY;
  for (int i = 0; i < kRepetitions; ++i) {
    std::vector<cl::Event> events;
    events.push_back(kernel.launch(device, items, 1));
    device.finish();
    best = std::min(best, cl::take_seconds(events).front());
  }
  return best;
}

}  // namespace

Json measure_peaks(const cl::DeviceInfo& info) {
  constexpr std::size_t kVector = 16 * sizeof(cl_float), kItems = 4096, kVectors = 512;
  constexpr cl_int kRounds = 4096;
  constexpr double kOperations = 256;  // of a round
  const cl::Device device(info);
  const cl::Program program = device.build("peaks.cl", embedded::kernel_peaks);
  const cl::Buffer<cl_uchar> from(device, kItems * kVectors * kVector, "memory to copy");
  const cl::Buffer<cl_uchar> to(device, from.count(), "a copy of memory");
  cl::Kernel multiply_add(program, "fused_multiply_adds"), copy(program, "copy_memory");
  multiply_add.set_from(0, to, kRounds);
  copy.set_from(0, from, to, static_cast<cl_int>(kVectors));
  return {{"gops", 1e-9 * kOperations * kRounds * kItems / shortest(multiply_add, device, kItems)},
          {"gb_s", 1e-9 * 2 * static_cast<double>(from.count()) / shortest(copy, device, kItems)},
          {"operations_per_voxel", kExactOperations},
          {"bytes_per_voxel", kExactBytes}};
}

}  // namespace bench
}  // namespace reamsim
