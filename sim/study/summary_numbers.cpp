// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/summary_numbers.h"

#include "sim/base/file.h"
#include "sim/record/result_json.h"

namespace reamsim {

namespace {

using Json = nlohmann::ordered_json;
using Numbers = std::vector<std::pair<std::string, double>>;

constexpr std::size_t kMostSummaryBytes = 16'000'000;

/// Sections of summary.json that are not the same in every run of a scenario.
bool differs_from_run_to_run(const std::string& name) {
  return name == "timings_s" || name == "memory_mb";
}

void flatten(const Json& json, const std::string& name, Numbers& out) {
  if (json.is_number()) {
    out.emplace_back(name, json.get<double>());
  } else if (json.is_object()) {
    for (const auto& [key, value] : json.items()) {
      if (!name.empty() || !differs_from_run_to_run(key)) flatten(value, name.empty() ? key : name + "." + key, out);
    }
  } else if (json.is_array()) {
    for (std::size_t i = 0; i < json.size(); ++i) flatten(json[i], name + "." + std::to_string(i), out);
  }
}

}  // namespace

RunSummary read_run_summary(const std::string& run_dir) {
  RunSummary out;
  const Json json = parse_result_json(read_file_start(run_dir + "/summary.json", kMostSummaryBytes));
  if (!json.is_object()) return out;
  flatten(json, "", out.numbers);
  const Json warnings = json.value("warnings", Json());
  for (const Json& warning : warnings.is_array() ? warnings : Json::array()) {
    if (warning.is_string()) out.warnings.push_back(warning.get<std::string>());
  }
  return out;
}

Numbers summary_numbers(const std::string& run_dir) {
  return read_run_summary(run_dir).numbers;
}

}  // namespace reamsim
