// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/key_tree.h"

#include <algorithm>
#include <array>
#include <utility>

#include "sim/base/text.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

/// Units as they end a name, longest first.
constexpr std::array<std::pair<std::string_view, std::string_view>, 15> kUnits{{
    {"_g_cm3_per_hu", "g/cm³ per HU"},
    {"_g_cm3_per_s", "g/cm³ per s"},
    {"_n_s_mm", "N·s/mm"},
    {"_j_mm3", "J/mm³"},
    {"_g_cm3", "g/cm³"},
    {"_mm_s", "mm/s"},
    {"_n_mm", "N/mm"},
    {"_rpm", "rpm"},
    {"_deg", "°"},
    {"_mm", "mm"},
    {"_hu", "HU"},
    {"_kg", "kg"},
    {"_hz", "Hz"},
    {"_px", "px"},
    {"_s", "s"},
}};
constexpr std::pair<std::string_view, std::string_view> kNewton{"_n", "N"};

std::pair<std::string_view, std::string_view> unit_suffix(std::string_view name) {
  for (const auto& unit : kUnits) {
    if (name.ends_with(unit.first)) return unit;
  }
  return name.ends_with(kNewton.first) ? kNewton : std::pair<std::string_view, std::string_view>{};
}

std::string vector_json(const Vec3& v) {
  return "[" + number_text(v.x()) + ", " + number_text(v.y()) + ", " + number_text(v.z()) + "]";
}

/// Lists every key of a default scenario.
class TreeBuilder : public KeyVisitor {
 public:
  explicit TreeBuilder(KeyNode& root) : stack_{&root} {}

  void number(const KeyInfo& info, double& value) override { leaf(info, KeyNode::Kind::number, number_text(value)); }
  void integer(const KeyInfo& info, int& value) override { leaf(info, KeyNode::Kind::integer, std::to_string(value)); }
  void flag(const KeyInfo& info, bool& value) override { leaf(info, KeyNode::Kind::flag, value ? "true" : "false"); }
  void text(const KeyInfo& info, std::string& value) override {
    const bool has_default = !value.empty() || info.text == TextKind::output_folder;
    leaf(info, KeyNode::Kind::text, has_default ? json_string(value) : "");
  }
  void choices(const KeyInfo& info, std::vector<std::string>& values) override {
    std::string json;
    for (const auto& value : values) json += (json.empty() ? "" : ", ") + json_string(value);
    leaf(info, KeyNode::Kind::choices, "[" + json + "]");
  }
  void names(const KeyInfo& info, std::vector<std::string>& values) override {
    std::string json;
    for (const std::string& value : values)
      json += (json.empty() ? "" : ", ") + (is_whole_number(value) ? value : json_string(value));
    leaf(info, KeyNode::Kind::names, values.size() == 1 ? json : "[" + json + "]");
  }
  void vector(const KeyInfo& info, Vec3& value) override { leaf(info, KeyNode::Kind::vector, vector_json(value)); }
  void optional_vector(const KeyInfo& info, std::optional<Vec3>&) override { leaf(info, KeyNode::Kind::vector, ""); }
  void points(const KeyInfo& info, std::vector<Vec3>&) override { leaf(info, KeyNode::Kind::points, ""); }
  void optional_quaternion(const KeyInfo& info, std::optional<Quat>&) override {
    leaf(info, KeyNode::Kind::quaternion, "");
  }
  void group(const KeyGroup& group) override { stack_.back()->groups.push_back(group); }

 protected:
  bool begin_section(const KeyInfo& info) override {
    begin(info, KeyNode::Kind::section, "");
    return true;
  }
  bool begin_optional_section(const KeyInfo& info, bool) override { return begin_section(info); }
  void end_section() override { stack_.pop_back(); }
  std::size_t begin_list(const KeyInfo& info, std::size_t) override {
    begin(info, KeyNode::Kind::list, "[]");
    return 1;
  }
  void begin_item(std::size_t) override { stack_.push_back(stack_.back()); }
  void end_list() override { stack_.pop_back(); }

