// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/study_plan.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <map>

#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/scenario/key_tree.h"
#include "sim/scenario/markups.h"
#include "sim/scenario/parse.h"
#include "sim/scenario/parse_steps.h"
#include "sim/scenario/show.h"
#include "sim/study/study_folder.h"

namespace reamsim {

namespace {

constexpr std::size_t kMostRuns = 1'000'000;

class Planner {
 public:
  Planner(const Study& study, const std::vector<std::string>& overrides) : study_(study), fixed_(study.set) {
    fixed_.insert(fixed_.end(), overrides.begin(), overrides.end());
    for (const Variation& variation : study.vary) variations_.push_back(&variation);
    if (study.table) variations_.push_back(&*study.table);
  }

  StudyPlan plan() {
    make_columns();
    make_samples();
    require_few();
    combine(0, {.number = 0, .cells = {}, .overrides = fixed_, .place = "", .mistakes = {}});
    return std::move(plan_);
  }

 private:
  void make_columns() {
    auto& columns = plan_.columns;
    if (study_.table && !study_.table->labels.empty()) columns.emplace_back("label");
    for (const Variation* variation : variations_) {
      columns.insert(columns.end(), variation->keys.begin(), variation->keys.end());
    }
    if (!study_.sample) return;
    for (const SampledKey& sampled : study_.sample->of) {
      // A vector that is varied has its column already.
      if (std::ranges::find(columns, sampled.key) == columns.end()) columns.push_back(sampled.key);
      for (const std::string& part : part_columns(sampled)) columns.push_back(part);
    }
  }

  void make_samples() {
    if (!study_.sample) return;
    int dimensions = 0;
    for (const SampledKey& sampled : study_.sample->of) dimensions += sampled.distribution.dimensions();
    points_ = study_.sample->points;
    if (points_.empty()) {
      points_ = unit_points(study_.sample->method, study_.sample->n, dimensions, study_.sample->seed);
    }
    const bool changes_vectors = std::ranges::any_of(
        study_.sample->of, [](const SampledKey& sampled) { return sampled.distribution.dimensions() > 1; });
    if (changes_vectors) base_ = parse_yaml(read_file(study_.base, "expected a scenario"), shown_path(study_.base));
  }

  void require_few() const {
    double runs = points_.empty() ? 1 : static_cast<double>(points_.size());
    for (const Variation* variation : variations_) runs *= static_cast<double>(variation->levels.size());
    if (runs <= static_cast<double>(kMostRuns)) return;
    refuse_file(shown_path(study_.file), "the study has " + rounded_text(runs) + " runs",
                "expected at most " + std::to_string(kMostRuns) + ": vary fewer keys, or sample them");
  }

  void combine(std::size_t depth, const PlannedRun& so_far) {
    if (depth == variations_.size()) return add_samples(so_far);
    const Variation& variation = *variations_[depth];
    const CohortTable* const table = study_.table && &variation == &*study_.table ? &*study_.table : nullptr;
    for (std::size_t i = 0; i < variation.levels.size(); ++i) {
      PlannedRun run = so_far;
      if (table != nullptr) {
        run.place = table->places[i];
        run.mistakes = table->mistakes[i];
        if (!table->labels.empty()) run.cells.insert(run.cells.begin(), table->labels[i]);
      }
      for (std::size_t k = 0; k < variation.keys.size(); ++k) {
        const KeyValue& value = variation.levels[i][k];
        run.cells.push_back(value.shown);
        if (!value.applied.empty()) run.overrides.push_back(variation.keys[k] + "=" + value.applied);
      }
      combine(depth + 1, run);
    }
  }

  void add_samples(const PlannedRun& combination) {
    if (!study_.sample) return add(combination);
    for (const std::vector<double>& point : points_) {
      PlannedRun run = combination;
      std::size_t at = 0;
      for (const SampledKey& sampled : study_.sample->of) {
        if (sampled.distribution.dimensions() == 1) {
          run.cells.push_back(number_text(sample_number(sampled.distribution, point[at++])));
          run.overrides.push_back(sampled.key + "=" + run.cells.back());
        } else {
          add_vector(sampled, point, at, run);
        }
      }
      add(std::move(run));
    }
  }

  void add(PlannedRun run) {
    run.number = static_cast<int>(plan_.runs.size()) + 1;
    plan_.runs.push_back(std::move(run));
  }

  void add_vector(const SampledKey& sampled, const std::vector<double>& point, std::size_t& at, PlannedRun& run) {
    const Vec3 before = vector_of(sampled, run);
    std::vector<double> parts;
    for (int d = 0; d < sampled.distribution.dimensions(); ++d) {
      parts.push_back(sampled.distribution.a * normal_quantile(point[at++]));
    }
    const bool tilt = sampled.distribution.kind == Distribution::Kind::tilt_sd_deg;
    const Vec3 after = tilt ? tilted(before, parts[0], parts[1]) : before + Vec3(parts[0], parts[1], parts[2]);
    const auto column = static_cast<std::size_t>(std::ranges::find(plan_.columns, sampled.key) - plan_.columns.begin());
    run.cells.resize(std::max(run.cells.size(), column + 1));
    run.cells[column] = vector_text(after);
    for (const double part : parts) run.cells.push_back(number_text(part));
    run.overrides.push_back(sampled.key + "=" + vector_text(after));
  }

