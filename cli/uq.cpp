// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <map>
#include <string_view>
#include <utility>

#include "cli/command_line.h"
#include "cli/commands.h"
#include "cli/lab.h"
#include "cli/sweep.h"
#include "sim/base/csv.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/record/citation.h"
#include "sim/scenario/key_tree.h"
#include "sim/scenario/paths.h"
#include "sim/scenario/show.h"
#include "sim/study/study_folder.h"

namespace reamsim {

namespace {

using Json = nlohmann::ordered_json;

/// Fewer points than this give sensitivity indices with errors of tenths.
constexpr int kTrusted = 64;

/// The first line of the study of the runs, by which a folder is known as that of an analysis.
constexpr std::string_view kRunsMark = "# The runs of an uncertainty analysis; written by reamsim.\n";

constexpr std::string_view kWithBasis = "output.force_basis=true";

/// Whether forces for other values of the key follow from the force basis of a run, without another run.
bool is_constant(const SampledKey& sampled) {
  static const Json law = [] {
    LawSettings all;
    all.cutting.edge_force.emplace();
    return law_json(all);
  }();
  return law.contains(sampled.key);
}

void require_samples_alone(const Study& study) {
  const auto refuse_if = [&](bool wrong, const char* key, const std::string& found, const std::string& expected) {
    if (wrong) throw InputError({study.file, 0, 0}, key, found, expected);
  };
  refuse_if(!study.sample, "sample", "missing", "give the distributions of the uncertain keys in sample.of");
  refuse_if(!study.vary.empty() || study.table, study.table ? "table" : "vary",
            "an uncertainty analysis has no such key", "remove it, or use `reamsim sweep`");
  if (study.sample->method != SampleMethod::sobol) {
    throw InputError(study.sample->method_where, "sample.method", "found a method other than sobol",
                     "remove it: `reamsim uq` draws the pairs of samples that its indices need with sobol itself; "
                     "other methods, saltelli too, are for `reamsim sweep`");
  }
  refuse_if(study.keep.pictures || study.keep.grids, "keep", "found pictures or vdb",
            "an uncertainty analysis keeps summary and forces of its runs; remove it, or use `reamsim sweep`");
  constexpr int kFewest = 4;
  refuse_if(study.sample->n < kFewest, "sample.n", "found " + std::to_string(study.sample->n),
            "expected 4 or more; 64 or more for indices that can be trusted");
}

/// An independent variable: a sampled number, or one part of a tilt or shift.
struct UncertainInput {
  std::string name;       ///< the key; of parts as in the columns of a plan
  std::size_t key = 0;    ///< index in the sample of the study
  bool constant = false;  ///< is_constant()
};

/// The points at which bands and sensitivity indices need the outputs of a study, and their runs.
class UqDesign {
 public:
  using Point = std::vector<double>;  ///< of the unit cube, by input

  /// Throws InputError unless the study consists of samples alone, each within the range of its key.
  explicit UqDesign(Study study) : study_(std::move(study)) {
    require_samples_alone(study_);
    const SampleSettings& sample = *study_.sample;
    for (std::size_t key = 0; key < sample.of.size(); ++key) {
      std::vector<std::string> names = part_columns(sample.of[key]);
      if (names.empty()) names = {sample.of[key].key};
      for (const std::string& name : names) inputs_.push_back({name, key, is_constant(sample.of[key])});
    }
    const auto drawn = unit_points(SampleMethod::saltelli, sample.n, static_cast<int>(inputs_.size()), sample.seed);
    const std::size_t matrices = inputs_.size() + 2;  // A, B, and A with a column of B for every input
    for (std::size_t matrix = 0; matrix < matrices; ++matrix) {
      for (std::size_t i = matrix; i < drawn.size(); i += matrices) points_.push_back(drawn[i]);
    }
    require_samples_in_range();
    for (const Point& point : points_) {
      if (run_places_.emplace(run_part(point), run_points_.size()).second) run_points_.push_back(run_part(point));
    }
  }

  [[nodiscard]] const std::vector<UncertainInput>& inputs() const { return inputs_; }
  /// Of two independent samples A and B of the unit cube the rows, and for every input those of A with its column of B.
  [[nodiscard]] const std::vector<Point>& points() const { return points_; }
  [[nodiscard]] int samples() const { return study_.sample->n; }
  [[nodiscard]] std::size_t runs() const { return run_points_.size(); }
  /// The run of a point. Its number in the study of runs is one more.
  [[nodiscard]] std::size_t run_of(const Point& point) const { return run_places_.at(run_part(point)); }

  [[nodiscard]] std::vector<std::pair<std::string, double>> constants(const Point& point) const {
    std::vector<std::pair<std::string, double>> out;
    for (std::size_t d = 0; d < inputs_.size(); ++d) {
      if (!inputs_[d].constant) continue;
      const SampledKey& sampled = study_.sample->of[inputs_[d].key];
      out.emplace_back(sampled.key, sample_number(sampled.distribution, point[d]));
    }
    return out;
  }

