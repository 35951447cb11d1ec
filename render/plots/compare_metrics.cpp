// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <cmath>
#include <limits>
#include <map>

#include "render/plots/compare.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/record/result_json.h"

namespace reamsim {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

Json read_summary(const std::string& path) {
  const Json summary = parse_result_json(read_file(path, "expected the results folder of a finished run"));
  if (!summary.is_object() || !summary.contains("removed_mm3") || !summary.contains("forces")) {
    throw InputError({path, 0, 0}, "", "damaged, or not the summary of a run",
                     "expected a file written by `reamsim run`");
  }
  return summary;
}

/// Calls visit(key, number) for every number below `json`.
template <class Visit>
void for_each_number(const Json& json, const std::string& key, const Visit& visit) {
  if (json.is_number()) visit(key, json.get<double>());
  if (!json.is_structured()) return;
  std::size_t item = 0;
  for (const auto& [name, value] : json.items()) {
    const std::string path = json.is_array() ? key + "[" + std::to_string(item++) + "]"
                             : key.empty()   ? name
                                             : key + "." + name;
    for_each_number(value, path, visit);
  }
}

}  // namespace

double ComparedMetric::relative(std::size_t i) const {
  return values[0] == 0 ? kNone : difference(i) / std::abs(values[0]);
}

std::vector<ComparedMetric> compare_summaries(const std::vector<ComparedRun>& runs) {
  std::vector<ComparedMetric> out;
  std::map<std::string, std::size_t> places;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    for_each_number(read_summary(runs[i].dir + "/summary.json"), "", [&](const std::string& key, double value) {
      const auto [found, is_new] = places.try_emplace(key, out.size());
      if (is_new) out.push_back({key, std::vector<double>(runs.size(), kNone)});
      out[found->second].values[i] = value;
    });
  }
  return out;
}

}  // namespace reamsim
