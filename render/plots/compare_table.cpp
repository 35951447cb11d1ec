// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/plots/plots.h"

#include <fmt/core.h>
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <set>
#include <sstream>

#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/record/result_json.h"
#include "sim/scenario/show.h"

namespace reamsim {
namespace {

/// Most characters of a header, a cell and a label; longer ones are listed below the table.
constexpr std::size_t kMostInCell = 24;

using Rows = std::vector<std::vector<std::string>>;

/// The last `parts` parts of a dotted key.
std::string last_parts(const std::string& key, std::size_t parts) {
  std::size_t at = key.size();
  while (parts-- > 0 && at != std::string::npos && at > 0) at = key.rfind('.', at - 1);
  return at == std::string::npos || at == 0 ? key : key.substr(at + 1);
}

/// The fewest last parts of each key that tell it from the others.
std::vector<std::string> short_names(const std::vector<RunColumn>& columns) {
  std::vector<std::string> names;
  for (const RunColumn& column : columns) {
    std::size_t parts = 1;
    const auto is_shared = [&](const RunColumn& other) {
      return &other != &column && last_parts(other.key, parts) == last_parts(column.key, parts);
    };
    while (std::ranges::any_of(columns, is_shared) && last_parts(column.key, parts) != column.key) ++parts;
    names.push_back(last_parts(column.key, parts));
  }
  return names;
}

/// Long texts and what stands for them.
class Legend {
 public:
  /// `text`, or its number where it is long.
  std::string of(const std::string& text) {
    if (text_width(text) <= kMostInCell) return text;
    const auto place = static_cast<std::size_t>(std::ranges::find(texts_, text) - texts_.begin());
    if (place == texts_.size()) texts_.push_back(text);
    return mark(place);
  }
  /// A line per text, wrapped.
  [[nodiscard]] std::vector<std::string> lines(std::size_t width) const {
    std::vector<std::string> out;
    for (std::size_t i = 0; i < texts_.size(); ++i) wrap(mark(i) + " " + texts_[i], width, out);
    return out;
  }

 private:
  static std::string mark(std::size_t number) { return "[" + std::to_string(number + 1) + "]"; }

  static void wrap(const std::string& text, std::size_t width, std::vector<std::string>& out) {
    std::string line;
    for (const std::string& character : characters_of(text)) {
      if (text_width(line) == width) {
        out.push_back(line);
        line = "  ";
      }
      line += character;
    }
    out.push_back(line);
  }

  std::vector<std::string> texts_;
};

std::size_t widest(const std::vector<std::string>& lines) {
  return text_width(std::ranges::max(lines, {}, text_width));
}

/// Appends lines, after an empty one where there are some already.
void add_block(const std::vector<std::string>& lines, std::vector<std::string>& out) {
  if (!out.empty()) out.emplace_back();
  out.insert(out.end(), lines.begin(), lines.end());
}

std::vector<std::string> row_per_run(const std::vector<std::string>& labels, const std::vector<RunColumn>& columns,
                                     std::size_t width) {
  Legend legend;
  const std::vector<std::string> names = short_names(columns);
  std::vector<std::string> heads{"run"};
  const std::size_t digits = std::to_string(labels.size()).size();
  for (std::size_t i = 0; i < labels.size(); ++i) {
    heads.push_back(fmt::format("{:{}} {}", i + 1, digits, legend.of(labels[i])));
  }
  const std::size_t label_width = widest(heads);
  for (std::string& head : heads) head += std::string(label_width - text_width(head), ' ');
  std::vector<std::string> out;
  Rows block;
  for (const std::string& head : heads) block.push_back({head});
  for (std::size_t c = 0; c < columns.size(); ++c) {
    Rows longer = block;
    longer[0].push_back(legend.of(names[c]));
    for (std::size_t i = 0; i < labels.size(); ++i) longer[i + 1].push_back(legend.of(columns[c].cells[i]));
    if (widest(align_columns(longer)) > width && block[0].size() > 1) {
      add_block(align_columns(block), out);
      for (std::size_t i = 0; i < block.size(); ++i) block[i] = {heads[i], longer[i].back()};
    } else {
      block = longer;
    }
  }
  add_block(align_columns(block), out);
  const std::vector<std::string> listed = legend.lines(width);
  if (!listed.empty()) add_block(listed, out);
  return out;
}

using Json = nlohmann::ordered_json;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Ends the name of a parameter: the contents of an input file.
constexpr std::string_view kSumOfInput = " (contents)";

/// Adds the beginnings of the checksums of input files, comments of scenario.yaml: "# sha256 SUM  KEY  PATH".
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

std::vector<std::string> characters_of(const std::string& text) {
  std::vector<std::string> out;
  for (const char c : text) {
    if ((static_cast<unsigned char>(c) & 0xc0) != 0x80 || out.empty()) out.emplace_back();
    out.back() += c;
  }
  return out;
}

std::vector<std::string> run_table(const std::vector<std::string>& labels, const std::vector<RunColumn>& columns,
                                   std::size_t width) {
  Rows rows;  // one per column
  const auto add = [&](const std::string& key, const std::vector<std::string>& cells) {
    rows.push_back({key});
    rows.back().insert(rows.back().end(), cells.begin(), cells.end());
  };
  add("run", labels);
  for (const RunColumn& column : columns) add(column.key, column.cells);
  std::vector<std::string> lines = align_columns(rows);
  return widest(lines) <= width ? lines : row_per_run(labels, columns, width);
}

double ComparedMetric::relative(std::size_t i) const {
  return values[0] == 0 ? kNone : difference(i) / std::abs(values[0]);
}

std::vector<ComparedMetric> compare_summaries(const std::vector<ComparedRun>& runs) {
  std::vector<ComparedMetric> out;
  std::map<std::string, std::size_t> places;
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const std::string path = runs[i].dir + "/summary.json";
    const Json summary = parse_result_json(read_file(path, "expected the results folder of a finished run"));
    if (!summary.is_object() || !summary.contains("removed_mm3") || !summary.contains("forces"))
      refuse_file(path, "damaged, or not the summary of a run", "expected a file written by `reamsim run`");
    for_each_number(summary, "", "[", "]", [&](const std::string& key, double value) {
      const auto [found, is_new] = places.try_emplace(key, out.size());
      if (is_new) out.push_back({key, std::vector<double>(runs.size(), kNone)});
      out[found->second].values[i] = value;
    });
  }
  return out;
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
    for (const std::string& value : parameter.values) {
      const double number = parse_number(value).value_or(kNone);
      parameter.numbers.push_back(std::isfinite(number) ? number : kNone);
    }
    parameter.shown = shown_values(parameter.values);
  }
  return all;
}

}  // namespace reamsim