  /// Whether forces come from the force basis of the runs: some inputs are constants. Otherwise from their forces.csv.
  [[nodiscard]] bool needs_basis() const { return std::ranges::any_of(inputs_, &UncertainInput::constant); }

  /// Throws InputError where a scenario refuses a run: no band or index follows from the rest.
  void require_valid_runs() const {
    const Study study = study_of_runs();
    int refused = 0;
    std::string first;
    for (const IdentifiedRun& run : identify_runs(study, make_plan(study))) {
      if (run.mistake.empty()) continue;
      if (refused++ == 0) first = printable(run.mistake);
    }
    if (refused == 0) return;
    throw InputError({shown_path(study.file), 0, 0}, "sample.of",
                     std::to_string(refused) + " of " + std::to_string(runs()) + " runs are wrong, the first: " + first,
                     "expected distributions whose values the scenario accepts together");
  }

  /// Writes DIR/runs.yaml, a study of the runs, and its table. Returns its path. Throws RunError.
  [[nodiscard]] std::string write_runs(const std::string& dir) const {
    const Study runs = study_of_runs();
    std::string text = std::string(kRunsMark) +
                       "version: 1\nname: runs\nbase: " + json_string(recorded_path(study_.base)) + "\nset:\n";
    for (const std::string& assignment : runs.set) {
      const std::size_t equals = assignment.find('=');
      text += "  " + assignment.substr(0, equals) + ": " + assignment.substr(equals + 1) + "\n";
    }
    text += "keep: [summary, forces]\n";
    if (runs.sample) {
      replace_file(dir + "/runs_table.csv", table_of(runs));
      text += "table: runs_table.csv\n";
    }
    const std::string path = dir + "/runs.yaml";
    replace_file(path, text);
    return path;
  }

 private:
  void require_samples_in_range() const {
    MistakeList mistakes;
    for (std::size_t d = 0; d < inputs_.size(); ++d) {
      const SampledKey& sampled = study_.sample->of[inputs_[d].key];
      if (sampled.distribution.dimensions() > 1) continue;  // of vectors, the scenario knows: require_valid_runs()
      const Range& range = find_key(sampled.key, sampled.where).info.range;
      std::vector<double> outside;
      const std::size_t drawn = 2 * static_cast<std::size_t>(samples());  // A and B
      for (std::size_t i = 0; i < drawn; ++i) {
        const double value = sample_number(sampled.distribution, points_[i][d]);
        if (!range.contains(value)) outside.push_back(value);
      }
      if (outside.empty()) continue;
      const auto excess = [&](double value) { return std::max(range.min - value, value - range.max); };
      mistakes.add(InputError(sampled.where, sampled.key,
                              "found " + rounded_text(*std::ranges::max_element(outside, {}, excess)) + ": " +
                                  std::to_string(outside.size()) + " of " + std::to_string(drawn) +
                                  " samples lie outside " + range_text(range),
                              "expected a distribution within that range, such as uniform, or a smaller spread"));
    }
    mistakes.throw_if_any();
  }

  [[nodiscard]] Study study_of_runs() const {
    Study runs = study_;
    std::erase_if(runs.set, [](const std::string& text) { return text.starts_with("output.force_basis="); });
    runs.set.insert(runs.set.begin(), needs_basis() ? std::string(kWithBasis) : "output.force_basis=false");
    std::erase_if(runs.sample->of, is_constant);
    runs.sample->points = run_points_;
    if (runs.sample->of.empty()) runs.sample.reset();
    return runs;
  }

  /// The sampled keys of the runs as the table of a study.
  static std::string table_of(const Study& runs) {
    std::vector<std::string> cells;
    for (const SampledKey& sampled : runs.sample->of) cells.push_back(csv_text(sampled.key));
    std::string table = fmt::format("{}\n", fmt::join(cells, ","));
    for (const PlannedRun& run : make_plan(runs).runs) {
      const std::size_t first = run.overrides.size() - cells.size();  // behind those of `set`
      for (std::size_t i = 0; i < cells.size(); ++i) {
        const std::string& assignment = run.overrides[first + i];
        cells[i] = quoted_cell(assignment.substr(assignment.find('=') + 1));
      }
      table += fmt::format("{}\n", fmt::join(cells, ","));
    }
    return table;
  }

  [[nodiscard]] Point run_part(const Point& point) const {
    Point out;
    for (std::size_t d = 0; d < inputs_.size(); ++d) {
      if (!inputs_[d].constant) out.push_back(point[d]);
    }
    return out;
  }