  /// The vector of the run before the sample changes it.
  [[nodiscard]] Vec3 vector_of(const SampledKey& sampled, const PlannedRun& run) const {
    YamlNodePtr document = base_;
    for (const std::string& assignment : run.overrides) document = apply_override(document, assignment);
    const YamlNode* node = document->at(sampled.key);
    const KeyInfo& info = find_key(sampled.key, sampled.where).info;
    if (node != nullptr && MarkupsKeys::are_in(info, *node)) {
      return MarkupsKeys(shown_path(study_.base), std::filesystem::path(study_.base).parent_path().string())
          .points(info, *node, sampled.key, false)
          .front();
    }
    std::vector<double> numbers;
    for (const YamlNodePtr& item : node == nullptr ? std::vector<YamlNodePtr>{} : node->items) {
      if (const auto value = parse_number(item->text)) numbers.push_back(*value);
    }
    const bool read = numbers.size() == 3 && node->items.size() == 3;
    const Vec3 out = read ? Vec3(numbers[0], numbers[1], numbers[2]) : Vec3::Zero();
    const bool tilt = sampled.distribution.kind == Distribution::Kind::tilt_sd_deg;
    if (read && (!tilt || out.norm() > 0)) return out;
    throw InputError(sampled.where, sampled.key, "has no vector that the sample could change",
                     "give it in the base scenario, in set, vary or the table");
  }

  const Study& study_;
  std::vector<std::string> fixed_;
  std::vector<const Variation*> variations_;  ///< the table is the last one
  StudyPlan plan_;
  std::vector<std::vector<double>> points_;
  YamlNodePtr base_;
};

constexpr std::size_t kMostGroups = 3, kMostNumbers = 5;

/// "3, 5 and 7"; of many the first ones.
std::string numbers_text(const std::vector<std::size_t>& rows) {
  const std::size_t shown = rows.size() <= kMostNumbers ? rows.size() - 1 : kMostNumbers;
  std::vector<std::size_t> numbers;
  for (std::size_t i = 0; i < shown; ++i) numbers.push_back(rows[i] + 1);
  return fmt::format(
      "{} and {}", fmt::join(numbers, ", "),
      shown + 1 == rows.size() ? fmt::to_string(rows.back() + 1) : fmt::format("{} more", rows.size() - shown));
}

/// Mistakes but those of keys whose cells were refused, which have the value of the base scenario, or none.
std::vector<Mistake> further_mistakes(const PlannedRun& run, const InputError& error) {
  MistakeList refused;
  if (!run.mistakes.empty()) refused.add(InputError(run.mistakes));
  std::vector<Mistake> out;
  std::ranges::copy_if(error.mistakes(), std::back_inserter(out),
                       [&](const Mistake& mistake) { return !refused.concerns(mistake.key); });
  return out;
}

/// All mistakes on one line, with the place of the row first.
std::string text_of(const PlannedRun& run, const std::vector<Mistake>& further) {
  std::string out;
  for (const Mistake& mistake : run.mistakes) out += (out.empty() ? "" : " | ") + mistake.line();
  const std::string place = out.empty() && !run.place.empty() ? run.place + ": " : "";
  for (const Mistake& mistake : further) out += (out.empty() ? place : " | ") + mistake.line();
  return out;
}

IdentifiedRun identified(const Study& study, const PlannedRun& run, Checksums& checksums) {
  try {
    const Scenario scenario = scenario_of(study, run);
    if (run.mistakes.empty()) return {run_id(scenario, study.keep, checksums), ""};
    return {"", text_of(run, {})};
  } catch (const InputError& error) {
    return {"", text_of(run, further_mistakes(run, error))};
  }
}

}  // namespace

std::vector<std::string> part_columns(const SampledKey& sampled) {
  const std::string& key = sampled.key;
  if (sampled.distribution.kind == Distribution::Kind::tilt_sd_deg) return {key + ".tilt_1_deg", key + ".tilt_2_deg"};
  if (sampled.distribution.kind != Distribution::Kind::shift_sd_mm) return {};
  return {key + ".shift_x_mm", key + ".shift_y_mm", key + ".shift_z_mm"};
}

StudyPlan make_plan(const Study& study, const std::vector<std::string>& overrides) {
  return Planner(study, overrides).plan();
}

std::vector<std::size_t> rows_of_run(const std::vector<IdentifiedRun>& runs, std::size_t run) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (runs[i].id == runs[run].id) out.push_back(i);
  return out;
}

std::vector<std::string> same_runs(const std::vector<IdentifiedRun>& runs) {
  std::map<std::string, std::vector<std::size_t>> rows_of;
  for (std::size_t i = 0; i < runs.size(); ++i)
    if (!runs[i].id.empty()) rows_of[runs[i].id].push_back(i);
  std::vector<std::string> out;
  std::size_t groups = 0;
  for (const IdentifiedRun& run : runs) {
    const auto found = rows_of.find(run.id);
    if (found == rows_of.end()) continue;
    if (found->second.size() > 1 && ++groups <= kMostGroups)
      out.push_back("runs " + numbers_text(found->second) + " are the same run, which is simulated once");
    rows_of.erase(found);
  }
  if (groups > kMostGroups) out.push_back(std::to_string(groups - kMostGroups) + " more runs are given twice");
  return out;
}

Scenario scenario_of(const Study& study, const PlannedRun& run) {
  Scenario scenario = parse_scenario(study.base, run.overrides);
  // What is not kept is not made. The bytes of the rest do not depend on it.
  scenario.output.plots = study.keep.pictures;  // `pictures` are both
  if (!study.keep.pictures) {
    scenario.render.enabled = false;
    scenario.output.meshes = false;
  }
  if (!study.keep.grids) scenario.output.vti = scenario.output.segmentation = false;
  return scenario;
}

std::vector<IdentifiedRun> identify_runs(const Study& study, const StudyPlan& plan,
                                         const std::function<void(std::size_t)>& done) {
  Checksums checksums;
  std::vector<IdentifiedRun> out;
  for (const PlannedRun& run : plan.runs) {
    out.push_back(identified(study, run, checksums));
    if (done) done(out.size());
  }
  return out;
}

}  // namespace reamsim
