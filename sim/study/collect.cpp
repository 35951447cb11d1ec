// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/study_folder.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>

#include "sim/base/csv.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/record/result_json.h"
#include "sim/scenario/key_tree.h"
#include "sim/scenario/show.h"

namespace reamsim {

void RunMessages::add(int number, const std::vector<std::string>& messages) {
  runs_ += messages.empty() ? 0 : 1;
  for (const std::string& message : messages) {
    const auto found = std::ranges::find(texts_, message, &Text::message);
    if (found != texts_.end()) {
      ++found->runs;
    } else if (texts_.size() < kMost) {
      texts_.push_back({number, 1, message});
    }
  }
}

std::vector<std::string> RunMessages::lines(std::size_t most) const {
  std::vector<std::string> out;
  for (std::size_t i = 0; i < std::min(most, texts_.size()); ++i) {
    const Text& text = texts_[i];
    const std::string more = text.runs > 1 ? fmt::format(" and {} more", text.runs - 1) : "";
    out.push_back(fmt::format("run {}{}: {}", text.number, more, text.message));
  }
  return out;
}

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr std::size_t kMostSummaryBytes = 16'000'000;

RunState state_of(const StudyFolder& folder, const IdentifiedRun& run) {
  return run.id.empty() ? RunState::failed : folder.state(run.id);
}

void count(RunState state, StudyCounts& counts) {
  int* const by_state[] = {&counts.missing, &counts.interrupted, &counts.failed, &counts.done};  // as RunState
  ++*by_state[static_cast<std::size_t>(state)];
}

CollectedRun collected(const StudyFolder& folder, const PlannedRun& planned, const IdentifiedRun& run, RunState state) {
  CollectedRun out{.number = planned.number,
                   .id = run.id,
                   .state = state,
                   .message = run.mistake,
                   .cells = planned.cells,
                   .numbers = {}};
  if (out.message.empty() && out.state == RunState::failed) out.message = folder.failure(run.id);
  std::error_code error;
  out.has_report = out.state == RunState::done && fs::exists(folder.run_dir(run.id) + "/report.html", error);
  return out;
}

void write_row(const CollectedRun& run, std::ostream& out) {
  out << run.number << ',' << run.id << ',' << name_of(run.state) << ',' << csv_text(run.message);
  for (const std::string& text : run.cells) out << ',' << (parse_number(text) ? text : csv_text(text));
  for (const double value : run.numbers) out << ',' << (std::isnan(value) ? std::string() : shortest_text(value));
  out << '\n';
}

/// Units that only results have, beside those of scenario keys.
constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kUnitsOfResults{
    {{"_percent", "%"}, {"_mm3", "mm³"}, {"_mm2", "mm²"}, {"_mj", "mJ"}, {"_nmm", "N·mm"}}};

std::pair<std::string, std::string> name_and_unit(const std::string& part) {
  if (unit_of(part).empty()) {
    for (const auto& [suffix, unit] : kUnitsOfResults) {
      if (part.ends_with(suffix)) return {part.substr(0, part.size() - suffix.size()), std::string(unit)};
    }
  }
  return {std::string(without_unit(part)), std::string(unit_of(part))};
}

/// The name of a column by the last parts of its key: those that it needs, and `more`.
ColumnName made_name(const std::string& key, std::size_t more) {
  const std::vector<std::string> parts = split(key, '.');
  std::size_t at = parts.size() - 1;
  std::string index;
  while (at > 0 && is_whole_number(parts[at])) index = " " + parts[at--] + index;
  const auto [name, unit] = name_and_unit(parts[at]);
  std::string text = name + index;
  // One word, or a part of a tilt or shift, says too little without what is before it.
  if (name.find('_') == std::string::npos || name.starts_with("tilt_") || name.starts_with("shift_")) ++more;
  while (at > 0 && (more > 0 || is_whole_number(parts[at]))) {
    if (!is_whole_number(parts[--at])) --more;
    text = name_and_unit(parts[at]).first + " " + text;
  }
  std::ranges::replace(text, '_', ' ');
  return {key, text, unit};
}

}  // namespace

