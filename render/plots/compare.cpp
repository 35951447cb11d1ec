// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/plots/plots.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/text.h"

namespace reamsim {
namespace {

/// Colours whose least difference is 31 (CIE 1976 L*a*b*), also as seen with protanopia, deuteranopia and tritanopia;
/// tests/python/test_compare_colors.py measures it. With four dash types, 24 styles.
constexpr std::array<unsigned, 6> kCurveColors{0x332288, 0xe69f00, 0x56b4e9, 0x117733, 0x8c4f86, 0x000000};
constexpr std::size_t kDashes = 4;
static_assert(kCurveColors.size() * kDashes >= kLineStyles);

/// viridis (van der Walt and Smith 2015, CC0) without its lightest tenth, which is faint on white.
constexpr std::array<unsigned, 10> kRamp{0x440154, 0x482475, 0x414487, 0x355f8d, 0x2a788e,
                                         0x21918c, 0x22a884, 0x44bf70, 0x7ad151, 0xbddf26};
constexpr unsigned kNoValue = 0x999999;  // of a run without the number

/// Most characters of an entry in the legend: two fit side by side, and four of at most kShortEntry.
constexpr std::size_t kMostInLegend = 46, kShortEntry = 18;

unsigned ramp_color(double fraction) {
  const double place = std::clamp(fraction, 0.0, 1.0) * (kRamp.size() - 1);
  const auto low = std::min(static_cast<std::size_t>(place), kRamp.size() - 2);
  unsigned out = 0;
  for (int shift = 0; shift < 24; shift += 8) {
    const double from = kRamp[low] >> shift & 255U, to = kRamp[low + 1] >> shift & 255U;
    out |= static_cast<unsigned>(std::lround(std::lerp(from, to, place - static_cast<double>(low)))) << shift;
  }
  return out;
}

std::string array_text(const std::string& name, const std::vector<std::string>& items) {
  return fmt::format("array {}[{}] = [{}]\n", name, items.size(), fmt::join(items, ", "));
}

std::string color_text(unsigned color) {
  return fmt::format("0x{:06x}", color);
}

/// At most kMostInLegend characters: the middle of a longer text is left out.
std::string shortened(const std::string& text) {
  if (text_width(text) <= kMostInLegend) return text;
  constexpr std::ptrdiff_t kHalf = (kMostInLegend - 1) / 2;
  const std::vector<std::string> all = characters_of(text);
  return fmt::format("{}…{}", fmt::join(all.begin(), all.begin() + kHalf, ""),
                     fmt::join(all.end() - kHalf, all.end(), ""));
}

std::string single_styles(const Comparison& comparison) {
  std::vector<std::string> shades, dashes, entries, entry_shades, entry_dashes;
  for (std::size_t i = 0; i < comparison.runs.size(); ++i) {
    shades.push_back(color_text(kCurveColors[i % kCurveColors.size()]));
    dashes.push_back(std::to_string(i / kCurveColors.size() % kDashes + 1));
    // "3  label": the number is that of runs.csv.
    entries.push_back(gnuplot_string(std::to_string(i + 1) + "  " + shortened(comparison.runs[i].label)));
  }
  const bool short_entries =
      std::ranges::all_of(entries, [](const std::string& entry) { return text_width(entry) <= kShortEntry + 2; });
  return "colored_by = ''\ncolumns_of_key = " + std::string(short_entries ? "4" : "2") + "\n" +
         array_text("shade", shades) + array_text("dash", dashes) + array_text("entry", entries) +
         array_text("entry_shade", shades) + array_text("entry_dash", dashes);
}

/// The parameter that dash types show beside the ramp: the first other one with few values. nullptr: none.
const ComparedParameter* dashed_by(const Comparison& comparison, const ComparedMetric& ramp) {
  const auto found = std::ranges::find_if(comparison.parameters, [&](const ComparedParameter& parameter) {
    return parameter.key != ramp.key && parameter.distinct() <= kDashes;
  });
  return found == comparison.parameters.end() ? nullptr : &*found;
}

/// Dash of each run and the legend of the dash types; one dash for all without a parameter.
std::string dash_styles(const ComparedParameter* parameter, std::size_t runs) {
  std::vector<std::string> seen, entries, entry_dashes, dashes(runs, "1");
  for (std::size_t i = 0; i < runs && parameter != nullptr; ++i) {
    const auto found = std::ranges::find(seen, parameter->shown[i]);
    dashes[i] = std::to_string(found - seen.begin() + 1);
    if (found != seen.end()) continue;
    seen.push_back(parameter->shown[i]);
    entry_dashes.push_back(dashes[i]);
    entries.push_back(gnuplot_string(shortened(parameter->key + " = " + parameter->shown[i])));
  }
  if (parameter == nullptr) {
    entries = {"''"};
    entry_dashes = {"1"};
  }
  const std::vector<std::string> grey(entries.size(), "0x404040");
  return array_text("dash", dashes) + array_text("entry", entries) + array_text("entry_shade", grey) +
         array_text("entry_dash", entry_dashes);
}

std::string ramp_styles(const Comparison& comparison, const ComparedMetric& ramp) {
  std::vector<double> finite;
  std::ranges::copy_if(ramp.values, std::back_inserter(finite), [](double value) { return std::isfinite(value); });
  const auto [low, high] = std::ranges::minmax(finite);
  std::vector<std::string> shades, bar;
  for (const double value : ramp.values) {
    const double fraction = high > low ? (value - low) / (high - low) : 0;
    shades.push_back(color_text(std::isfinite(value) ? ramp_color(fraction) : kNoValue));
  }
  constexpr int kBarSteps = 64;
  for (int i = 0; i < kBarSteps; ++i) bar.push_back(color_text(ramp_color((i + 0.5) / kBarSteps)));
  return "columns_of_key = 2\ncolored_by = " + gnuplot_string(ramp.key.empty() ? "number of the run" : ramp.key) +
         "\n" + "ramp_low = " + shortest_text(low) + " + 0.0\nramp_high = " + shortest_text(high) + " + 0.0\n" +
         array_text("bar", bar) + array_text("shade", shades) +
         dash_styles(dashed_by(comparison, ramp), comparison.runs.size());
}

/// Ranks, less their mean; equal values share theirs.
Eigen::VectorXd centered_ranks(const std::vector<double>& values) {
  const Eigen::Map<const Eigen::ArrayXd> all(values.data(), std::ssize(values));
  const auto rank = [&](double value) {
    return 0.5 * static_cast<double>((all < value).count() - (all > value).count());
  };
  return all.unaryExpr(rank).matrix();
}

bool has_missing(const std::vector<double>& values) {
  return std::ranges::any_of(values, [](double value) { return std::isnan(value); });
}

/// Spearman's rank correlation of `a` and `b`; 0 where one is constant or has a missing value.
double rank_correlation(const std::vector<double>& a, const std::vector<double>& b) {
  if (has_missing(a) || has_missing(b)) return 0;
  const Eigen::VectorXd x = centered_ranks(a), y = centered_ranks(b);
  const double scale = std::sqrt(x.squaredNorm() * y.squaredNorm());
  return scale > 0 ? x.dot(y) / scale : 0;
}

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
  std::vector<RunColumn> columns;
  for (const ComparedParameter& parameter : comparison.parameters) {
    columns.push_back({parameter.key, parameter.values});
    for (std::size_t i = 0; i < comparison.runs.size(); ++i) {
      // csv_text() would take a negative number for a formula.
      if (std::isnan(parameter.numbers[i])) columns.back().cells[i] = csv_text(parameter.values[i]);
    }
  }
  for (const ComparedMetric& metric : comparison.metrics) {
    if (std::ranges::find(comparison.parameters, metric.key, &ComparedParameter::key) != comparison.parameters.end())
      continue;
    columns.push_back({metric.key, {}});
    for (const double value : metric.values) columns.back().cells.push_back(number_cell(value));
  }
  std::string out = "run,label";
  for (const RunColumn& column : columns) out += "," + csv_text(column.key);
  for (std::size_t i = 0; i < comparison.runs.size(); ++i) {
    out += "\n" + std::to_string(i + 1) + "," + csv_text(comparison.runs[i].label);
    for (const RunColumn& column : columns) out += "," + column.cells[i];
  }
  return out + "\n";
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

std::optional<ComparedMetric> colored_by(const Comparison& comparison) {
  if (!comparison.color_by.empty()) {
    std::vector<ComparedMetric> columns;
    for (const ComparedParameter& parameter : comparison.parameters)
      columns.push_back({parameter.key, parameter.numbers});
    columns.insert(columns.end(), comparison.metrics.begin(), comparison.metrics.end());
    for (const ComparedMetric& column : columns) {
      const bool has_number = std::ranges::any_of(column.values, [](double value) { return std::isfinite(value); });
      if (column.key == comparison.color_by && has_number) return column;
    }
    throw InputError({}, "--color-by", comparison.color_by + " is no number that differs between the runs",
                     "give a numeric column of runs.csv, such as removed_mm3");
  }
  if (comparison.runs.size() <= kLineStyles) return std::nullopt;
  const auto force = std::ranges::find(comparison.metrics, "headline.peak_axial_force_n", &ComparedMetric::key);
  const ComparedParameter* best = nullptr;
  double best_correlation = -1;
  for (const ComparedParameter& parameter : comparison.parameters) {
    if (has_missing(parameter.numbers)) continue;
    const double correlation =
        force == comparison.metrics.end() ? 0 : std::abs(rank_correlation(parameter.numbers, force->values));
    if (correlation <= best_correlation) continue;
    best = &parameter;
    best_correlation = correlation;
  }
  if (best != nullptr) return {{best->key, best->numbers}};
  ComparedMetric order;
  for (std::size_t i = 0; i < comparison.runs.size(); ++i) order.values.push_back(static_cast<double>(i + 1));
  return order;
}

void write_comparison(const std::string& dir, const Comparison& comparison) {
  // Arrays for the script: `shade` (colour) and `dash` (1 to 4) of each run, the entries of the legend, and the ramp.
  const std::optional<ComparedMetric> ramp = colored_by(comparison);
  const std::string styles = "runs = " + std::to_string(comparison.runs.size()) + "\n" +
                             (ramp ? ramp_styles(comparison, *ramp) : single_styles(comparison)) + "\n";
  write_curves(dir + "/curves.csv", comparison.runs);
  write_file(dir + "/compare.csv", metrics_csv(comparison));
  write_file(dir + "/runs.csv", runs_csv(comparison));
  draw_plot(dir, "compare", styles, embedded::script_compare);
}

}  // namespace reamsim
