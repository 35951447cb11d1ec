#pragma once

#include <memory>
#include <vector>

#include "sim/bench/findings.h"
#include "sim/bench/poses.h"
#include "sim/bench/suite.h"

namespace reamsim::bench {

/// The contenders of one arena, and why others are missing.
struct Field {
  Arena arena;
  int voxmap = 0;
  int shell = 0;
  std::vector<std::unique_ptr<Contender>> contenders;

  [[nodiscard]] Place place(const Contender& contender, const std::string& contact) const {
    return {contender.label(), voxmap, shell, contact};
  }
};

/// Sets up every program of the plan's engines, each in the variants that it has. Those that the device cannot hold go
/// to `skipped`. `whole`: with those that have no shell.
Field make_field(const Plan& plan, const Arena& arena, const SizePair& size, bool whole, std::vector<Skipped>& skipped);

/// Runs the frames one by one, each contender in turn, `repetitions` times in two rounds, each after one that warms up:
/// a frame follows one at the same place, as in a run, where caches hold what the tool is about to touch. Samples by
/// contender. Throws Interrupted.
std::vector<std::vector<BatchSample>> take_turns(const std::vector<Contender*>& contenders,
                                                 const std::vector<Substep>& frames, int repetitions, bool use_voi,
                                                 const Watch& watch);
std::vector<Contender*> all_of(const Field& field);

/// Median and spread over samples of `value`.
template <class Value>
Spread spread_over(const std::vector<BatchSample>& samples, Value value) {
  std::vector<double> values;
  for (const BatchSample& sample : samples) values.push_back(value(sample));
  return spread_of(std::move(values));
}

// The parts of a run; each adds its rows to the findings.
void measure_case(const Plan& plan, const Field& field, Contact contact, const Watch& watch, Findings& findings);
void measure_memory(const Field& field, Findings& findings);
void measure_voi(const Plan& plan, const Field& field, const Watch& watch, Findings& findings);
void measure_batches(const Plan& plan, const Field& field, const Watch& watch, Findings& findings);
void measure_plunge(const Plan& plan, const Field& field, const Watch& watch, Findings& findings);
void measure_scatter(const Plan& plan, const Field& field, const Watch& watch, Findings& findings);
void measure_spheres(const Plan& plan, const Watch& watch, Findings& findings);

}  // namespace reamsim::bench