StudyCounts count_runs(const StudyFolder& folder, const std::vector<IdentifiedRun>& runs) {
  StudyCounts counts;
  for (const IdentifiedRun& run : runs) count(state_of(folder, run), counts);
  return counts;
}

RunMessages warnings_of_runs(const StudyFolder& folder, const StudyPlan& plan, const std::vector<IdentifiedRun>& runs) {
  RunMessages out;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    if (state_of(folder, runs[i]) != RunState::done) continue;
    out.add(plan.runs[i].number, read_run_summary(folder.run_dir(runs[i].id)).warnings);
  }
  return out;
}

CollectedStudy collect_runs(const StudyFolder& folder, const StudyPlan& plan, const std::vector<IdentifiedRun>& runs,
                            std::size_t most_in_table) {
  std::vector<std::string> names;  // of all numbers; new ones follow those of the runs before
  std::map<std::string, std::size_t> places;
  std::vector<RunState> states;  // once: other processes may work on the study
  for (const IdentifiedRun& run : runs) {
    states.push_back(state_of(folder, run));
    if (states.back() != RunState::done) continue;
    for (const auto& [name, value] : read_run_summary(folder.run_dir(run.id)).numbers) {
      if (places.emplace(name, names.size()).second) names.push_back(name);
    }
  }
  CollectedStudy out{.counts = {}, .table = {plan.columns, {}, {}, runs.size()}, .warnings = {}};
  std::vector<std::size_t> results;  // places of the numbers that are no parameters
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (std::ranges::find(plan.columns, names[i]) != plan.columns.end()) continue;
    results.push_back(i);
    out.table.results.push_back(names[i]);
  }
  const std::vector<bool> in_table = runs_of_table(runs.size(), most_in_table);
  // Replaces an older file when it is complete.
  const std::string path = folder.path() + "/runs.csv", unfinished = path + ".tmp";
  std::ofstream file(unfinished, std::ios::binary);
  file << "run,id,status,message";
  for (const std::string& name : plan.columns) file << ',' << csv_text(name);
  for (const std::string& name : names) file << ',' << name;
  file << '\n';
  for (std::size_t i = 0; i < runs.size(); ++i) {
    CollectedRun run = collected(folder, plan.runs[i], runs[i], states[i]);
    count(run.state, out.counts);
    const RunSummary summary = run.state == RunState::done ? read_run_summary(folder.run_dir(run.id)) : RunSummary();
    run.numbers.assign(names.size(), std::numeric_limits<double>::quiet_NaN());
    for (const auto& [name, value] : summary.numbers) run.numbers[places.at(name)] = value;
    out.warnings.add(run.number, summary.warnings);
    for (const std::string& warning : summary.warnings) run.message += (run.message.empty() ? "" : "; ") + warning;
    write_row(run, file);
    if (!in_table[i]) continue;
    std::vector<double> numbers;
    for (const std::size_t place : results) numbers.push_back(run.numbers[place]);
    run.numbers = std::move(numbers);
    out.table.runs.push_back(std::move(run));
  }
  close_file(file, unfinished);
  sync_to_disk(unfinished);
  std::error_code error;
  fs::rename(unfinished, path, error);
  if (error) fail_to_write(path);
  return out;
}

RunSummary read_run_summary(const std::string& run_dir) {
  RunSummary out;
  Json json = parse_result_json(read_file_start(run_dir + "/summary.json", kMostSummaryBytes));
  if (!json.is_object()) return out;
  for (const char* differs_from_run_to_run : {"timings_s", "memory_mb"}) json.erase(differs_from_run_to_run);
  for_each_number(json, "", ".", "",
                  [&](const std::string& name, double value) { out.numbers.emplace_back(name, value); });
  const Json warnings = json.value("warnings", Json());
  for (const Json& warning : warnings.is_array() ? warnings : Json::array()) {
    if (warning.is_string()) out.warnings.push_back(warning.get<std::string>());
  }
  return out;
}

