// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <vector>

#include "sim/bench/findings.h"
#include "sim/bench/poses.h"
#include "sim/bench/suite.h"
#include "sim/run/simulation.h"

namespace reamsim::bench {

/// Calls `measure`; where the device cannot do it (InputError, RunError, no memory), notes that in `skipped`.
void measure_or_skip(const Place& at, std::vector<Skipped>& skipped, const std::function<void()>& measure);

/// The programs of one setup.
struct ProgramSet {
  BenchSetup setup;
  int voxmap = 0;
  int shell = 0;
  std::vector<std::unique_ptr<Program>> programs;

  [[nodiscard]] Place place(const Program& program, const std::string& contact) const {
    return {program.label(), voxmap, shell, contact};
  }
};

/// Creates every program of the plan's engines in all its variants. Programs that the device cannot hold are added to
/// `skipped`. `whole`: also engines without a shell.
ProgramSet make_programs(const Plan& plan, const BenchSetup& setup, const SizePair& size, bool whole,
                         std::vector<Skipped>& skipped);

/// Runs the frames one by one, each program in turn, `repetitions` times in two rounds, each after a warm-up: a frame
/// follows one at the same place, as in a run, where caches hold the data near the tool. Returns samples by program.
/// Throws Interrupted.
std::vector<std::vector<BatchSample>> run_alternately(const std::vector<Program*>& programs,
                                                      const std::vector<Substep>& frames, int repetitions, bool use_voi,
                                                      const BenchControl& control);
std::vector<Program*> pointers_to(const ProgramSet& set);

/// Median and spread over samples; `scale`: s to ms by default.
template <class Value>
Spread spread_over(const std::vector<BatchSample>& samples, Value BatchSample::*member, double scale = 1e3) {
  std::vector<double> values;
  for (const BatchSample& sample : samples) values.push_back(scale * static_cast<double>(sample.*member));
  return spread_of(std::move(values));
}

// The parts of the benchmark; each adds its rows to the findings.
void measure_case(const Plan& plan, const ProgramSet& set, Contact contact, const BenchControl& control,
                  Findings& findings);
void measure_memory(const ProgramSet& set, Findings& findings);
void measure_voi(const Plan& plan, const ProgramSet& set, const BenchControl& control, Findings& findings);
void measure_batches(const Plan& plan, const ProgramSet& set, const BenchControl& control, Findings& findings);
void measure_plunge(const Plan& plan, const ProgramSet& set, const BenchControl& control, Findings& findings);
void measure_scatter(const Plan& plan, const ProgramSet& set, const BenchControl& control, Findings& findings);
void measure_exact_case(const Plan& plan, const BenchSetup& setup, const SizePair& size, const std::string& contact,
                        const BenchControl& control, Findings& findings);
void measure_spheres(const Plan& plan, const BenchControl& control, Findings& findings);

/// The first frames in contact are left out: caches and clocks of the processor are not as they will be.
inline constexpr std::size_t kWarmUpFrames = 20;

/// Wall time of a frame alone: pose in, force out, nothing batched and no windows, as a haptic device needs it.
struct Latency {
  std::int64_t frames = 0;  ///< in contact, that were timed
  double median_ms = 0;
  double p99_ms = 0;
  double p999_ms = 0;
  double most_ms = 0;
};

/// Moves the tool of the scene along its motion frame by frame, and times those in contact but the first 20, in which
/// memory of the device grows. Ends after `most` of them. Throws Interrupted, RunError.
Latency frame_latency(SimulationInput& scene, Engine& engine, std::int64_t most, const std::function<bool()>& stop);

}  // namespace reamsim::bench
