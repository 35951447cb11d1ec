// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/sweep.h"

#include <fmt/core.h>

#include <algorithm>
#include <filesystem>

#include "render/study/effects_plot.h"
#include "render/study/effects_table.h"
#include "render/viewer/study_page.h"
#include "sim/base/file.h"
#include "sim/record/citation.h"
#include "sim/study/uq_design.h"
#include "sim/study/uq_outputs.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

/// Characters of a line on the terminal.
/// Warnings of runs on the terminal, at most.
constexpr std::size_t kMostWarnings = 3;

/// Figures of runs that the study no longer has would contradict its table.
void remove_effects(const std::string& dir) {
  std::error_code ignored;
  for (const char* ending : {"csv", "gp", "png", "svg", "pdf"}) fs::remove(dir + "/effects." + ending, ignored);
}

std::string effects_line(const std::string& dir, const MainEffects& effects) {
  const std::size_t all = effects.parameters.size(), shown = std::min(all, kMostParametersOfFigure);
  const std::string part =
      shown < all ? fmt::format(" ({} of {} parameters, those that explain most)", shown, all) : std::string();
  return "main effects: " + dir + "/effects.png" + part;
}

/// Without the results that follow from the constants of the force law.
RunTable without_forces(RunTable table) {
  std::vector<std::size_t> kept;
  for (std::size_t i = 0; i < table.results.size(); ++i) {
    if (!depends_on_law(table.results[i])) kept.push_back(i);
  }
  for (CollectedRun& run : table.runs) {
    for (std::size_t i = 0; i < kept.size(); ++i) run.numbers[i] = run.numbers[kept[i]];
    run.numbers.resize(kept.size());
  }
  for (std::size_t i = 0; i < kept.size(); ++i) table.results[i] = table.results[kept[i]];
  table.results.resize(kept.size());
  return table;
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
  const MainEffects effects = main_effects(collected.table);
  if (effects.empty()) {
    remove_effects(folder.path());
  } else {
    write_main_effects(folder.path(), effects);
  }
  write_citation(folder.path(), cite_results(folder.path()));
  replace_file(folder.path() + "/sweep.html", study_page(sweep.study.name, collected.table));
  const std::vector<std::string> table = study_table(collected.table, effects, kTerminalWidth);
  for (const std::string& line : table) console.say(line);
  if (!table.empty()) console.say("");
  console.say(counts_text(collected.counts));
  console.say(
      "table: " + folder.path() + "/runs.csv" +
      (base_law ? " (its forces and energies are those of the base's force law, without the sampled constants)" : ""));
  if (!effects.empty()) console.say(effects_line(folder.path(), effects));
  console.say("page: " + folder.path() + "/sweep.html");
  warn_of_runs(collected.warnings,
               fmt::format("{} of {} finished runs have warnings; the column message of runs.csv has all of them",
                           collected.warnings.runs(), collected.counts.done),
               console);
}

}  // namespace reamsim
