// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/main_effects.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <optional>

#include "sim/scenario/show.h"

namespace reamsim {

namespace {

/// More values of a number than this are grouped by intervals.
constexpr std::size_t kMostNumericLevels = 8;
/// More levels of a text do not fit an axis.
constexpr std::size_t kMostLevels = 40;
constexpr std::size_t kMostIntervals = 8, kLeastValuesOfInterval = 8;
/// A result whose values differ by less than this fraction of them does not vary: it is rounding.
constexpr double kLeastVariation = 1e-9;
/// Nor does an angle that differs by less than this, °: the fits of faces have errors of some hundredths.
constexpr double kLeastVariation_deg = 0.1;

/// Numbers of all runs, or nullopt where a cell is none.
std::optional<std::vector<double>> numbers_of(const std::vector<std::string>& cells) {
  std::vector<double> out;
  for (const std::string& cell : cells) {
    const auto number = parse_number(cell);
    if (!number || !std::isfinite(*number)) return std::nullopt;
    out.push_back(*number);
  }
  return out;
}

/// Groups with equally many different values, at least two.
void group_by_intervals(const std::vector<double>& values, EffectParameter& out) {
  const std::size_t intervals = std::clamp<std::size_t>(values.size() / kLeastValuesOfInterval, 2, kMostIntervals);
  for (const double x : out.x) {
    const auto place = static_cast<std::size_t>(std::ranges::lower_bound(values, x) - values.begin());
    out.group.push_back(place * intervals / values.size());
  }
}

std::optional<EffectParameter> numeric_parameter(std::vector<double> x) {
  std::vector<double> values = x;
  std::ranges::sort(values);
  values.erase(std::unique(values.begin(), values.end()), values.end());
  if (values.size() < 2) return std::nullopt;
  EffectParameter out;
  out.is_number = true;
  out.x = std::move(x);
  out.has_intervals = values.size() > kMostNumericLevels;
  if (out.has_intervals) {
    group_by_intervals(values, out);
    return out;
  }
  for (const double value : values) out.levels.push_back(shown_cell(number_text(value)));
  for (const double value : out.x) {
    out.group.push_back(static_cast<std::size_t>(std::ranges::lower_bound(values, value) - values.begin()));
  }
  return out;
}

/// Leaves out what all levels begin with, up to the last separator in it: "reamer_flat" is "flat".
void shorten(std::vector<std::string>& levels) {
  std::size_t same = levels[0].size();
  for (const std::string& level : levels) {
    same = std::min(same, static_cast<std::size_t>(std::ranges::mismatch(levels[0], level).in1 - levels[0].begin()));
  }
  const std::size_t separator = levels[0].substr(0, same).find_last_of("_- ");
  if (separator == std::string::npos) return;
  const auto ends = [&](const std::string& level) { return level.size() == separator + 1; };
  if (std::ranges::any_of(levels, ends)) return;
  for (std::string& level : levels) level.erase(0, separator + 1);
}

/// Levels in the order of the plan.
std::optional<EffectParameter> text_parameter(const std::vector<std::string>& cells) {
  EffectParameter out;
  std::map<std::string, std::size_t> places;
  for (const std::string& cell : cells) {
    const auto [found, is_new] = places.emplace(cell, places.size());
    if (is_new) out.levels.push_back(shown_cell(cell));
    out.group.push_back(found->second);
    out.x.push_back(static_cast<double>(found->second + 1));
  }
  const bool differs_in_every_run = places.size() == cells.size() && cells.size() > 2;
  if (places.size() < 2 || places.size() > kMostLevels || differs_in_every_run) return std::nullopt;
  shorten(out.levels);
  return out;
}

/// Whether two parameters group the runs in the same way, whatever the numbers of the groups.
bool group_alike(const EffectParameter& a, const EffectParameter& b) {
  if (a.has_intervals || b.has_intervals || a.levels.size() != b.levels.size()) return false;
  std::map<std::size_t, std::size_t> partner;
  for (std::size_t i = 0; i < a.group.size(); ++i) {
    if (partner.emplace(a.group[i], b.group[i]).first->second != b.group[i]) return false;
  }
  return true;  // as many levels of both, and each of a has one of b
}

/// A vector that is tilted or shifted: the columns of its parts are the parameters.
bool has_parts(const RunTable& table, const std::string& key) {
  return std::ranges::any_of(table.parameters, [&](const std::string& other) {
    return other.starts_with(key + ".tilt_") || other.starts_with(key + ".shift_");
  });
}

std::vector<EffectParameter> varying_parameters(const RunTable& table, const std::vector<std::size_t>& runs) {
  const std::vector<ColumnName> names = column_names(table.parameters);
  std::vector<EffectParameter> out;
  for (std::size_t p = 0; p < table.parameters.size(); ++p) {
    std::vector<std::string> cells;
    for (const std::size_t run : runs) cells.push_back(table.runs[run].cells[p]);
    if (has_parts(table, table.parameters[p])) continue;
    auto numbers = numbers_of(cells);
    auto parameter = numbers ? numeric_parameter(std::move(*numbers)) : text_parameter(cells);
    if (!parameter) continue;
    parameter->name = names[p];
    const auto same = std::ranges::find_if(out, [&](const auto& other) { return group_alike(other, *parameter); });
    if (same == out.end()) {
      out.push_back(std::move(*parameter));
    } else {
      same->with.push_back(parameter->name.key);
    }
  }
  return out;
}

bool varies(const std::vector<double>& values, const std::string& unit) {
  double least = std::numeric_limits<double>::infinity(), most = -least;
  for (const double value : values) {
    if (std::isnan(value)) continue;
    least = std::min(least, value);
    most = std::max(most, value);
  }
  const double least_variation =
      unit == "°" ? kLeastVariation_deg : kLeastVariation * std::max(std::abs(most), std::abs(least));
  return most - least > least_variation;
}

std::vector<EffectResult> varying_results(const RunTable& table, const std::vector<std::size_t>& runs) {
  std::vector<EffectResult> out;
  for (const ColumnName& name : headline_results()) {
    const auto found = std::ranges::find(table.results, name.key);
    if (found == table.results.end()) continue;
    EffectResult result{name, {}};
    const auto place = static_cast<std::size_t>(found - table.results.begin());
    for (const std::size_t run : runs) result.y.push_back(table.runs[run].numbers[place]);
    if (varies(result.y, name.unit)) out.push_back(std::move(result));
  }
  return out;
}

/// Means over the groups, and their sums of squares.
class EffectSums {
 public:
  EffectSums(const EffectParameter& parameter, const EffectResult& result) {
    const std::size_t groups = 1 + *std::ranges::max_element(parameter.group);
    groups_.resize(groups, {.from = kInfinity, .to = -kInfinity});
    for (std::size_t i = 0; i < groups; ++i) groups_[i].level = i;
    for (std::size_t i = 0; i < result.y.size(); ++i) add(parameter.group[i], parameter.x[i], result.y[i]);
    for (EffectGroup& group : groups_) {
      if (group.runs == 0) continue;
      group.x /= group.runs;
      group.mean /= group.runs;
    }
    mean_ /= runs_;
    for (std::size_t i = 0; i < result.y.size(); ++i) {
      if (!std::isnan(result.y[i])) add_squares(groups_[parameter.group[i]], result.y[i]);
    }
  }

