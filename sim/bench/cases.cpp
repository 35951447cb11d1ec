#include <algorithm>

#include "sim/base/error.h"
#include "sim/base/stopwatch.h"
#include "sim/bench/field.h"

namespace reamsim::bench {

namespace {

double mean_touching(const Field& field, const std::vector<Substep>& frames) {
  double sum = 0;
  for (const Substep& frame : frames) {
    sum += static_cast<double>(count_touching(*field.arena.voxmap, *field.arena.tool, frame));
  }
  return sum / static_cast<double>(frames.size());
}

/// Mean time of `step` in µs; it is far too short to time by itself.
template <class Step>
double microseconds(Step step) {
  constexpr int kTimes = 10'000;
  int done = 0;
  const Stopwatch watch;
  for (int i = 0; i < kTimes; ++i) done += step() ? 1 : 0;
  const double us = watch.seconds() / kTimes * 1e6;
  return done >= 0 ? us : 0;
}

PhaseRow phases_of(const Field& field, const Contender& contender, const std::vector<BatchSample>& samples) {
  const Arena& arena = field.arena;
  const Rigid tool_from_bone = substeps_of(Contact::severe).front().pose.bone_from_tool().inverse();
  PhaseRow row{.at = field.place(contender, "severe")};
  row.obb = microseconds([&] { return boxes_overlap(arena.tool_box, arena.bone_box, tool_from_bone); });
  row.voi =
      microseconds([&] { return volume_of_interest(arena.tool_box, arena.bone_box, tool_from_bone).has_value(); });
  row.upload = 1e6 * spread_over(samples, [](const BatchSample& s) { return s.upload_s; }).median;
  row.kernel = 1e6 * spread_over(samples, [](const BatchSample& s) { return s.kernel_s; }).median;
  row.total = 1e6 * spread_over(samples, [](const BatchSample& s) { return s.total_s; }).median;
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

/// A contender's way through the plunge: mean times of its chunks of frames.
struct PlungeRun {
  Contender* contender = nullptr;
  std::vector<BatchSample> chunks;
  double spent_s = 0;
  std::size_t frames = 0;

  /// The two that the ratio is of go all the way, however long it takes.
  [[nodiscard]] bool goes_on() const {
    constexpr double kPatience = 20;  // s
    const Label& who = contender->label();
    return spent_s <= kPatience || who.engine == "bricked" || is_published_direct();
  }
  [[nodiscard]] bool is_published_direct() const {
    return contender->label().engine == "direct" && contender->label().variant == "published";
  }

  void run(std::span<const Substep> chunk) {
    BatchSample sample = contender->run(chunk, true);
    spent_s += sample.total_s;
    frames += chunk.size();
    const auto share = static_cast<double>(chunk.size());
    sample.total_s /= share;
    sample.kernel_s /= share;
    chunks.push_back(sample);
  }
};

std::vector<Substep> plunge_frames(const Plan& plan, const Field& field) {
  const Approach& approach = kApproaches[0];
  const double step_mm = 0.25 * field.arena.voxmap->grid.voxel_mm;
  std::vector<Substep> frames;
  for (int k = 1; k <= plan.plunge_frames; ++k) {
    frames.push_back(substep_at(pose_at(approach, approach.depth_mm[1] + step_mm * k)));
  }
  return frames;
}

CaseRow plunge_row(const Field& field, const PlungeRun& run, const std::vector<BatchSample>& direct) {
  const auto total = [](const BatchSample& s) { return 1e3 * s.total_s; };
  CaseRow row{.at = field.place(*run.contender, "plunge")};
  if (row.at.who.variant == "deterministic") {
    double voxels = 0;
    for (const BatchSample& sample : run.chunks) voxels += static_cast<double>(sample.voxels);
    row.contacts = voxels / static_cast<double>(run.frames);
  }
  row.ms = spread_over(run.chunks, total);
  row.kernel_ms = spread_over(run.chunks, [](const BatchSample& s) { return 1e3 * s.kernel_s; }).median;
  if (direct.size() >= run.chunks.size()) {
    const std::vector<BatchSample> same(direct.begin(), direct.begin() + std::ssize(run.chunks));
    row.ratio_to_direct = spread_over(same, total).median / row.ms.median;
  }
  return row;
}

}  // namespace

void measure_case(const Plan& plan, const Field& field, Contact contact, const Watch& watch, Findings& findings) {
  const auto frames = substeps_of(contact);
  const auto contenders = all_of(field);
  const auto samples = take_turns(contenders, frames, plan.repetitions, true, watch);
  const double touching = mean_touching(field, frames);
  for (std::size_t i = 0; i < contenders.size(); ++i) {
    CaseRow row{.at = field.place(*contenders[i], name_of(contact))};
    const bool points = row.at.who.engine != "implicit";
    row.contacts =
        points ? touching
               : spread_over(samples[i], [](const BatchSample& s) { return static_cast<double>(s.voxels); }).median;
    row.ms = spread_over(samples[i], [](const BatchSample& s) { return 1e3 * s.total_s; });
    row.kernel_ms = spread_over(samples[i], [](const BatchSample& s) { return 1e3 * s.kernel_s; }).median;
    findings.cases.push_back(row);
    if (contact == Contact::severe) findings.phases.push_back(phases_of(field, *contenders[i], samples[i]));
  }
  set_ratios(findings);
}

void measure_memory(const Field& field, Findings& findings) {
  for (const auto& contender : field.contenders) {
    const std::string& engine = contender->label().engine;
    const bool known = std::any_of(findings.memory.begin(), findings.memory.end(), [&](const MemoryRow& row) {
      return row.engine == engine && row.voxmap == field.voxmap && row.shell == field.shell;
    });
    if (known) continue;
    const StructureBytes bytes = contender->bytes();
    findings.memory.push_back({engine, field.voxmap, field.shell, static_cast<double>(bytes.voxmap) / 1e6,
                               static_cast<double>(bytes.shell) / 1e6});
  }
}

void measure_plunge(const Plan& plan, const Field& field, const Watch& watch, Findings& findings) {
  constexpr std::size_t kBatch = 32;  // as `reamsim run` by default
  const std::vector<Substep> frames = plunge_frames(plan, field);
  std::vector<PlungeRun> runs;
  for (Contender* contender : all_of(field)) runs.push_back({.contender = contender, .chunks = {}});
  for (std::size_t first = 0; first < frames.size(); first += kBatch) {
    if (watch.stop()) throw Interrupted();
    const std::span<const Substep> chunk(&frames[first], std::min(kBatch, frames.size() - first));
    for (PlungeRun& run : runs) {
      if (run.goes_on()) run.run(chunk);
    }
  }
  const auto direct =
      std::find_if(runs.begin(), runs.end(), [](const PlungeRun& r) { return r.is_published_direct(); });
  for (const PlungeRun& run : runs) {
    run.contender->restore();
    findings.cases.push_back(
        plunge_row(field, run, direct == runs.end() ? std::vector<BatchSample>{} : direct->chunks));
    if (run.frames == frames.size()) continue;
    findings.skipped.push_back({findings.cases.back().at,
                                "stopped after " + std::to_string(run.frames) + " of " + std::to_string(frames.size()) +
                                    " frames, which took 20 s; its ratio is over these frames"});
  }
}

}  // namespace reamsim::bench