 private:
  KeyNode& leaf(const KeyInfo& info, KeyNode::Kind kind, const std::string& default_json) {
    KeyNode& parent = *stack_.back();
    KeyNode node;
    node.kind = kind;
    node.info = info;
    node.path = parent.path + (parent.kind == KeyNode::Kind::list ? "[]" : "") + (parent.path.empty() ? "" : ".");
    node.path += info.name;
    node.default_json = info.required ? "" : default_json;
    parent.children.push_back(std::move(node));
    return parent.children.back();
  }
  void begin(const KeyInfo& info, KeyNode::Kind kind, const std::string& default_json) {
    stack_.push_back(&leaf(info, kind, default_json));
  }

  std::vector<KeyNode*> stack_;
};

}  // namespace

const KeyNode* KeyNode::find(std::string_view name) const {
  const auto found = std::ranges::find_if(children, [&](const KeyNode& child) { return child.info.name == name; });
  return found == children.end() ? nullptr : &*found;
}

const KeyNode& key_tree() {
  static const KeyNode kTree = [] {
    KeyNode root;
    TreeBuilder builder(root);
    Scenario defaults;
    describe_scenario(builder, defaults);
    return root;
  }();
  return kTree;
}

std::string_view unit_of(std::string_view name) {
  return unit_suffix(name).second;
}

std::string_view without_unit(std::string_view name) {
  name.remove_suffix(unit_suffix(name).first.size());
  return name;
}

std::string range_text(const Range& range) {
  const bool low = std::isfinite(range.min);
  const bool high = std::isfinite(range.max);
  if (!low && !high) return "";
  if (low && high && range.min == range.max) return number_text(range.min);
  if (low && high) return number_text(range.min) + " to " + number_text(range.max);
  return low ? "at least " + number_text(range.min) : "up to " + number_text(range.max);
}

std::string join_or(const std::vector<std::string_view>& words) {
  std::string out;
  for (std::size_t i = 0; i < words.size(); ++i) {
    if (i > 0) out += i + 1 == words.size() ? " or " : ", ";
    out += words[i];
  }
  return out;
}

std::string expectation(const KeyInfo& info, KeyNode::Kind kind) {
  const std::string range = range_text(info.range);
  const std::string_view unit = unit_of(info.name);
  const std::string tail = (range.empty() ? "" : ", " + range) + (unit.empty() ? "" : " (" + std::string(unit) + ")");
  switch (kind) {
    case KeyNode::Kind::section:
      return "a section of keys";
    case KeyNode::Kind::list:
      return "a list of sections";
    case KeyNode::Kind::number:
      return "a number" + tail;
    case KeyNode::Kind::integer:
      return "a whole number" + tail;
    case KeyNode::Kind::flag:
      return "true or false";
    case KeyNode::Kind::choices:
      return "a list of one or more of " + join_or(info.choices);
    case KeyNode::Kind::names:
      return "a name or a whole number, or a list of them";
    case KeyNode::Kind::vector:
      if (info.nonzero) return "3 numbers [x, y, z], not all zero, each " + range;
      return "3 numbers [x, y, z]" + (range.empty() ? "" : ", each " + range) +
             (unit.empty() ? "" : " (" + std::string(unit) + ")") +
             (info.point ? ", or {markups: FILE, point: LABEL}" : "");
    case KeyNode::Kind::points:
      return "a list of " + std::to_string(info.least_points) + " or more points [[x, y, z], ...]" +
             (range.empty() ? "" : ", each number " + range) + (unit.empty() ? "" : " (" + std::string(unit) + ")") +
             (info.point ? ", or {markups: FILE}" : "");
    case KeyNode::Kind::quaternion:
      return "4 numbers [w, x, y, z] of length 1";
    case KeyNode::Kind::text:
      break;
  }
  if (!info.choices.empty()) return join_or(info.choices);
  return info.text == TextKind::word ? "a text" : "a path";
}

}  // namespace reamsim