  Study study_;
  std::vector<UncertainInput> inputs_;
  std::vector<Point> points_;
  std::vector<Point> run_points_;  ///< coordinates of the inputs that are no constants
  std::map<Point, std::size_t> run_places_;
};

/// The points of a design for the statistics: by point its run, its place in the unit cube, the constants there.
Json points_json(const UqDesign& design) {
  Json out = Json::array();
  for (const UqDesign::Point& point : design.points()) {
    std::vector<double> row{static_cast<double>(design.run_of(point))};
    row.insert(row.end(), point.begin(), point.end());
    for (const auto& [key, value] : design.constants(point)) row.push_back(value);
    out.push_back(std::move(row));
  }
  return out;
}

/// Of each run the force law at its first point, with the sampled constants, and that of the run. Throws InputError.
Json laws_json(const UqDesign& design, const std::vector<std::string>& run_dirs) {
  Json out = Json::array();
  if (!design.needs_basis()) return out;
  std::vector<std::vector<std::string>> constants(run_dirs.size());
  for (const UqDesign::Point& point : design.points()) {
    std::vector<std::string>& of_run = constants[design.run_of(point)];
    if (!of_run.empty()) continue;
    for (const auto& [key, value] : design.constants(point)) of_run.push_back(key + "=" + number_text(value));
  }
  for (std::size_t i = 0; i < run_dirs.size(); ++i) {
    const BasisRun run = open_basis_run(run_dirs[i]);
    out.push_back({{"law", law_json(changed_law(run, constants[i]))}, {"of_run", law_json(run.law)}});
  }
  return out;
}

/// Of each run the numbers of its summary that do not depend on the force law.
Json numbers_json(const std::vector<std::string>& run_dirs) {
  Json out = Json::array();
  for (const std::string& dir : run_dirs) {
    Json of_run = Json::object();
    for (const auto& [name, value] : read_run_summary(dir).numbers) {
      if (!depends_on_law(name)) of_run[name] = value;
    }
    out.push_back(std::move(of_run));
  }
  return out;
}

/// Bands and indices of the finished runs in `dir`.
void evaluate(const UqDesign& design, const SweepRuns& done, const StudyFolder& folder, const Console& console) {
  Json inputs = Json::array(), constants = Json::array(), ids = Json::array();
  for (const UncertainInput& input : design.inputs()) {
    inputs.push_back(input.name);
    if (input.constant) constants.push_back(input.name);
  }
  std::vector<std::string> run_dirs;
  for (const IdentifiedRun& run : done.runs) {
    ids.push_back(run.id);
    run_dirs.push_back(folder.run_dir(run.id));
    require_readable_log(run_dirs.back());
  }
  say_answer(call_lab("uq", {folder.path()},
                      {{"program", "reamsim " REAMSIM_VERSION},
                       {"inputs", inputs},
                       {"constants", constants},
                       {"n", design.samples()},
                       {"points", points_json(design)},
                       {"runs", ids},
                       {"laws", laws_json(design, run_dirs)},
                       {"numbers", numbers_json(run_dirs)}}),
             console);
}

void uq_command(const SweepOptions& options, const Console& console) {
  const Study study = read_study(options.file);
  const UqDesign design(study);
  const std::string dir = options.dir(study);
  keep_results_of_sweep(dir);
  design.require_valid_runs();
  require_lab();
  const std::string marked = StudyFolder(study, dir).path();
  const SweepOptions runs{.file = design.write_runs(marked), .output = marked, .jobs = options.jobs};
  console.say(fmt::format("{}: {} uncertain inputs, {} evaluations of {} runs", study.name, design.inputs().size(),
                          design.points().size(), design.runs()));
  if (study.sample->n < kTrusted) {
    console.warn(fmt::format("sample.n is {}: with less than {}, sensitivity indices are a hint only", study.sample->n,
                             kTrusted));
  }
  const SweepRuns done = simulate_study(runs, console);
  const StudyFolder folder = StudyFolder::open(done.study, marked);
  evaluate(design, done, folder, console);
  write_citation(marked, cite_results(marked));
  console.say("bands and indices: " + marked + "/uq.csv, uq.json, uq.png");
}

}  // namespace

bool depends_on_law(const std::string& name) {
  static constexpr std::string_view kSections[] = {"headline.", "forces.", "force_law.", "passes."};
  static constexpr std::string_view kNumbers[] = {"work_mj", "energy_mj", "floor_energy_mj", "friction_energy_mj",
                                                  "balance"};
  return std::ranges::any_of(kSections, [&](std::string_view section) { return name.starts_with(section); }) ||
         std::ranges::find(kNumbers, name) != std::end(kNumbers);
}

bool holds_uq_runs(const std::string& dir) {
  return read_file_start(dir + "/runs.yaml", kRunsMark.size()) == kRunsMark;
}

bool has_forces_of_base_law(const Study& runs, const std::string& dir) {
  return holds_uq_runs(dir) && std::ranges::find(runs.set, kWithBasis) != runs.set.end();
}

void add_uq_command(CLI::App& app, Console& console) {
  const auto [command, options] = add_command(
      app, "uq", "Propagate uncertain inputs: bands of force and torque, sensitivity indices", console, uq_command);
  command->add_option("STUDY", options->file, "Study file (YAML) with a sample, or the name of a shipped one")
      ->required()
      ->transform(shipped<ShippedKind::study>, "");
  add_output(*command, options->output, "Folder of the study (default: out/NAME)");
  add_jobs(*command, options->jobs);
  command->add_flag("--quiet", console.quiet, "Print only warnings and errors");
}

}  // namespace reamsim
