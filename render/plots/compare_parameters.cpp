// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <set>
#include <sstream>

#include "render/plots/compare.h"
#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/scenario/scenario_values.h"

namespace reamsim {
namespace {

constexpr double kNoNumber = std::numeric_limits<double>::quiet_NaN();

/// Ends the name of a parameter: the contents of an input file.
constexpr std::string_view kSumOfInput = " (contents)";

/// Adds the checksums of input files, which are comments of scenario.yaml: "# sha256 SUM  KEY  PATH". Their beginnings
/// tell files apart.
void add_checksums(const std::string& text, ScenarioValues& out) {
  constexpr std::string_view kBegin = "# sha256 ";
  constexpr std::size_t kShown = 12;
  for (const std::string& line : split(text, '\n')) {
    if (!line.starts_with(kBegin)) continue;
    std::istringstream words(line.substr(kBegin.size()));
    std::string sum, key;
    if (words >> sum >> key && key != "scenario")
      out.emplace_back(key + std::string(kSumOfInput), "sha256:" + sum.substr(0, kShown));
  }
}

/// Leaves out the checksums of inputs whose paths differ anyway, or that some runs do not have.
void leave_out_sums(std::vector<ComparedParameter>& parameters) {
  const std::vector<ComparedParameter> all = parameters;
  std::erase_if(parameters, [&](const ComparedParameter& sums) {
    if (!sums.key.ends_with(kSumOfInput)) return false;
    const std::string path = sums.key.substr(0, sums.key.size() - kSumOfInput.size());
    return std::ranges::find(all, path, &ComparedParameter::key) != all.end() ||
           std::ranges::find(sums.values, "") != sums.values.end();
  });
}

double as_number(const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto read = std::from_chars(text.data(), end, value);
  return read.ec == std::errc() && read.ptr == end && std::isfinite(value) ? value : kNoNumber;
}

/// File names where they tell the paths apart.
std::vector<std::string> shown_values(const std::vector<std::string>& values) {
  std::map<std::string, std::set<std::string>> paths_of;
  for (const std::string& value : values) {
    if (value.find('/') == std::string::npos && !value.empty()) return values;
    paths_of[std::filesystem::path(value).filename().string()].insert(value);
  }
  if (std::ranges::any_of(paths_of, [](const auto& name) { return name.second.size() > 1; })) return values;
  std::vector<std::string> out;
  for (const std::string& value : values) out.push_back(std::filesystem::path(value).filename().string());
  return out;
}

}  // namespace

bool ComparedParameter::is_number() const {
  return std::ranges::none_of(numbers, [](double number) { return std::isnan(number); });
}

std::size_t ComparedParameter::distinct() const {
  return std::set<std::string>(values.begin(), values.end()).size();
}

std::vector<ComparedParameter> compare_scenarios(const std::vector<ComparedRun>& runs) {
  std::vector<ComparedParameter> all;
  std::map<std::string, std::size_t> places;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::string path = runs[i].dir + "/scenario.yaml";
    const std::string text = read_file(path, "expected the results folder of a finished run");
    ScenarioValues found = values_of_scenario(*parse_yaml(text, path));
    add_checksums(text, found);
    for (const auto& [key, value] : found) {
      const auto [place, is_new] = places.try_emplace(key, all.size());
      if (is_new) all.push_back({key, std::vector<std::string>(runs.size()), {}, {}});
      all[place->second].values[i] = value;
    }
  }
  std::erase_if(all, [](const ComparedParameter& parameter) { return parameter.distinct() == 1; });
  leave_out_sums(all);
  for (ComparedParameter& parameter : all) {
    for (const std::string& value : parameter.values) parameter.numbers.push_back(as_number(value));
    parameter.shown = shown_values(parameter.values);
  }
  return all;
}

}  // namespace reamsim
