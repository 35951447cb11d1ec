// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "sim/bench/suite.h"

namespace reamsim::bench {

/// A row with the keys of a case: program, sizes and case (severe | light | none | plunge). `implicit` has no shell;
/// its rows have the largest.
Json case_row(const Label& who, const SizePair& size, const std::string& contact);
/// The keys median_ms, min_ms and max_ms.
Json spread_ms(const Spread& ms);
/// Adds the results of a case to the report: touching points, mean over the poses (plunge, implicit and exact: voxels
/// per frame; null: not known), host wall time and median device time of a frame, and the median of published `direct`
/// over this one, if that was measured.
Json& add_result(Json row, const Json& contacts, const Spread& ms, double kernel_ms, Json& report);

/// Calls `measure`; where the device cannot do it (InputError, RunError, no memory), lists the case with the reason.
void measure_or_skip(Json row, Json& report, const std::function<void()>& measure);

/// The programs of one setup, and what the parts of the benchmark share.
struct ProgramSet {
  const Plan& plan;
  const BenchControl& control;
  Json& report;
  BenchSetup setup;
  SizePair size;
  std::vector<std::unique_ptr<Program>> programs;

  [[nodiscard]] Json row(const Program& program, const std::string& contact) const {
    return case_row(program.label(), size, contact);
  }
};

/// Adds every program of the plan's engines in all its variants that the device can hold. `whole`: also engines without
/// a shell.
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
void add_memory(const std::string& engine, const SizePair& size, const StructureBytes& bytes, Json& report);

// The parts of the benchmark; each adds its rows to the report.
void measure_case(const ProgramSet& set, Contact contact);
void measure_memory(const ProgramSet& set);
void measure_voi(const ProgramSet& set);
void measure_batches(const ProgramSet& set);
void measure_plunge(const ProgramSet& set);
void measure_scatter(const ProgramSet& set);
void measure_exact_case(const ProgramSet& set, const std::string& contact);
/// Calls `begin` before each sphere.
void measure_spheres(const Plan& plan, const BenchControl& control,
                     const std::function<void(const std::string&)>& begin, Json& report);

/// What a device does at most, as the report has it: 10⁹ operations a second in single precision, a fused multiply-add
/// as two, in registers; 10⁹ bytes a second, read and written, of a copy of 256 MB. The best of some repetitions.
Json measure_peaks(const cl::DeviceInfo& info);

}  // namespace reamsim::bench
