// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/plots/compare.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "render/plots/compare_style.h"
#include "render/plots/plots.h"
#include "sim/base/csv.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/record/force_log.h"

namespace reamsim {
namespace embedded {
extern const char* const compare_script;
}
namespace {

std::string number_cell(double value) {
  return std::isfinite(value) ? shortest_text(value) : std::string();
}

std::string metrics_csv(const Comparison& comparison) {
  std::string out = "metric,run,value,difference,relative_difference\n";
  for (const ComparedMetric& metric : comparison.metrics) {
    for (std::size_t i = 0; i < comparison.runs.size(); ++i) {
      out += csv_text(metric.key) + "," + csv_text(comparison.runs[i].label) + "," + number_cell(metric.values[i]) +
             "," + number_cell(metric.difference(i)) + "," + number_cell(metric.relative(i)) + "\n";
    }
  }
  return out;
}

/// A row per run. A key of both scenario and summary is a parameter.
std::string runs_csv(const Comparison& comparison) {
  std::set<std::string> parameters;
  std::string out = "run,label";
  for (const ComparedParameter& parameter : comparison.parameters) {
    out += "," + csv_text(parameter.key);
    parameters.insert(parameter.key);
  }
  for (const ComparedMetric& metric : comparison.metrics) {
    if (!parameters.contains(metric.key)) out += "," + csv_text(metric.key);
  }
  out += "\n";
  for (std::size_t i = 0; i < comparison.runs.size(); ++i) {
    out += std::to_string(i + 1) + "," + csv_text(comparison.runs[i].label);
    for (const ComparedParameter& parameter : comparison.parameters) {
      // csv_text() would take a negative number for a formula.
      out += "," + (std::isnan(parameter.numbers[i]) ? csv_text(parameter.values[i]) : parameter.values[i]);
    }
    for (const ComparedMetric& metric : comparison.metrics) {
      if (!parameters.contains(metric.key)) out += "," + number_cell(metric.values[i]);
    }
    out += "\n";
  }
  return out;
}

/// Least fraction of the greatest force of a frame that counts as contact: a tooth may graze bone on the way out.
constexpr double kMinForceFraction = 0.01;

/// Rows of all runs together, and of one run at least and at most: what gnuplot draws in seconds.
constexpr std::size_t kMostRows = 60'000, kLeastPoints = 500, kMostPoints = 3000;

/// The time of the frame before the first with removed bone; NaN without one.
double contact_time_s(const ForceLog& log) {
  const auto first = std::ranges::find_if(log.rows, [](const ForceRow& row) { return row.removed_mm3 > 0; });
  if (first == log.rows.end()) return std::numeric_limits<double>::quiet_NaN();
  return (first == log.rows.begin() ? first : std::prev(first))->time_s;
}

/// Writes the curves of all runs, decimated.
void write_curves(const std::string& path, const std::vector<ComparedRun>& runs) {
  const std::size_t most = std::clamp(kMostRows / runs.size(), kLeastPoints, kMostPoints);
  CsvWriter csv(path, "run,time_s,depth_mm,contact,axial_force_n,spin_torque_nmm,removed_mm3,contact_time_s");
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const ForceLog log = read_force_log(runs[r].dir + "/forces.csv", {.mean_travel_mm = runs[r].mean_travel_mm});
    double greatest_n = 0;
    for (const ForceRow& row : log.rows) greatest_n = std::max(greatest_n, std::abs(row.layer_axial_force_n));
    const double contact_s = contact_time_s(log);
    const std::size_t step = 1 + log.rows.size() / most;
    for (std::size_t i = 0; i < log.rows.size(); i += step) {
      const ForceRow& row = log.rows[i];
      const RowPoint& middle = row.layer_middle;
      const bool contact = std::abs(row.layer_axial_force_n) > kMinForceFraction * greatest_n;
      csv.row({static_cast<double>(r + 1), middle.time_s, middle.depth_mm, contact ? 1.0 : 0.0, row.layer_axial_force_n,
               row.layer_spin_torque_nmm, middle.removed_mm3, middle.time_s - contact_s});
    }
  }
  csv.close();
}

}  // namespace

void write_comparison(const std::string& dir, const Comparison& comparison) {
  const std::string styles = curve_styles(comparison);
  write_curves(dir + "/curves.csv", comparison.runs);
  write_file(dir + "/compare.csv", metrics_csv(comparison));
  write_file(dir + "/runs.csv", runs_csv(comparison));
  draw_plot(dir, "compare", styles, embedded::compare_script);
}

}  // namespace reamsim