std::vector<bool> runs_of_table(std::size_t all, std::size_t most) {
  std::vector<bool> taken(all, all <= most);
  // Every k-th run would miss levels of the parameters that change fastest. Selection sampling (Knuth, The Art of
  // Computer Programming 2, 3.4.2, algorithm S), by integers alone.
  std::mt19937_64 random(1);
  std::size_t wanted = all <= most ? 0 : most;
  for (std::size_t i = 0; i < all && wanted > 0; ++i) {
    if (random() % (all - i) >= wanted) continue;
    taken[i] = true;
    --wanted;
  }
  return taken;
}

std::string ColumnName::title() const {
  std::string out = text;
  if (!out.empty()) out[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(out[0])));
  return unit.empty() ? out : out + " (" + unit + ")";
}

const std::vector<ColumnName>& headline_results() {
  static const std::vector<ColumnName> results{
      {"headline.peak_axial_force_n", "peak axial force", "N"},
      {"headline.peak_spin_torque_nmm", "peak spin torque", "N·mm"},
      {"removed_mm3", "removed volume", "mm³"},
      {"headline.depth_mm", "tool depth", "mm"},
      {"energy_mj", "cutting energy", "mJ"},
      {"metrics.orientation.reamed.version_deg", "version, reamed face", "°"},
      {"metrics.orientation.reamed.inclination_deg", "inclination, reamed face", "°"},
      {"metrics.seating.seated_percent", "backside seated", "%"},
      {"metrics.planning.planned.version_deg", "version, implant", "°"},
      {"metrics.planning.planned.inclination_deg", "inclination, implant", "°"},
      {"metrics.planning.medialization_mm", "medialization by the implant", "mm"},
      {"metrics.planning.vault.left_percent", "remaining vault bone", "%"}};
  return results;
}

std::vector<ColumnName> column_names(const std::vector<std::string>& keys) {
  constexpr std::size_t kMostParents = 4;
  const auto& fixed = headline_results();
  std::vector<ColumnName> out(keys.size());
  std::map<std::string, int> uses;
  for (const ColumnName& name : fixed) ++uses[name.title()];
  std::vector<std::size_t> unnamed;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const auto found = std::ranges::find(fixed, keys[i], &ColumnName::key);
    out[i] = found == fixed.end() ? ColumnName{} : *found;
    if (found == fixed.end()) unnamed.push_back(i);
  }
  // Names that several keys would have get more parts.
  for (std::size_t more = 0; more <= kMostParents && !unnamed.empty(); ++more) {
    std::map<std::string, int> now = uses;
    for (const std::size_t i : unnamed) {
      out[i] = made_name(keys[i], more);
      ++now[out[i].title()];
    }
    std::erase_if(unnamed, [&](std::size_t i) {
      const bool is_unique = now[out[i].title()] == 1;
      if (is_unique) ++uses[out[i].title()];
      return is_unique;
    });
  }
  for (const std::size_t i : unnamed) out[i] = {keys[i], keys[i], ""};
  return out;
}

std::string shown_cell(const std::string& cell) {
  if (cell.empty()) return "as in the base";
  if (const auto number = parse_number(cell)) return fmt::format("{:.4g}", *number);
  static constexpr std::array kInputs{".stl", ".obj", ".ply", ".vtp", ".nrrd", ".nii", ".mha", ".mhd", ".vdb", ".csv"};
  const std::filesystem::path path(cell);
  const bool is_file = std::ranges::find(kInputs, path.extension().string()) != kInputs.end();
  if (!is_file && cell.find('/') == std::string::npos) return cell;
  const std::string stem = path.stem().string();
  return stem.empty() ? cell : stem;
}

}  // namespace reamsim
