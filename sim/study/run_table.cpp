// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/run_table.h"

#include <fmt/core.h>
#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <map>
#include <random>

#include "sim/base/text.h"
#include "sim/scenario/key_tree.h"
#include "sim/scenario/show.h"

namespace reamsim {

const char* name_of(RunState state) {
  static const char* const names[] = {"missing", "interrupted", "failed", "done"};  // in the order of RunState
  return names[static_cast<std::size_t>(state)];
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

namespace {

std::string words_of(std::string name) {
  std::ranges::replace(name, '_', ' ');
  return name;
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

/// One word, or a part of a tilt or shift, says too little without what is before it.
bool needs_parent(const std::string& name) {
  return name.find('_') == std::string::npos || name.starts_with("tilt_") || name.starts_with("shift_");
}

/// The name of a column by the last parts of its key: those that it needs, and `more`.
ColumnName made_name(const std::string& key, std::size_t more) {
  const std::vector<std::string> parts = split(key, '.');
  std::size_t at = parts.size() - 1;
  std::string index;
  while (at > 0 && is_whole_number(parts[at])) index = " " + parts[at--] + index;
  const auto [name, unit] = name_and_unit(parts[at]);
  std::string text = words_of(name) + index;
  if (needs_parent(name)) ++more;
  while (at > 0 && (more > 0 || is_whole_number(parts[at]))) {
    if (!is_whole_number(parts[--at])) --more;
    text = words_of(name_and_unit(parts[at]).first) + " " + text;
  }
  return {key, text, unit};
}

}  // namespace

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
    if (found != fixed.end()) {
      out[i] = *found;
    } else {
      unnamed.push_back(i);
    }
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
  static constexpr std::array kInputs{".stl", ".obj", ".ply", ".nrrd", ".nii", ".mha", ".mhd", ".vdb", ".csv"};
  const std::filesystem::path path(cell);
  const bool is_file = std::ranges::find(kInputs, path.extension().string()) != kInputs.end();
  if (!is_file && cell.find('/') == std::string::npos) return cell;
  const std::string stem = path.stem().string();
  return stem.empty() ? cell : stem;
}

}  // namespace reamsim
