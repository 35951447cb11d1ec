// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/key_tree.h"

#include <array>
#include <map>
#include <numeric>
#include <ranges>
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

constexpr std::size_t kLongestKey = 60;  // beyond it no key is meant, and edit distances get slow

/// Parts that unit suffixes are made of, ours and those that people write by mistake.
constexpr std::array<std::string_view, 44> kUnitWords{
    "mm",  "cm", "m",   "um",  "nm",     "km",      "in",     "inch", "s",      "ms",      "us",
    "min", "h",  "sec", "rad", "deg",    "degrees", "rpm",    "rps",  "hz",     "khz",     "mhz",
    "n",   "kn", "mn",  "nmm", "newton", "hu",      "gray",   "g",    "kg",     "mg",      "cm3",
    "mm3", "m3", "j",   "mj",  "kj",     "px",      "pixels", "per",  "voxels", "seconds", "mpa"};

std::string display(const KeyNode& key) {
  const std::string_view unit = unit_of(key.info.name);
  return std::string(key.info.name) + (unit.empty() ? "" : " (" + std::string(unit) + ")");
}

/// Whether all parts of `suffix` ("_mm_min") are words of units.
bool is_unit_suffix(std::string_view suffix) {
  while (!suffix.empty()) {
    if (suffix[0] != '_') return false;
    suffix.remove_prefix(1);
    const std::string_view word = suffix.substr(0, suffix.find('_'));
    if (std::ranges::find(kUnitWords, word) == kUnitWords.end()) return false;
    suffix.remove_prefix(word.size());
  }
  return true;
}

/// Same name, other unit or none: "feed_mm_min" and "feed" for "feed_mm_s".
bool differs_in_unit_only(const KeyNode& key, std::string_view unknown) {
  const std::string_view stem = without_unit(key.info.name);
  return stem.size() < key.info.name.size() && unknown.starts_with(stem) && is_unit_suffix(unknown.substr(stem.size()));
}

/// Levenshtein's edit distance.
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

/// The element of `all` whose name is most like `unknown`, in any case; nullptr where none is alike.
template <class Range, class Name>
auto* nearest(const Range& all, const std::string& unknown, const Name& name) {
  const std::ranges::range_value_t<Range>* best = nullptr;
  std::size_t least = std::max<std::size_t>(1, unknown.size() / 3) + 1;
  for (const auto& candidate : all) {
    const std::size_t distance = edit_distance(lower_case(std::string(name(candidate))), lower_case(unknown));
    if (distance < least) best = &candidate;
    least = std::min(least, distance);
  }
  return best;
}

/// The first key of that name anywhere in the tree.
const KeyNode* elsewhere(const KeyNode& section, std::string_view name) {
  for (const auto& key : section.children) {
    if (key.info.name == name) return &key;
    if (const KeyNode* found = elsewhere(key, name)) return found;
  }
  return nullptr;
}

std::vector<std::string_view> names_of_keys(const KeyNode& section) {
  std::vector<std::string_view> out;
  for (const KeyNode& key : section.children) out.push_back(key.info.name);
  return out;
}

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
  const bool low = std::isfinite(range.min), high = std::isfinite(range.max);
  if (low && range.min == range.max) return number_text(range.min);
  if (low && high) return number_text(range.min) + " to " + number_text(range.max);
  if (low) return "at least " + number_text(range.min);
  return high ? "up to " + number_text(range.max) : "";
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
  const std::string text = !info.choices.empty()         ? join_or(info.choices)
                           : info.text == TextKind::word ? "a text"
                                                         : "a path";
  const std::map<KeyKind, std::string> kinds{
      {KeyKind::section, "a section of keys"},
      {KeyKind::list, "a list of sections"},
      {KeyKind::number, "a number" + tail},
      {KeyKind::integer, "a whole number" + tail},
      {KeyKind::flag, "true or false"},
      {KeyKind::text, text},
      {KeyKind::choices, "a list of one or more of " + join_or(info.choices)},
      {KeyKind::names, "a name or a whole number, or a list of them"},
      {KeyKind::vector, std::string("3 numbers [x, y, z]") + (info.nonzero ? ", not all zero" : "") + each + unit +
                            (info.point ? ", or {markups: FILE, point: LABEL}" : "")},
      {KeyKind::points, "a list of " + std::to_string(info.least_points) + " or more points [[x, y, z], ...]" +
                            (range.empty() ? "" : ", each number " + range) + unit +
                            (info.point ? ", or {markups: FILE}" : "")},
      {KeyKind::quaternion, "4 numbers [w, x, y, z] of length 1"}};
  return kinds.at(info.kind);
}

std::string suggest_key(const KeyNode& section, const std::string& unknown) {
  if (unknown.size() <= kLongestKey) {
    for (const auto& key : section.children) {
      if (differs_in_unit_only(key, unknown)) return "did you mean " + display(key) + "?";
    }
    if (const KeyNode* key = elsewhere(key_tree(), unknown)) return "did you mean " + key->path + "?";
    const auto name = [](const KeyNode& key) { return key.info.name; };
    if (const KeyNode* key = nearest(section.children, unknown, name)) return "did you mean " + display(*key) + "?";
  }
  return "expected one of " + join_or(names_of_keys(section));
}

std::string suggest_word(const std::vector<std::string_view>& words, const std::string& unknown) {
  if (unknown.size() <= kLongestKey) {
    if (const auto* word = nearest(words, unknown, std::identity())) return "did you mean " + std::string(*word) + "?";
  }
  return "expected " + join_or(words);
}

const KeyNode& find_key(const std::string& path, const SourceLocation& where) {
  const KeyNode* at = &key_tree();
  std::string so_far;
  bool in_list = false;
  for (const std::string& step : split(path, '.')) {
    const std::string name = so_far + (so_far.empty() ? "" : ".") + shown_key(step);
    if (at->info.kind == KeyKind::list && !in_list) {
      constexpr std::size_t kMostDigits = 6;  // of an index that a list may have
      if (step.size() > kMostDigits || !is_whole_number(step))
        throw InputError(where, name, "unknown key", "expected an index into the list " + so_far);
      in_list = true;
    } else {
      const bool has_keys = at->info.kind == KeyKind::section || in_list;
      if (!has_keys) throw InputError(where, name, "unknown key", so_far + " has no keys below it");
      const KeyNode* next = at->find(step);
      if (next == nullptr) throw InputError(where, name, "unknown key", suggest_key(*at, step));
      at = next;
      in_list = false;
    }
    so_far = name;
  }
  const bool is_list = at->info.kind == KeyKind::list;
  if (at->info.kind == KeyKind::section || is_list) {
    const std::vector<std::string_view> names = names_of_keys(*at);
    const std::string remedy = is_list && !in_list
                                   ? "name a key of an entry, as in " + so_far + ".0." + std::string(names[0])
                                   : "name one of its keys: " + join_or(names);
    throw InputError(where, so_far, is_list && !in_list ? "is a list" : "is a section", remedy);
  }
  return *at;
}

}  // namespace reamsim
