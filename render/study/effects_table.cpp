// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/study/effects_table.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/base/statistics.h"
#include "sim/base/text.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

constexpr std::size_t kMostRunsInRows = 20;
/// Rows of levels, so that the table fits a screen.
constexpr std::size_t kMostRows = 24;
/// Characters of a parameter.
constexpr std::size_t kMostCell = 24;

using Row = std::vector<std::string>;

std::string cut(const std::string& text, std::size_t most) {
  std::string out;
  for (const char c : printable(text)) {
    if ((static_cast<unsigned char>(c) & 0xc0) != 0x80 && text_width(out) == most) return out;
    out += c;
  }
  return out;
}

/// Numbers of a list with four digits, and "…" where the rest does not fit: [-41.2, 9.2, 36.6].
std::string short_cell(const std::string& cell, std::size_t most) {
  std::string text = shown_cell(cell);
  if (cell.starts_with('[') && cell.ends_with(']')) {
    std::string list;
    bool numbers = true;
    for (std::string part : split(cell.substr(1, cell.size() - 2), ',')) {
      part.erase(0, part.find_first_not_of(' '));
      const auto number = parse_number(part);
      numbers = numbers && number;
      if (number) list += (list.empty() ? "" : ", ") + fmt::format("{:.4g}", *number);
    }
    if (numbers) text = "[" + list + "]";
  }
  return text_width(printable(text)) > most ? cut(text, most - 1) + "…" : cut(text, most);
}

bool is_wider(const std::vector<std::string>& lines, std::size_t width) {
  return std::ranges::any_of(lines, [&](const std::string& line) { return text_width(line) > width; });
}

// --- a row per run

bool varies(const Row& cells) {
  return std::ranges::any_of(cells, [&](const std::string& cell) { return cell != cells[0]; });
}

/// A column with its title on two lines.
Row titled(const ColumnName& name, const Row& cells) {
  const auto [upper, lower] = two_lines(cut(name.title(), 32));
  Row out{upper, lower};
  out.insert(out.end(), cells.begin(), cells.end());
  return out;
}

/// Results that differ between the runs; all of them where none does.
std::vector<Row> columns_of_results(const RunTable& table) {
  std::vector<Row> all, varied;
  for (const ColumnName& name : headline_results()) {
    const auto found = std::ranges::find(table.results, name.key);
    if (found == table.results.end()) continue;
    const auto place = static_cast<std::size_t>(found - table.results.begin());
    Row cells;
    for (const CollectedRun& run : table.runs) {
      const double number = run.numbers.empty() ? std::numeric_limits<double>::quiet_NaN() : run.numbers[place];
      cells.push_back(std::isnan(number) ? "-" : fmt::format("{:.4g}", number));
    }
    all.push_back(titled(name, cells));
    if (varies(cells)) varied.push_back(all.back());
  }
  return varied.empty() ? all : varied;
}

/// Parameters that differ between the runs, and results.
std::vector<Row> columns_of_runs(const RunTable& table) {
  std::vector<Row> out;
  const std::vector<ColumnName> names = column_names(table.parameters);
  for (std::size_t p = 0; p < names.size(); ++p) {
    Row cells, shown;
    for (const CollectedRun& run : table.runs) {
      cells.push_back(run.cells[p]);
      shown.push_back(short_cell(run.cells[p], kMostCell));
    }
    if (varies(cells)) out.push_back(titled(names[p], shown));
  }
  const std::vector<Row> results = columns_of_results(table);
  out.insert(out.end(), results.begin(), results.end());
  return out;
}

/// A row per run, with as many columns as fit.
std::vector<std::string> rows_of_runs(const RunTable& table, std::size_t width) {
  std::vector<Row> rows{{"run"}, {""}};
  for (const CollectedRun& run : table.runs) rows.push_back({fmt::format("{:2} {}", run.number, name_of(run.state))});
  for (const Row& column : columns_of_runs(table)) {
    std::vector<Row> more = rows;
    for (std::size_t i = 0; i < rows.size(); ++i) more[i].push_back(column[i]);
    if (is_wider(align_columns(more), width)) break;
    rows = std::move(more);
  }
  return align_columns(rows);
}

// --- means by level

/// 47.1 ± 3.2: the deviation with two digits, the mean with as many decimals.
std::string mean_text(const EffectGroup& group) {
  if (group.runs == 1) return fmt::format("{:.4g}", group.mean);
  const int decimals = group.sd > 0 ? static_cast<int>(std::clamp(1 - std::floor(std::log10(group.sd)), 0.0, 6.0)) : 2;
  return fmt::format("{:.{}f} ± {:.{}f}", group.mean, decimals, group.sd, decimals);
}

std::string range_or_level(const EffectParameter& parameter, const EffectGroup& group) {
  if (!parameter.has_intervals) return level_text(parameter, group);
  return fmt::format("{:.3g} to {:.3g}", group.from, group.to);
}

