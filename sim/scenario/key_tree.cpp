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
constexpr std::array<std::pair<std::string_view, std::string_view>, 16> kUnits{{
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
    {"_n", "N"},
}};

std::pair<std::string_view, std::string_view> unit_suffix(std::string_view name) {
  for (const auto& unit : kUnits) {
    if (name.ends_with(unit.first)) return unit;
  }
  return {};
}

/// Lists every key of a default scenario.
class TreeBuilder : public KeyVisitor {
 public:
  explicit TreeBuilder(KeyNode& root) : stack_{&root} {}

  void group(const KeyGroup& group) override { stack_.back()->groups.push_back(group); }

 protected:
  void visit(const KeyInfo& info, const ValuePointer& value) override {
    add(info, value_text(info, value, json_string));
  }
  bool begin_section(const KeyInfo& info) override {
    stack_.push_back(&add(info, ""));
    return true;
  }
  bool begin_optional_section(const KeyInfo& info, bool) override { return begin_section(info); }
  std::size_t begin_list(const KeyInfo& info, std::size_t) override {
    stack_.push_back(&add(info, "[]"));
    return 1;
  }
  void begin_item(std::size_t) override { stack_.push_back(stack_.back()); }
  void end() override { stack_.pop_back(); }

 private:
  KeyNode& add(const KeyInfo& info, const std::string& default_json) {
    KeyNode& parent = *stack_.back();
    const std::string item = parent.info.kind == KeyKind::list ? "[]" : "";
    parent.children.push_back({.info = info,
                               .path = parent.path + item + (parent.path.empty() ? "" : ".") + std::string(info.name),
                               .default_json = info.required ? "" : default_json,
                               .children = {},
                               .groups = {}});
    return parent.children.back();
  }

  std::vector<KeyNode*> stack_;
};

/// value_text() by the type of the value.
struct ValueText {
  const KeyInfo& info;
  const std::function<std::string(const std::string&)>& text_of;

  std::string operator()(const double* value) const { return number_text(*value); }
  std::string operator()(const int* value) const { return std::to_string(*value); }
  std::string operator()(const bool* value) const { return *value ? "true" : "false"; }
  std::string operator()(const std::string* value) const {
    return value->empty() && info.text != TextKind::output_folder ? "" : scalar(*value);
  }
  std::string operator()(const std::vector<std::string>* values) const {
    if (info.kind == KeyKind::names && values->size() == 1) return scalar(values->front());
    return list(*values, [this](const std::string& value) { return scalar(value); });
  }
  std::string operator()(const std::optional<Vec3>* value) const { return *value ? vector_text(**value) : ""; }
  std::string operator()(const std::vector<Vec3>* values) const {
    return values->empty() ? "" : list(*values, vector_text);
  }
  std::string operator()(const std::optional<Quat>* value) const {
    if (!*value) return "";
    const Quat& q = **value;
    return list(std::array{q.w(), q.x(), q.y(), q.z()}, number_text);
  }

  /// A name that is a whole number stays one.
  [[nodiscard]] std::string scalar(const std::string& value) const {
    const bool may_be_number = info.number_too || info.kind == KeyKind::names;
    return may_be_number && is_whole_number(value) ? value : text_of(value);
  }
  template <class Values, class Text>
  static std::string list(const Values& values, const Text& text) {
    std::string out;
    for (const auto& value : values) out += (out.empty() ? "" : ", ") + text(value);
    return "[" + out + "]";
  }
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

std::string value_text(const KeyInfo& info, const ValuePointer& value,
                       const std::function<std::string(const std::string&)>& text_of) {
  return std::visit(ValueText{info, text_of}, value);
}

std::string expectation(const KeyInfo& info) {
  const std::string range = range_text(info.range);
  const std::string each = range.empty() ? "" : ", each " + range;
  const std::string_view unit_name = unit_of(info.name);
  const std::string unit = unit_name.empty() ? "" : " (" + std::string(unit_name) + ")";
  const std::string tail = (range.empty() ? "" : ", " + range) + unit;
  switch (info.kind) {
    case KeyKind::section:
      return "a section of keys";
    case KeyKind::list:
      return "a list of sections";
    case KeyKind::number:
      return "a number" + tail;
    case KeyKind::integer:
      return "a whole number" + tail;
    case KeyKind::flag:
      return "true or false";
    case KeyKind::choices:
      return "a list of one or more of " + join_or(info.choices);
    case KeyKind::names:
      return "a name or a whole number, or a list of them";
    case KeyKind::vector:
      return std::string("3 numbers [x, y, z]") + (info.nonzero ? ", not all zero" : "") + each + unit +
             (info.point ? ", or {markups: FILE, point: LABEL}" : "");
    case KeyKind::points:
      return "a list of " + std::to_string(info.least_points) + " or more points [[x, y, z], ...]" +
             (range.empty() ? "" : ", each number " + range) + unit + (info.point ? ", or {markups: FILE}" : "");
    case KeyKind::quaternion:
      return "4 numbers [w, x, y, z] of length 1";
    case KeyKind::text:
      break;
  }
  if (!info.choices.empty()) return join_or(info.choices);
  return info.text == TextKind::word ? "a text" : "a path";
}

}  // namespace reamsim
