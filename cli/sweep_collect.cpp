// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/sweep.h"

#include <fmt/core.h>
#include <cmath>
#include <filesystem>
#include <system_error>

#include "cli/lab.h"
#include "render/viewer/page.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/record/citation.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

/// Warnings of runs on the terminal, at most.
constexpr std::size_t kMostWarnings = 3;

/// All numbers of a parameter, or null where a cell is none.
Json numbers_of(const RunTable& table, std::size_t parameter) {
  Json out = Json::array();
  for (const CollectedRun& run : table.runs) {
    const auto number = parse_number(run.cells[parameter]);
    if (!number || !std::isfinite(*number)) return nullptr;
    out.push_back(*number);
  }
  return out;
}

/// The table of a study for the statistics: all parameters, and headline_results().
Json table_json(const RunTable& table) {
  Json out{{"all", table.all}, {"width", kTerminalWidth}};
  for (const char* list : {"numbers", "states", "parameters", "results"}) out[list] = Json::array();
  for (const CollectedRun& run : table.runs) {
    out["numbers"].push_back(run.number);
    out["states"].push_back(name_of(run.state));
  }
  const std::vector<ColumnName> names = column_names(table.parameters);
  for (std::size_t p = 0; p < names.size(); ++p) {
    Json cells = Json::array(), shown = Json::array();
    for (const CollectedRun& run : table.runs) {
      cells.push_back(printable(run.cells[p]));
      shown.push_back(printable(shown_cell(run.cells[p])));
    }
    out["parameters"].push_back({{"key", printable(names[p].key)},
                                 {"title", printable(names[p].title())},
                                 {"cells", cells},
                                 {"shown", shown},
                                 {"numbers", numbers_of(table, p)}});
  }
  for (const ColumnName& name : headline_results()) {
    const auto found = std::ranges::find(table.results, name.key);
    if (found == table.results.end()) continue;
    const auto place = static_cast<std::size_t>(found - table.results.begin());
    Json numbers = Json::array();
    for (const CollectedRun& run : table.runs) {
      numbers.push_back(run.numbers.empty() ? Json() : Json(run.numbers[place]));
    }
    out["results"].push_back({{"key", name.key}, {"title", name.title()}, {"unit", name.unit}, {"numbers", numbers}});
  }
  return out;
}

/// Without the results that follow from the constants of the force law.
RunTable without_forces(RunTable table) {
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < table.results.size(); ++i) {
    if (!depends_on_law(table.results[i])) kept.push_back(i);
  }
  const auto keep = [&](auto& values) {
    for (std::size_t i = 0; i < kept.size(); ++i) values[i] = values[kept[i]];
    values.resize(kept.size());
  };
  for (CollectedRun& run : table.runs) keep(run.numbers);
  keep(table.results);
  return table;
}

[[noreturn]] void refuse(const std::string& dir, const std::string& found) {
  throw InputError({shown_path(dir), 0, 0}, "output folder", found, "choose another with -o");
}

/// Whether a study has begun to simulate in this folder.
bool holds_runs(const std::string& dir) {
  std::error_code error;
  if (!fs::exists(dir + "/study.json", error)) return false;
  if (fs::exists(dir + "/runs.csv", error)) return true;
  const bool none = fs::is_empty(dir + "/runs", error);
  return !error && !none;
}

}  // namespace

std::string counts_text(const StudyCounts& counts) {
  return fmt::format("{} runs: {} done, {} failed, {} interrupted, {} missing", counts.all(), counts.done,
                     counts.failed, counts.interrupted, counts.missing);
}

void warn_of_runs(const RunMessages& messages, const std::string& sentence, const Console& console) {
  if (messages.runs() == 0) return;
  console.warn(sentence);
  for (const std::string& line : messages.lines(kMostWarnings)) console.warn(line);
}

void collect_and_show(const SweepRuns& sweep, const StudyFolder& folder, const Console& console) {
  CollectedStudy collected = collect_runs(folder, sweep.plan, sweep.runs);
  // Effects on forces without the sampled constants would contradict those of the analysis.
  const bool base_law = has_forces_of_base_law(sweep.study, folder.path());
  if (base_law) collected.table = without_forces(std::move(collected.table));
  const Json answer = call_lab("effects", {folder.path()}, table_json(collected.table));
  const Json &effects = answer["effects"], &table = answer["table"];
  if (effects.is_null()) {
    // Figures of runs that the study no longer has would contradict its table.
    std::error_code ignored;
    for (const char* ending : {"csv", "gp", "py", "png", "svg", "pdf"})
      fs::remove(folder.path() + "/effects." + ending, ignored);
  }
  write_citation(folder.path(), cite_results(folder.path()));
  replace_file(folder.path() + "/sweep.html", study_page(sweep.study.name, collected.table));
  for (const Json& line : table) console.say(line.get<std::string>());
  if (!table.empty()) console.say("");
  console.say(counts_text(collected.counts));
  console.say(
      "table: " + folder.path() + "/runs.csv" +
      (base_law ? " (its forces and energies are those of the base's force law, without the sampled constants)" : ""));
  if (!effects.is_null()) {
    console.say("main effects: " + folder.path() + "/effects.png" + effects.get<std::string>());
  }
  console.say("page: " + folder.path() + "/sweep.html");
  warn_of_runs(collected.warnings,
               fmt::format("{} of {} finished runs have warnings; the column message of runs.csv has all of them",
                           collected.warnings.runs(), collected.counts.done),
               console);
}

void keep_results_of_uq(const SweepOptions& options, const std::string& dir) {
  if (!holds_uq_runs(dir)) return;
  std::error_code error;
  const bool own = fs::equivalent(options.file, dir + "/runs.yaml", error);
  if (own && options.overrides.empty()) return;
  refuse(dir, "holds the results of `reamsim uq`, which this study would replace in part");
}

void keep_results_of_sweep(const std::string& dir) {
  if (holds_uq_runs(dir) || !holds_runs(dir)) return;
  refuse(dir, "holds the results of `reamsim sweep run`, which this analysis would replace in part");
}

}  // namespace reamsim
