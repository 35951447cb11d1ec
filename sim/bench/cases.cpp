// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bench/measure.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <string>

#include "sim/base/error.h"
#include "sim/base/statistics.h"
#include "sim/base/stopwatch.h"
#include "sim/bone/implicit.h"

namespace reamsim::bench {

Spread spread_of(const std::vector<double>& values) {
  if (values.empty()) return {};
  const auto [least, most] = std::ranges::minmax(values);
  return {quantile(values, 0.5), least, most, static_cast<int>(values.size())};
}

const Json* find_result(const Json& report, const Label& who, int voxmap, int shell, const std::string& contact) {
  const Json& results = report["results"];
  const auto row = std::find_if(results.begin(), results.end(), [&](const Json& r) {
    return r["engine"] == who.engine && r["variant"] == who.variant && r["voxmap"] == voxmap && r["shell"] == shell &&
           r["case"] == contact;
  });
  return row == results.end() ? nullptr : &*row;
}

Json case_row(const Label& who, const SizePair& size, const std::string& contact) {
  return {{"engine", who.engine},
          {"variant", who.variant},
          {"voxmap", size.voxmap},
          {"shell", size.shell},
          {"case", contact}};
}

Json spread_ms(const Spread& ms) {
  return {{"median_ms", ms.median}, {"min_ms", ms.min}, {"max_ms", ms.max}};
}

namespace {

void set_ratio(const Json& report, Json& row) {
  const Json* direct = find_result(report, {"direct", "published"}, row["voxmap"], row["shell"], row["case"]);
  const double ms = row["median_ms"];
  if (direct != nullptr && ms > 0) row["ratio_to_direct"] = (*direct)["median_ms"].get<double>() / ms;
}

/// The depth of the first approach at which the VOI is `fraction` of the tool's box.
double depth_of_fraction(const BenchSetup& setup, double fraction) {
  const auto volume = [](const Aabb& box) { return (box.max - box.min).prod(); };
  const auto is_less = [&](double mm) {
    const Rigid tool_from_bone = pose_at(kApproaches[0], mm).bone_from_tool().inverse();
    const auto voi = broad_phase(setup.tool_box, setup.bone_box, tool_from_bone);
    return (voi ? volume(*voi) / volume(setup.tool_box) : 0) < fraction;
  };
  return implicit::bisect(-20, 30, 50, is_less).outside;  // mm: clear of the bone's box, wholly in it
}

double deviation(const std::vector<double>& values) {
  const double middle = mean(values);
  double sum = 0;
  for (const double v : values) sum += (v - middle) * (v - middle);
  return values.size() > 1 ? std::sqrt(sum / static_cast<double>(values.size() - 1)) : 0;
}

/// Adds the spreads of the samples to a row.
void add_scatter(const std::vector<BatchSample>& samples, Json& row) {
  std::vector<double> contacts, magnitude;
  std::array<std::vector<double>, 3> components;
  for (const BatchSample& sample : samples) {
    contacts.push_back(static_cast<double>(sample.contacts));
    magnitude.push_back(sample.force.norm());
    for (int i = 0; i < 3; ++i) components[static_cast<std::size_t>(i)].push_back(sample.force[i]);
  }
  const Spread counted = spread_of(contacts);
  const double force = mean(magnitude), count = mean(contacts);
  const bool any = force > 0 && count > 0;
  double component_spread = 0;
  for (const auto& component : components)
    component_spread = std::max(component_spread, any ? deviation(component) / force : 0);
  row.update({{"contacts_median", counted.median},
              {"contacts_min", counted.min},
              {"contacts_max", counted.max},
              {"contacts_spread", any ? deviation(contacts) / count : 0},
              {"force_spread", any ? deviation(magnitude) / force : 0},
              {"component_spread", component_spread}});
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

Json phases_of(const ProgramSet& set, const Program& program, const std::vector<BatchSample>& samples) {
  const BenchSetup& setup = set.setup;
  const Rigid tool_from_bone = substeps_of(Contact::severe).front().pose.bone_from_tool().inverse();
  const double obb = microseconds([&] { return boxes_overlap(setup.tool_box, setup.bone_box, tool_from_bone); });
  const double voi =
      microseconds([&] { return volume_of_interest(setup.tool_box, setup.bone_box, tool_from_bone).has_value(); });
  const double upload = spread_over(samples, &BatchSample::upload_s, 1e6).median;
  const double kernel = spread_over(samples, &BatchSample::kernel_s, 1e6).median;
  const double total = spread_over(samples, &BatchSample::total_s, 1e6).median;
  Json row = set.row(program, "severe");
  row.update({{"obb_us", obb},
              {"voi_us", voi},
              {"upload_us", upload},
              {"kernel_us", kernel},
              {"read_us", std::max(0.0, total - obb - voi - upload - kernel)},
              {"total_us", total}});
  return row;
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
    return spent_s <= kMost_s || program->label().engine == "bricked" || is_published_direct();
  }
  [[nodiscard]] bool is_published_direct() const { return program->label() == Label{"direct", "published"}; }

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

std::vector<Substep> plunge_frames(const ProgramSet& set) {
  const Approach& approach = kApproaches[0];
  const double step_mm = 0.25 * set.setup.voxmap->grid.voxel_mm;
  std::vector<Substep> frames;
  for (int k = 1; k <= set.plan.plunge_frames; ++k) {
    frames.push_back(substep_at(pose_at(approach, approach.depth_mm[1] + step_mm * k)));
  }
  return frames;
}

/// Compares frame by frame where the frames of a program are not all.
void add_plunge(const ProgramSet& set, const PlungeRun& run, const std::vector<BatchSample>& direct) {
  Json voxels_per_frame;
  if (run.program->label().variant == "deterministic") {
    double voxels = 0;
    for (const BatchSample& sample : run.chunks) voxels += static_cast<double>(sample.voxels);
    voxels_per_frame = voxels / static_cast<double>(run.frames);
  }
  const Spread ms = spread_over(run.chunks, &BatchSample::total_s);
  Json& row = add_result(set.row(*run.program, "plunge"), voxels_per_frame, ms,
                         spread_over(run.chunks, &BatchSample::kernel_s).median, set.report);
  row["ratio_to_direct"] = nullptr;
  if (direct.size() >= run.chunks.size()) {
    const std::vector<BatchSample> same(direct.begin(), direct.begin() + std::ssize(run.chunks));
    row["ratio_to_direct"] = spread_over(same, &BatchSample::total_s).median / ms.median;
  }
}

}  // namespace

Json& add_result(Json row, const Json& contacts, const Spread& ms, double kernel_ms, Json& report) {
  row["contacts"] = contacts;
  row.update(spread_ms(ms));
  row.update({{"kernel_ms", kernel_ms}, {"ratio_to_direct", nullptr}, {"samples", ms.samples}});
  set_ratio(report, row);
  return report["results"].emplace_back(std::move(row));
}

void measure_voi(const ProgramSet& set) {
  Programs programs = set.programs;
  std::erase_if(programs, [](const auto& program) {  // which do not cull points outside the VOI
    return program->label().engine != "bricked" && program->label().engine != "direct";
  });
  for (int tenth = 1; tenth <= 10; ++tenth) {
    const double fraction = std::min(0.1 * tenth, 0.9999);
    const Substep frame = substep_at(pose_at(kApproaches[0], depth_of_fraction(set.setup, fraction)));
    const auto with = run_alternately(programs, {frame}, set.plan.repetitions, true, set.control);
    const auto without = run_alternately(programs, {frame}, set.plan.repetitions, false, set.control);
    const auto touching = count_touching(*set.setup.voxmap, *set.setup.tool, frame);
    for (std::size_t i = 0; i < programs.size(); ++i) {
      const Spread with_ms = spread_over(with[i], &BatchSample::total_s);
      const Spread without_ms = spread_over(without[i], &BatchSample::total_s);
      set.report["voi"].push_back({{"engine", programs[i]->label().engine},
                                   {"variant", programs[i]->label().variant},
                                   {"fraction", 0.1 * tenth},
                                   {"contacts", static_cast<double>(touching)},
                                   {"with_ms", with_ms.median},
                                   {"with_min_ms", with_ms.min},
                                   {"with_max_ms", with_ms.max},
                                   {"without_ms", without_ms.median},
                                   {"without_min_ms", without_ms.min},
                                   {"without_max_ms", without_ms.max}});
    }
  }
}

void measure_batches(const ProgramSet& set) {
  const auto poses = substeps_of(Contact::none);  // nothing is removed, so that a batch may repeat them
  for (const int batch : {1, 8, 64}) {
    std::vector<Substep> frames;
    for (int k = 0; k < batch; ++k) frames.push_back(poses[static_cast<std::size_t>(k) % poses.size()]);
    for (const auto& program : set.programs) {
      if (program->label().variant != "deterministic" || program->label().engine == "implicit") continue;
      std::vector<double> ms;
      for (int repetition = -1; repetition < set.plan.repetitions; ++repetition) {
        if (set.control.stop()) throw Interrupted();
        const BatchSample sample = program->run(frames, true);
        if (repetition >= 0) ms.push_back(1e3 * sample.total_s / batch);
      }
      program->restore();
      Json row = set.row(*program, "none");
      row["batch"] = batch;
      row.update(spread_ms(spread_of(ms)));
      set.report["batches"].push_back(row);
    }
  }
}

void measure_scatter(const ProgramSet& set) {
  constexpr int kRepetitions = 20;
  const Substep frame = substeps_of(Contact::severe)[1];
  const auto touching = static_cast<double>(count_touching(*set.setup.voxmap, *set.setup.tool, frame));
  Json voxels;  // null without such a program
  Programs racing;
  if (std::ranges::count(set.plan.engines, "direct") > 0) {
    const Label counting{"direct", "published"};
    measure_or_skip(case_row(counting, set.size, "scatter"), set.report,
                    [&] { racing.push_back(make_program(counting, set.plan.device, set.setup, true)); });
  }
  for (const auto& program : set.programs) {
    const Label& label = program->label();
    if (label == Label{"octree", "published"}) racing.push_back(program);
    if (label.variant == "deterministic" && label.engine != "implicit" && voxels.is_null()) {
      voxels = static_cast<double>(program->run({&frame, 1}, true).voxels);
      program->restore();
    }
  }
  const auto samples = run_alternately(racing, {frame}, kRepetitions, true, set.control);
  for (std::size_t i = 0; i < racing.size(); ++i) {
    Json row = set.row(*racing[i], "severe");
    row.update({{"repetitions", samples[i].size()}, {"points", touching}, {"voxels", voxels}});
    add_scatter(samples[i], row);
    set.report["scatter"].push_back(row);
  }
}

void measure_case(const ProgramSet& set, Contact contact) {
  const auto frames = substeps_of(contact);
  const Programs& programs = set.programs;
  const auto samples = run_alternately(programs, frames, set.plan.repetitions, true, set.control);
  double touching = 0;
  for (const Substep& frame : frames) {
    touching += static_cast<double>(count_touching(*set.setup.voxmap, *set.setup.tool, frame));
  }
  touching /= static_cast<double>(frames.size());
  for (std::size_t i = 0; i < programs.size(); ++i) {
    const bool points = programs[i]->label().engine != "implicit";
    const double contacts = points ? touching : spread_over(samples[i], &BatchSample::voxels, 1).median;
    add_result(set.row(*programs[i], name_of(contact)), contacts, spread_over(samples[i], &BatchSample::total_s),
               spread_over(samples[i], &BatchSample::kernel_s).median, set.report);
    if (contact == Contact::severe) set.report["phases"].push_back(phases_of(set, *programs[i], samples[i]));
  }
  for (Json& row : set.report["results"]) {
    if (row["case"] != "plunge") set_ratio(set.report, row);  // measure_plunge() compares frame by frame
  }
}

void add_memory(const std::string& engine, const SizePair& size, const StructureBytes& bytes, Json& report) {
  Json& memory = report["memory"];
  const bool known = std::ranges::any_of(memory, [&](const Json& other) {
    return other["engine"] == engine && other["voxmap"] == size.voxmap && other["shell"] == size.shell;
  });
  if (known) return;
  memory.push_back({{"engine", engine},
                    {"voxmap", size.voxmap},
                    {"shell", size.shell},
                    {"voxmap_mb", static_cast<double>(bytes.voxmap) / 1e6},
                    {"shell_mb", static_cast<double>(bytes.shell) / 1e6}});
}

void measure_plunge(const ProgramSet& set) {
  constexpr std::size_t kBatch = 64;  // as `reamsim run` by default
  const std::vector<Substep> frames = plunge_frames(set);
  std::vector<PlungeRun> runs;
  for (const auto& program : set.programs) runs.push_back({.program = program.get(), .chunks = {}});
  for (std::size_t first = 0; first < frames.size(); first += kBatch) {
    if (set.control.stop()) throw Interrupted();
    const std::span<const Substep> chunk(&frames[first], std::min(kBatch, frames.size() - first));
    for (PlungeRun& run : runs) {
      if (run.continues()) run.run(chunk);
    }
  }
  const auto direct = std::ranges::find_if(runs, &PlungeRun::is_published_direct);
  for (const PlungeRun& run : runs) {
    run.program->restore();
    add_plunge(set, run, direct == runs.end() ? std::vector<BatchSample>{} : direct->chunks);
    if (run.frames == frames.size()) continue;
    Json stopped = set.row(*run.program, "plunge");
    stopped["reason"] = fmt::format("stopped after {} of {} frames, which took 20 s; its ratio is over these frames",
                                    run.frames, frames.size());
    set.report["skipped"].push_back(stopped);
  }
}

}  // namespace reamsim::bench
