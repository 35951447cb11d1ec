// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/report/page_data.h"

#include <algorithm>
#include <vector>

#include "render/report/markup.h"

namespace reamsim {
namespace {

/// About the horizontal resolution of a screen.
constexpr std::size_t kMaxBuckets = 1000;

}  // namespace

std::vector<std::size_t> shown_rows(const std::vector<ForceRow>& rows) {
  const std::size_t bucket = 1 + (rows.size() - 1) / kMaxBuckets;
  std::vector<std::size_t> out;
  const auto force = [](const ForceRow& a, const ForceRow& b) { return a.axial_force_n < b.axial_force_n; };
  const auto torque = [](const ForceRow& a, const ForceRow& b) { return a.spin_torque_nmm < b.spin_torque_nmm; };
  const auto feed = [](const ForceRow& a, const ForceRow& b) {
    return a.push && b.push && a.push->feed_mm_s < b.push->feed_mm_s;
  };
  for (std::size_t from = 0; from < rows.size(); from += bucket) {
    const auto begin = rows.begin() + static_cast<std::ptrdiff_t>(from);
    const auto end = rows.begin() + static_cast<std::ptrdiff_t>(std::min(rows.size(), from + bucket));
    const auto [least_force, most_force] = std::minmax_element(begin, end, force);
    const auto [least_torque, most_torque] = std::minmax_element(begin, end, torque);
    const auto [least_feed, most_feed] = std::minmax_element(begin, end, feed);
    std::vector<std::size_t> chosen{from};
    for (const auto& row : {least_force, most_force, least_torque, most_torque, least_feed, most_feed}) {
      chosen.push_back(static_cast<std::size_t>(row - rows.begin()));
    }
    std::sort(chosen.begin(), chosen.end());
    chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
    out.insert(out.end(), chosen.begin(), chosen.end());
  }
  if (out.back() != rows.size() - 1) out.push_back(rows.size() - 1);
  return out;
}

nlohmann::ordered_json plot_data(const ForceLog& log, double mean_travel_mm) {
  nlohmann::ordered_json json{{"mean_travel_mm", mean_travel_mm}};
  const std::vector<std::size_t> shown = shown_rows(log.rows);
  const auto column = [&](const char* name, double ForceRow::*value) {
    auto& values = json[name] = nlohmann::ordered_json::array();
    for (const std::size_t i : shown) values.push_back(short_number(log.rows[i].*value));
  };
  for (const std::size_t i : shown) json["frame"].push_back(log.rows[i].frame);
  column("time_s", &ForceRow::time_s);
  column("depth_mm", &ForceRow::depth_mm);
  column("axial_force_n", &ForceRow::axial_force_n);
  column("spin_torque_nmm", &ForceRow::spin_torque_nmm);
  column("removed_mm3", &ForceRow::removed_mm3);
  if (mean_travel_mm > 0) {
    column("mean_axial_force_n", &ForceRow::layer_axial_force_n);
    column("mean_spin_torque_nmm", &ForceRow::layer_spin_torque_nmm);
  }
  if (log.rows.back().push) {
    for (const std::size_t i : shown) {
      const PushResult push = log.rows[i].push.value_or(PushResult{});
      json["feed_mm_s"].push_back(short_number(push.feed_mm_s));
      json["drill_power_w"].push_back(short_number(push.drill_power_w));
    }
  }
  return json;
}

}  // namespace reamsim
