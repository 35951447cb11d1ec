// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/uq_design.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "sim/base/csv.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/scenario/key_tree.h"
#include "sim/scenario/paths.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

/// The keys whose other values ForceBasis::forces() and Recalibration account for. Any other changes the basis itself.
constexpr std::array<std::string_view, 9> kConstants{"cutting.specific_energy_j_mm3",
                                                     "cutting.reference_density_g_cm3",
                                                     "cutting.density_exponent",
                                                     "cutting.normal_ratio",
                                                     "cutting.edge_force.tangential_n_mm",
                                                     "cutting.edge_force.normal_n_mm",
                                                     "bone.density.ash_slope_g_cm3_per_hu",
                                                     "bone.density.ash_offset_g_cm3",
                                                     "bone.density.ash_fraction"};

/// The first line of the study of the runs, by which a folder is known as that of an analysis.
constexpr std::string_view kRunsMark = "# The runs of an uncertainty analysis; written by reamsim.\n";

constexpr std::string_view kWithBasis = "output.force_basis=true";

bool is_constant(const SampledKey& sampled) {
  return std::ranges::find(kConstants, sampled.key) != kConstants.end();
}

std::string quoted_cell(const std::string& text) {
  return "\"" + replace_all(text, {{"\"", "\"\""}}) + "\"";
}

