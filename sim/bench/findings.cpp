// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bench/findings.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "sim/base/error.h"
#include "sim/bench/measure.h"

namespace reamsim::bench {

Spread spread_of(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size(), middle = n / 2;
  const double median = n % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
  return {median, values.front(), values.back(), static_cast<int>(n)};
}

const CaseRow* Findings::find(const Label& who, int voxmap, int shell, const std::string& contact) const {
  const auto row = std::find_if(cases.begin(), cases.end(), [&](const CaseRow& r) {
    return r.at.who.engine == who.engine && r.at.who.variant == who.variant && r.at.voxmap == voxmap &&
           r.at.shell == shell && r.at.contact == contact;
  });
  return row == cases.end() ? nullptr : &*row;
}

namespace {

double volume(const Aabb& box) {
  return (box.max - box.min).prod();
}

/// Fraction of the tool's box that is VOI at a pose.
double voi_fraction(const BenchSetup& setup, const ToolPose& pose) {
  const auto voi = broad_phase(setup.tool_box, setup.bone_box, pose.bone_from_tool().inverse());
  return voi ? volume(*voi) / volume(setup.tool_box) : 0;
}

/// The depth of the first approach at which the VOI is `fraction` of the tool's box.
double depth_of_fraction(const BenchSetup& setup, double fraction) {
  double low = -20, high = 30;  // mm: clear of the bone's box, wholly in it
  for (int i = 0; i < 50; ++i) {
    const double middle = (low + high) / 2;
    (voi_fraction(setup, pose_at(kApproaches[0], middle)) < fraction ? low : high) = middle;
  }
  return high;
}

/// Programs that cull points outside the VOI.
std::vector<Program*> with_voi(const ProgramSet& set) {
  std::vector<Program*> out;
  for (Program* program : pointers_to(set)) {
    const std::string& engine = program->label().engine;
    if (engine == "bricked" || engine == "direct") out.push_back(program);
  }
  return out;
}

double mean(const std::vector<double>& values) {
  return std::reduce(values.begin(), values.end()) / static_cast<double>(values.size());
}

double deviation(const std::vector<double>& values) {
  const double middle = mean(values);
  double sum = 0;
  for (const double v : values) sum += (v - middle) * (v - middle);
  return values.size() > 1 ? std::sqrt(sum / static_cast<double>(values.size() - 1)) : 0;
}

ScatterRow scatter_of(const Place& at, const std::vector<BatchSample>& samples) {
  std::vector<double> contacts, magnitude;
  std::array<std::vector<double>, 3> components;
  for (const BatchSample& sample : samples) {
    contacts.push_back(static_cast<double>(sample.contacts));
    magnitude.push_back(sample.force.norm());
    for (int i = 0; i < 3; ++i) components[static_cast<std::size_t>(i)].push_back(sample.force[i]);
  }
  ScatterRow row{
      .at = at, .repetitions = static_cast<int>(samples.size()), .voxels = {}, .contacts = spread_of(contacts)};
  const double force = mean(magnitude), count = mean(contacts);
  if (!(force > 0) || !(count > 0)) return row;
  row.force_spread = deviation(magnitude) / force;
  for (const auto& component : components) {
    row.component_spread = std::max(row.component_spread, deviation(component) / force);
  }
  row.contacts_spread = deviation(contacts) / count;
  return row;
}

}  // namespace

void measure_voi(const Plan& plan, const ProgramSet& set, const BenchControl& control, Findings& findings) {
  const auto programs = with_voi(set);
  for (int tenth = 1; tenth <= 10; ++tenth) {
    const double fraction = std::min(0.1 * tenth, 0.9999);
    const Substep frame = substep_at(pose_at(kApproaches[0], depth_of_fraction(set.setup, fraction)));
    const auto with = run_alternately(programs, {frame}, plan.repetitions, true, control);
    const auto without = run_alternately(programs, {frame}, plan.repetitions, false, control);
    const auto touching = count_touching(*set.setup.voxmap, *set.setup.tool, frame);
    for (std::size_t i = 0; i < programs.size(); ++i) {
      findings.voi.push_back({programs[i]->label(), 0.1 * tenth, static_cast<double>(touching),
                              spread_over(with[i], &BatchSample::total_s),
                              spread_over(without[i], &BatchSample::total_s)});
    }
  }
}

void measure_batches(const Plan& plan, const ProgramSet& set, const BenchControl& control, Findings& findings) {
  const auto poses = substeps_of(Contact::none);  // nothing is removed, so that a batch may repeat them
  for (const int batch : {1, 8, 64}) {
    std::vector<Substep> frames;
    for (int k = 0; k < batch; ++k) frames.push_back(poses[static_cast<std::size_t>(k) % poses.size()]);
    for (Program* program : pointers_to(set)) {
      if (program->label().variant != "deterministic" || program->label().engine == "implicit") continue;
      std::vector<double> ms;
      for (int repetition = -1; repetition < plan.repetitions; ++repetition) {
        if (control.stop()) throw Interrupted();
        const BatchSample sample = program->run(frames, true);
        if (repetition >= 0) ms.push_back(1e3 * sample.total_s / batch);
      }
      program->restore();
      findings.batches.push_back({set.place(*program, "none"), batch, spread_of(ms)});
    }
  }
}

void measure_scatter(const Plan& plan, const ProgramSet& set, const BenchControl& control, Findings& findings) {
  constexpr int kRepetitions = 20;
  const Substep frame = substeps_of(Contact::severe)[1];
  const auto touching = static_cast<double>(count_touching(*set.setup.voxmap, *set.setup.tool, frame));
  std::optional<double> voxels;
  std::unique_ptr<Program> counting;
  std::vector<Program*> racing;
  if (std::ranges::count(plan.engines, "direct") > 0) {
    counting = make_published_direct(cl::choose_device(plan.device), set.setup, true);
    racing.push_back(counting.get());
  }
  for (Program* program : pointers_to(set)) {
    const Label& label = program->label();
    if (label.variant == "published" && label.engine == "octree") racing.push_back(program);
    if (label.variant == "deterministic" && label.engine != "implicit" && !voxels) {
      voxels = static_cast<double>(program->run({&frame, 1}, true).voxels);
      program->restore();
    }
  }
  const auto samples = run_alternately(racing, {frame}, kRepetitions, true, control);
  for (std::size_t i = 0; i < racing.size(); ++i) {
    ScatterRow row = scatter_of(set.place(*racing[i], "severe"), samples[i]);
    row.points = touching;
    row.voxels = voxels;
    findings.scatter.push_back(row);
  }
}

}  // namespace reamsim::bench
