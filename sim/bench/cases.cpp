// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>

#include "sim/base/error.h"
#include "sim/base/stopwatch.h"
#include "sim/bench/measure.h"

namespace reamsim::bench {

namespace {

double mean_touching(const ProgramSet& set, const std::vector<Substep>& frames) {
  double sum = 0;
  for (const Substep& frame : frames) {
    sum += static_cast<double>(count_touching(*set.setup.voxmap, *set.setup.tool, frame));
  }
  return sum / static_cast<double>(frames.size());
}

/// Mean time of `step` in µs, which is too short to time once.
template <class Step>
double microseconds(Step step) {
  constexpr int kTimes = 10'000;
  int done = 0;
  const Stopwatch stopwatch;
  for (int i = 0; i < kTimes; ++i) done += step() ? 1 : 0;
  const double us = stopwatch.seconds() / kTimes * 1e6;
  return done >= 0 ? us : 0;
}

PhaseRow phases_of(const ProgramSet& set, const Program& program, const std::vector<BatchSample>& samples) {
  const BenchSetup& setup = set.setup;
  const Rigid tool_from_bone = substeps_of(Contact::severe).front().pose.bone_from_tool().inverse();
  PhaseRow row{.at = set.place(program, "severe")};
  row.obb = microseconds([&] { return boxes_overlap(setup.tool_box, setup.bone_box, tool_from_bone); });
  row.voi =
      microseconds([&] { return volume_of_interest(setup.tool_box, setup.bone_box, tool_from_bone).has_value(); });
  row.upload = spread_over(samples, &BatchSample::upload_s, 1e6).median;
  row.kernel = spread_over(samples, &BatchSample::kernel_s, 1e6).median;
  row.total = spread_over(samples, &BatchSample::total_s, 1e6).median;
  row.read = std::max(0.0, row.total - row.obb - row.voi - row.upload - row.kernel);
  return row;
}

void set_ratios(Findings& findings) {
  for (CaseRow& row : findings.cases) {
    if (row.at.contact == "plunge") continue;  // measure_plunge() compares frame by frame
    const CaseRow* direct = findings.find({"direct", "published"}, row.at.voxmap, row.at.shell, row.at.contact);
    if (direct != nullptr && row.ms.median > 0) row.ratio_to_direct = direct->ms.median / row.ms.median;
  }
}

/// The plunge of a program: mean times of its batches of frames.
struct PlungeRun {
  Program* program = nullptr;
  std::vector<BatchSample> chunks;
  double spent_s = 0;
  std::size_t frames = 0;

  /// The two programs of the ratio always finish.
  [[nodiscard]] bool continues() const {
    constexpr double kMost_s = 20;
    const Label& who = program->label();
    return spent_s <= kMost_s || who.engine == "bricked" || is_published_direct();
  }
  [[nodiscard]] bool is_published_direct() const {
    return program->label().engine == "direct" && program->label().variant == "published";
  }

  void run(std::span<const Substep> chunk) {
    BatchSample sample = program->run(chunk, true);
    spent_s += sample.total_s;
    frames += chunk.size();
    const auto count = static_cast<double>(chunk.size());
    sample.total_s /= count;
    sample.kernel_s /= count;
    chunks.push_back(sample);
  }
};

std::vector<Substep> plunge_frames(const Plan& plan, const ProgramSet& set) {
  const Approach& approach = kApproaches[0];
  const double step_mm = 0.25 * set.setup.voxmap->grid.voxel_mm;
  std::vector<Substep> frames;
  for (int k = 1; k <= plan.plunge_frames; ++k) {
    frames.push_back(substep_at(pose_at(approach, approach.depth_mm[1] + step_mm * k)));
  }
  return frames;
}

CaseRow plunge_row(const ProgramSet& set, const PlungeRun& run, const std::vector<BatchSample>& direct) {
  CaseRow row{.at = set.place(*run.program, "plunge")};
  if (row.at.who.variant == "deterministic") {
    double voxels = 0;
    for (const BatchSample& sample : run.chunks) voxels += static_cast<double>(sample.voxels);
    row.contacts = voxels / static_cast<double>(run.frames);
  }
  row.ms = spread_over(run.chunks, &BatchSample::total_s);
  row.kernel_ms = spread_over(run.chunks, &BatchSample::kernel_s).median;
  if (direct.size() >= run.chunks.size()) {
    const std::vector<BatchSample> same(direct.begin(), direct.begin() + std::ssize(run.chunks));
    row.ratio_to_direct = spread_over(same, &BatchSample::total_s).median / row.ms.median;
  }
  return row;
}

}  // namespace

void measure_case(const Plan& plan, const ProgramSet& set, Contact contact, const BenchControl& control,
                  Findings& findings) {
  const auto frames = substeps_of(contact);
  const auto programs = pointers_to(set);
  const auto samples = run_alternately(programs, frames, plan.repetitions, true, control);
  const double touching = mean_touching(set, frames);
  for (std::size_t i = 0; i < programs.size(); ++i) {
    CaseRow row{.at = set.place(*programs[i], name_of(contact))};
    const bool points = row.at.who.engine != "implicit";
    row.contacts = points ? touching : spread_over(samples[i], &BatchSample::voxels, 1).median;
    row.ms = spread_over(samples[i], &BatchSample::total_s);
    row.kernel_ms = spread_over(samples[i], &BatchSample::kernel_s).median;
    findings.cases.push_back(row);
    if (contact == Contact::severe) findings.phases.push_back(phases_of(set, *programs[i], samples[i]));
  }
  set_ratios(findings);
}

void measure_memory(const ProgramSet& set, Findings& findings) {
  for (const auto& program : set.programs) {
    const std::string& engine = program->label().engine;
    const bool known = std::any_of(findings.memory.begin(), findings.memory.end(), [&](const MemoryRow& row) {
      return row.engine == engine && row.voxmap == set.voxmap && row.shell == set.shell;
    });
    if (known) continue;
    const StructureBytes bytes = program->bytes();
    findings.memory.push_back({engine, set.voxmap, set.shell, static_cast<double>(bytes.voxmap) / 1e6,
                               static_cast<double>(bytes.shell) / 1e6});
  }
}

void measure_plunge(const Plan& plan, const ProgramSet& set, const BenchControl& control, Findings& findings) {
  constexpr std::size_t kBatch = 64;  // as `reamsim run` by default
  const std::vector<Substep> frames = plunge_frames(plan, set);
  std::vector<PlungeRun> runs;
  for (Program* program : pointers_to(set)) runs.push_back({.program = program, .chunks = {}});
  for (std::size_t first = 0; first < frames.size(); first += kBatch) {
    if (control.stop()) throw Interrupted();
    const std::span<const Substep> chunk(&frames[first], std::min(kBatch, frames.size() - first));
    for (PlungeRun& run : runs) {
      if (run.continues()) run.run(chunk);
    }
  }
  const auto direct =
      std::find_if(runs.begin(), runs.end(), [](const PlungeRun& r) { return r.is_published_direct(); });
  for (const PlungeRun& run : runs) {
    run.program->restore();
    findings.cases.push_back(plunge_row(set, run, direct == runs.end() ? std::vector<BatchSample>{} : direct->chunks));
    if (run.frames == frames.size()) continue;
    findings.skipped.push_back({findings.cases.back().at,
                                "stopped after " + std::to_string(run.frames) + " of " + std::to_string(frames.size()) +
                                    " frames, which took 20 s; its ratio is over these frames"});
  }
}

}  // namespace reamsim::bench
