#include "sim/study/column_names.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <map>

#include "sim/scenario/key_tree.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

std::vector<std::string> parts_of(const std::string& key) {
  std::vector<std::string> out(1);
  for (const char c : key) {
    if (c == '.') {
      out.emplace_back();
    } else {
      out.back() += c;
    }
  }
  return out;
}

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

/// One word, or the parts of a tilt or shift, say too little without the part before them.
bool needs_parent(const std::string& name) {
  return name.find('_') == std::string::npos || name.starts_with("tilt_") || name.starts_with("shift_");
}

ColumnName made_name(const std::string& key) {
  const std::vector<std::string> parts = parts_of(key);
  const auto [name, unit] = name_and_unit(parts.back());
  std::string text = words_of(name);
  if (needs_parent(name) && parts.size() > 1) text = words_of(parts[parts.size() - 2]) + " " + text;
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
      {"metrics.planning.planned.version_deg", "version, implant", "°"},
      {"metrics.planning.planned.inclination_deg", "inclination, implant", "°"},
      {"metrics.planning.medialization_mm", "medialization by the implant", "mm"},
      {"metrics.seating.seated_percent", "backside seated", "%"},
      {"metrics.planning.vault.left_percent", "vault bone left", "%"}};
  return results;
}

std::vector<ColumnName> column_names(const std::vector<std::string>& keys) {
  const auto& fixed = headline_results();
  std::vector<ColumnName> out;
  std::map<std::string, int> uses;
  for (const std::string& key : keys) {
    const auto found = std::ranges::find(fixed, key, &ColumnName::key);
    out.push_back(found == fixed.end() ? made_name(key) : *found);
    ++uses[out.back().title()];
  }
  for (ColumnName& name : out) {
    if (uses[name.title()] == 1) continue;
    name.text = name.key;
    name.unit = "";
  }
  return out;
}

std::string shown_cell(const std::string& cell) {
  if (cell.empty()) return "as in the base";
  if (const auto number = parse_number(cell)) return fmt::format("{:.4g}", *number);
  if (cell.find('/') == std::string::npos) return cell;
  const std::string stem = std::filesystem::path(cell).stem().string();
  return stem.empty() ? cell : stem;
}

}  // namespace reamsim
