// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/uq_design.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "sim/base/csv.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/scenario/paths.h"
#include "sim/scenario/show.h"
#include "sim/study/distribution.h"
#include "sim/study/unit_points.h"

namespace reamsim {

namespace {

/// The keys whose other values ForceBasis::forces() and Recalibration account for. Any other, such as the speed floor,
/// changes the basis itself.
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

std::string runs_file(const std::string& dir) {
  return dir + "/runs.yaml";
}

bool is_constant(const SampledKey& sampled) {
  return std::ranges::find(kConstants, sampled.key) != kConstants.end();
}

std::string name_of_part(const SampledKey& sampled, int part) {
  static constexpr const char* kTilts[] = {".tilt_1_deg", ".tilt_2_deg"};
  static constexpr const char* kShifts[] = {".shift_x_mm", ".shift_y_mm", ".shift_z_mm"};
  if (sampled.distribution.kind == Distribution::Kind::tilt_sd_deg) return sampled.key + kTilts[part];
  if (sampled.distribution.kind == Distribution::Kind::shift_sd_mm) return sampled.key + kShifts[part];
  return sampled.key;
}

/// A cell of a table as RFC 4180 has it.
std::string quoted_cell(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
  return out + "\"";
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
    throw InputError({study.file, 0, 0}, "sample.method", "found a method other than sobol",
                     "expected sobol: the estimators of the indices need its pairs of samples");
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

bool holds_uq_runs(const std::string& dir) {
  return read_file_start(runs_file(dir), kRunsMark.size()) == kRunsMark;
}

UqDesign::UqDesign(Study study) : study_(std::move(study)) {
  require_samples_alone(study_);
  const SampleSettings& sample = *study_.sample;
  for (std::size_t key = 0; key < sample.of.size(); ++key) {
    for (int part = 0; part < sample.of[key].distribution.dimensions(); ++part) {
      inputs_.push_back({name_of_part(sample.of[key], part), key, is_constant(sample.of[key])});
    }
  }
  const auto count = static_cast<Eigen::Index>(inputs_.size());
  const auto both = unit_points(SampleMethod::sobol, sample.n, 2 * static_cast<int>(count), sample.seed);
  a_.resize(sample.n, count);
  b_.resize(sample.n, count);
  for (Eigen::Index i = 0; i < sample.n; ++i) {
    for (Eigen::Index d = 0; d < count; ++d) {
      a_(i, d) = both[static_cast<std::size_t>(i)][static_cast<std::size_t>(d)];
      b_(i, d) = both[static_cast<std::size_t>(i)][static_cast<std::size_t>(count + d)];
    }
  }
  for (const Eigen::VectorXd& point : points()) {
    if (run_places_.emplace(run_part(point), run_points_.size()).second) run_points_.push_back(run_part(point));
  }
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

std::size_t UqDesign::run_of(const Eigen::VectorXd& point) const {
  return run_places_.at(run_part(point));
}

std::vector<std::string> UqDesign::constants(const Eigen::VectorXd& point) const {
  std::vector<std::string> out;
  for (std::size_t d = 0; d < inputs_.size(); ++d) {
    if (!inputs_[d].constant) continue;
    const SampledKey& sampled = study_.sample->of[inputs_[d].key];
    const double value = sample_number(sampled.distribution, point[static_cast<Eigen::Index>(d)]);
    out.push_back(sampled.key + "=" + number_text(value));
  }
  return out;
}

bool UqDesign::needs_basis() const {
  return std::ranges::any_of(inputs_, &UncertainInput::constant);
}

std::string UqDesign::write_runs(const std::string& dir) const {
  Study runs = study_;
  std::erase_if(runs.sample->of, is_constant);
  std::string text = std::string(kRunsMark) +
                     "version: 1\nname: runs\nbase: " + json_string(recorded_path(study_.base)) +
                     "\nset:\n  output.force_basis: " + (needs_basis() ? "true" : "false") + "\n";
  for (const std::string& assignment : study_.set) {
    const std::size_t equals = assignment.find('=');
    if (assignment.substr(0, equals) == "output.force_basis") continue;  // written above
    text += "  " + assignment.substr(0, equals) + ": " + assignment.substr(equals + 1) + "\n";
  }
  text += "keep: [summary, forces]\n";
  if (!runs.sample->of.empty()) {
    runs.sample->points = run_points_;
    const StudyPlan plan = make_plan(runs);
    std::string table;
    for (const SampledKey& sampled : runs.sample->of) table += (table.empty() ? "" : ",") + csv_text(sampled.key);
    table += "\n";
    for (const PlannedRun& run : plan.runs) {
      std::string line;
      const std::size_t first = run.overrides.size() - runs.sample->of.size();  // behind those of `set`
      for (std::size_t i = first; i < run.overrides.size(); ++i) {
        const std::string& assignment = run.overrides[i];
        line += (line.empty() ? "" : ",") + quoted_cell(assignment.substr(assignment.find('=') + 1));
      }
      table += line + "\n";
    }
    replace_file(dir + "/runs_table.csv", table);
    text += "table: runs_table.csv\n";
  }
  const std::string path = runs_file(dir);
  replace_file(path, text);
  return path;
}

}  // namespace reamsim