void require_samples_alone(const Study& study) {
  if (!study.sample) {
    throw InputError({study.file, 0, 0}, "sample", "missing",
                     "give the distributions of the uncertain keys in sample.of");
  }
  if (!study.vary.empty() || study.table) {
    throw InputError({study.file, 0, 0}, study.table ? "table" : "vary", "an uncertainty analysis has no such key",
                     "remove it, or use `reamsim sweep`");
  }
  if (study.sample->method != SampleMethod::sobol) {
    throw InputError(study.sample->method_where, "sample.method", "found a method other than sobol",
                     "remove it: `reamsim uq` draws the pairs of samples that its indices need with sobol itself; "
                     "other methods, saltelli too, are for `reamsim sweep`");
  }
  if (study.keep.pictures || study.keep.grids) {
    throw InputError({study.file, 0, 0}, "keep", "found pictures or vdb",
                     "an uncertainty analysis keeps summary and forces of its runs; remove it, or use `reamsim sweep`");
  }
  constexpr int kFewest = 4;
  if (study.sample->n < kFewest) {
    throw InputError({study.file, 0, 0}, "sample.n", "found " + std::to_string(study.sample->n),
                     "expected 4 or more; 64 or more for indices that can be trusted");
  }
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

UqDesign::UqDesign(Study study) : study_(std::move(study)) {
  require_samples_alone(study_);
  const SampleSettings& sample = *study_.sample;
  for (std::size_t key = 0; key < sample.of.size(); ++key) {
    std::vector<std::string> names = part_columns(sample.of[key]);
    if (names.empty()) names = {sample.of[key].key};
    for (const std::string& name : names) inputs_.push_back({name, key, is_constant(sample.of[key])});
  }
  const auto count = static_cast<Eigen::Index>(inputs_.size());
  const auto both = unit_points(SampleMethod::sobol, sample.n, 2 * static_cast<int>(count), sample.seed);
  a_.resize(sample.n, count);
  b_.resize(sample.n, count);
  for (Eigen::Index i = 0; i < sample.n; ++i) {
    const Eigen::Map<const Eigen::RowVectorXd> row(both[static_cast<std::size_t>(i)].data(), 2 * count);
    a_.row(i) = row.head(count);
    b_.row(i) = row.tail(count);
  }
  require_samples_in_range();
  for (const Eigen::VectorXd& point : points()) {
    if (run_places_.emplace(run_part(point), run_points_.size()).second) run_points_.push_back(run_part(point));
  }
}

void UqDesign::require_samples_in_range() const {
  MistakeList mistakes;
  for (std::size_t d = 0; d < inputs_.size(); ++d) {
    const SampledKey& sampled = study_.sample->of[inputs_[d].key];
    if (sampled.distribution.dimensions() > 1) continue;  // of vectors, the scenario knows: require_valid_runs()
    const Range& range = find_key(sampled.key, sampled.where).info.range;
    std::vector<double> outside;
    for (const Eigen::MatrixXd* sample : {&a_, &b_}) {
      for (const double u : sample->col(static_cast<Eigen::Index>(d))) {
        const double value = sample_number(sampled.distribution, u);
        if (!range.contains(value)) outside.push_back(value);
      }
    }
    if (outside.empty()) continue;
    const auto excess = [&](double value) { return std::max(range.min - value, value - range.max); };
    mistakes.add(InputError(sampled.where, sampled.key,
                            "found " + rounded_text(*std::ranges::max_element(outside, {}, excess)) + ": " +
                                std::to_string(outside.size()) + " of " + std::to_string(2 * a_.rows()) +
                                " samples lie outside " + range_text(range),
                            "expected a distribution within that range, such as uniform, or a smaller spread"));
  }
  mistakes.throw_if_any();
}

Study UqDesign::study_of_runs() const {
  Study runs = study_;
  std::erase_if(runs.set, [](const std::string& assignment) { return assignment.starts_with("output.force_basis="); });
  runs.set.insert(runs.set.begin(), needs_basis() ? std::string(kWithBasis) : "output.force_basis=false");
  std::erase_if(runs.sample->of, is_constant);
  runs.sample->points = run_points_;
  if (runs.sample->of.empty()) runs.sample.reset();
  return runs;
}

void UqDesign::require_valid_runs() const {
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

std::vector<Eigen::VectorXd> UqDesign::points() const {
  std::vector<Eigen::VectorXd> out;
  for (const Eigen::MatrixXd* sample : {&a_, &b_}) {
    for (Eigen::Index i = 0; i < sample->rows(); ++i) out.emplace_back(sample->row(i).transpose());
  }
  for (Eigen::Index d = 0; d < a_.cols(); ++d) {
    for (Eigen::Index i = 0; i < a_.rows(); ++i) {
      out.emplace_back(a_.row(i).transpose());
      out.back()[d] = b_(i, d);
    }
  }
  return out;
}

std::vector<double> UqDesign::run_part(const Eigen::VectorXd& point) const {
  std::vector<double> out;
  for (std::size_t d = 0; d < inputs_.size(); ++d) {
    if (!inputs_[d].constant) out.push_back(point[static_cast<Eigen::Index>(d)]);
  }
  return out;
}

std::vector<std::pair<std::string, double>> UqDesign::constants(const Eigen::VectorXd& point) const {
  std::vector<std::pair<std::string, double>> out;
  for (std::size_t d = 0; d < inputs_.size(); ++d) {
    if (!inputs_[d].constant) continue;
    const SampledKey& sampled = study_.sample->of[inputs_[d].key];
    out.emplace_back(sampled.key, sample_number(sampled.distribution, point[static_cast<Eigen::Index>(d)]));
  }
  return out;
}

bool UqDesign::needs_basis() const {
  return std::ranges::any_of(inputs_, &UncertainInput::constant);
}

std::string UqDesign::write_runs(const std::string& dir) const {
  const Study runs = study_of_runs();
  std::string text =
      std::string(kRunsMark) + "version: 1\nname: runs\nbase: " + json_string(recorded_path(study_.base)) + "\nset:\n";
  for (const std::string& assignment : runs.set) {
    const std::size_t equals = assignment.find('=');
    text += "  " + assignment.substr(0, equals) + ": " + assignment.substr(equals + 1) + "\n";
  }
  text += "keep: [summary, forces]\n";
  if (runs.sample) {
    const StudyPlan plan = make_plan(runs);
    std::vector<std::string> cells;
    for (const SampledKey& sampled : runs.sample->of) cells.push_back(csv_text(sampled.key));
    std::string table = fmt::format("{}\n", fmt::join(cells, ","));
    for (const PlannedRun& run : plan.runs) {
      const std::size_t first = run.overrides.size() - cells.size();  // behind those of `set`
      for (std::size_t i = 0; i < cells.size(); ++i) {
        const std::string& assignment = run.overrides[first + i];
        cells[i] = quoted_cell(assignment.substr(assignment.find('=') + 1));
      }
      table += fmt::format("{}\n", fmt::join(cells, ","));
    }
    replace_file(dir + "/runs_table.csv", table);
    text += "table: runs_table.csv\n";
  }
  const std::string path = dir + "/runs.yaml";
  replace_file(path, text);
  return path;
}

}  // namespace reamsim