  [[nodiscard]] MainEffect effect(bool has_intervals) {
    MainEffect out;
    for (EffectGroup& group : groups_) {
      if (group.runs == 0) continue;
      group.sd = group.runs > 1 ? std::sqrt(group.sd / (group.runs - 1)) : 0;
      out.groups.push_back(group);
    }
    const double groups = static_cast<double>(out.groups.size());
    double within = within_ / all_;
    if (has_intervals && runs_ > groups) within *= (runs_ - 1) / (runs_ - groups);
    out.explained = all_ > 0 ? std::clamp(1 - within, 0.0, 1.0) : 0;
    return out;
  }

 private:
  static constexpr double kInfinity = std::numeric_limits<double>::infinity();

  void add(std::size_t place, double x, double y) {
    if (std::isnan(y)) return;
    EffectGroup& group = groups_[place];
    ++group.runs;
    group.x += x;
    group.mean += y;
    group.from = std::min(group.from, x);
    group.to = std::max(group.to, x);
    runs_ += 1;
    mean_ += y;
  }
  void add_squares(EffectGroup& group, double y) {
    group.sd += (y - group.mean) * (y - group.mean);
    within_ += (y - group.mean) * (y - group.mean);
    all_ += (y - mean_) * (y - mean_);
  }

  std::vector<EffectGroup> groups_;
  double runs_ = 0, mean_ = 0, within_ = 0, all_ = 0;
};

/// Dominant parameters first.
void sort_by_effect(MainEffects& effects) {
  std::vector<std::size_t> order(effects.parameters.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, std::greater(), [&](std::size_t p) { return effects.explains(p); });
  MainEffects sorted{effects.runs, {}, std::move(effects.results), {}};
  for (const std::size_t p : order) {
    sorted.parameters.push_back(std::move(effects.parameters[p]));
    sorted.effects.push_back(std::move(effects.effects[p]));
  }
  effects = std::move(sorted);
}

}  // namespace

double MainEffects::explains(std::size_t parameter) const {
  double sum = 0;
  for (const MainEffect& effect : effects[parameter]) sum += effect.explained;
  return results.empty() ? 0 : sum / static_cast<double>(results.size());
}

std::string level_text(const EffectParameter& parameter, const EffectGroup& group) {
  return parameter.has_intervals ? "" : parameter.levels[group.level];
}

MainEffects main_effects(const RunTable& table) {
  MainEffects out;
  for (std::size_t i = 0; i < table.runs.size(); ++i) {
    if (table.runs[i].state == RunState::done) out.runs.push_back(i);
  }
  if (out.runs.size() < 2) return out;
  out.parameters = varying_parameters(table, out.runs);
  out.results = varying_results(table, out.runs);
  for (const EffectParameter& parameter : out.parameters) {
    out.effects.emplace_back();
    for (const EffectResult& result : out.results) {
      out.effects.back().push_back(EffectSums(parameter, result).effect(parameter.has_intervals));
    }
  }
  sort_by_effect(out);
  return out;
}

}  // namespace reamsim
