// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "sim/bench/suite.h"

namespace reamsim::bench {

/// Calls `measure`; where the device cannot do it (InputError, RunError, no memory), notes that in `skipped`.
void measure_or_skip(const Place& at, std::vector<Skipped>& skipped, const std::function<void()>& measure);

/// The programs of one setup, and what the parts of the benchmark share.
struct ProgramSet {
  const Plan& plan;
  const BenchControl& control;
  Findings& findings;
  BenchSetup setup;
  SizePair size;
  std::vector<std::unique_ptr<Program>> programs;

  [[nodiscard]] Place place(const Program& program, const std::string& contact) const {
    return {program.label(), size.voxmap, size.shell, contact};
  }
};

/// Adds every program of the plan's engines in all its variants. Programs that the device cannot hold are added to
/// Findings::skipped. `whole`: also engines without a shell.
void make_programs(ProgramSet& set, bool whole);

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
  return spread_of(values);
}

/// Adds the device memory of an engine, unless it is known.
void add_memory(const std::string& engine, const SizePair& size, const StructureBytes& bytes, Findings& findings);

/// Compares a case with published `direct`, if that was measured.
void set_ratio(const Findings& findings, CaseRow& row);

// The parts of the benchmark; each adds its rows to the findings.
void measure_case(const ProgramSet& set, Contact contact);
void measure_memory(const ProgramSet& set);
void measure_voi(const ProgramSet& set);
void measure_batches(const ProgramSet& set);
void measure_plunge(const ProgramSet& set);
void measure_scatter(const ProgramSet& set);
void measure_exact_case(const ProgramSet& set, const std::string& contact);
/// Calls `begin` before each sphere.
void measure_spheres(const Plan& plan, const BenchControl& control,
                     const std::function<void(const std::string&)>& begin, Findings& findings);

/// Measures the device: fused multiply-adds in registers, and a copy of 256 MB. The best of some repetitions.
MachinePeaks measure_peaks(const cl::DeviceInfo& info);

}  // namespace reamsim::bench