/// Mean and deviation over all runs.
EffectGroup all_of(const EffectResult& result) {
  EffectGroup out;
  for (const double y : result.y) {
    if (std::isnan(y)) continue;
    ++out.runs;
    out.mean += y;
  }
  out.mean /= out.runs;
  for (const double y : result.y) {
    if (!std::isnan(y)) out.sd += (y - out.mean) * (y - out.mean);
  }
  out.sd = out.runs > 1 ? std::sqrt(out.sd / (out.runs - 1)) : 0;
  return out;
}

/// The quantiles of a result, with the digits of its deviation.
std::string quantile_text(const EffectResult& result, double fraction) {
  std::vector<double> values = result.y;
  std::erase_if(values, [](double y) { return std::isnan(y); });
  EffectGroup group = all_of(result);
  group.mean = quantile(std::move(values), fraction);
  const std::string text = mean_text(group);
  return text.substr(0, text.find(' '));
}

class MeansTable {
 public:
  explicit MeansTable(const MainEffects& effects) : effects_(effects) {
    for (std::size_t p = 0; p < effects.parameters.size(); ++p) {
      const std::size_t groups = effects.effects[p][0].groups.size();
      if (parameters_ > 0 && levels_ + groups > kMostRows) break;
      levels_ += groups;
      ++parameters_;
    }
  }

  /// With as many results as fit.
  [[nodiscard]] std::vector<std::string> lines(std::size_t width) const {
    std::vector<std::string> out;
    for (std::size_t results = 1; results <= effects_.results.size(); ++results) {
      std::vector<std::string> more = align_columns(rows(results));
      if (is_wider(more, width)) break;
      out = std::move(more);
    }
    const std::size_t left_out = effects_.parameters.size() - parameters_;
    if (left_out > 0) out.push_back(fmt::format("{} more parameters explain less", left_out));
    return out;
  }

 private:
  [[nodiscard]] std::vector<Row> rows(std::size_t results) const {
    std::vector<Row> out{{"mean ± SD", "", ""}, {"", "", "runs"}, {"all", "", std::to_string(effects_.runs.size())}};
    for (std::size_t r = 0; r < results; ++r) {
      const auto [upper, lower] = two_lines(effects_.results[r].name.title());
      out[0].push_back(upper);
      out[1].push_back(lower);
      out[2].push_back(mean_text(all_of(effects_.results[r])));
    }
    for (std::size_t p = 0; p < parameters_; ++p) add_parameter(p, results, out);
    return out;
  }
  void add_parameter(std::size_t p, std::size_t results, std::vector<Row>& out) const {
    const EffectParameter& parameter = effects_.parameters[p];
    for (std::size_t g = 0; g < effects_.effects[p][0].groups.size(); ++g) {
      const EffectGroup& first = effects_.effects[p][0].groups[g];
      Row row{g == 0 ? cut(parameter.name.title(), 28) : "", cut(range_or_level(parameter, first), 20),
              std::to_string(first.runs)};
      for (std::size_t r = 0; r < results; ++r) {
        const auto& groups = effects_.effects[p][r].groups;
        row.push_back(g < groups.size() && groups.size() == effects_.effects[p][0].groups.size() ? mean_text(groups[g])
                                                                                                 : "-");
      }
      out.push_back(std::move(row));
    }
  }
  const MainEffects& effects_;
  std::size_t parameters_ = 0, levels_ = 0;
};

/// Of distributions, what the means do not say: quantiles of each result over all runs, and the parameter that explains
/// most of it.
std::vector<std::string> band_lines(const MainEffects& effects) {
  std::vector<Row> rows{{"over all runs", "5 %", "50 %", "95 %", "explained most by"}};
  for (std::size_t r = 0; r < effects.results.size(); ++r) {
    const EffectResult& result = effects.results[r];
    std::size_t most = 0;
    for (std::size_t p = 1; p < effects.parameters.size(); ++p) {
      if (effects.effects[p][r].explained > effects.effects[most][r].explained) most = p;
    }
    const MainEffect& effect = effects.effects[most][r];
    rows.push_back(
        {cut(result.name.title(), 34), quantile_text(result, 0.05), quantile_text(result, 0.5),
         quantile_text(result, 0.95),
         fmt::format("{} ({:.0f} %)", cut(effects.parameters[most].name.title(), 28), 100 * effect.explained)});
  }
  return align_columns(rows);
}

}  // namespace

std::vector<std::string> study_table(const RunTable& table, const MainEffects& effects, std::size_t width) {
  const auto is_done = [](const CollectedRun& run) { return run.state == RunState::done; };
  if (std::ranges::none_of(table.runs, is_done)) return {};
  if (table.all <= kMostRunsInRows) return rows_of_runs(table, width);
  if (effects.empty()) return {};
  std::vector<std::string> out = MeansTable(effects).lines(width);
  if (std::ranges::any_of(effects.parameters, &EffectParameter::has_intervals)) {
    const std::vector<std::string> bands = band_lines(effects);
    out.emplace_back();
    out.insert(out.end(), bands.begin(), bands.end());
  }
  return out;
}

}  // namespace reamsim
