#include "sim/scenario/reader.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/scenario/key_tree.h"
#include "sim/scenario/paths.h"
#include "sim/scenario/show.h"

namespace reamsim {

void KeyLocations::set(const std::string& path, const SourceLocation& where, bool given) {
  places_[path] = {where, given};
}

SourceLocation KeyLocations::of(const std::string& path) const {
  const auto found = places_.find(path);
  return found == places_.end() ? SourceLocation{} : found->second.where;
}

bool KeyLocations::given(const std::string& path) const {
  const auto found = places_.find(path);
  return found != places_.end() && found->second.given;
}

ScenarioReader::ScenarioReader(YamlNodePtr document, std::string file, std::string folder)
    : file_(std::move(file)), folder_(std::move(folder)) {
  levels_.push_back({std::move(document), "", {file_, 0, 0}, {}});
}

std::string ScenarioReader::path_of(std::string_view name) const {
  const std::string& path = levels_.back().path;
  return path + (path.empty() ? "" : ".") + std::string(name);
}

void ScenarioReader::reject(std::string_view key, const YamlNode& node, const std::string& found,
                            const std::string& expected) const {
  throw InputError(node.mark.in(file_), path_of(key), found, "expected " + expected);
}

bool ScenarioReader::applies(const KeyInfo& info, std::string& why_not) const {
  const Level& level = levels_.back();
  if (!info.when.values.empty()) {
    const auto chosen = level.chosen.find(info.when.choice);
    const std::string value = chosen == level.chosen.end() ? "" : chosen->second;
    if (std::ranges::find(info.when.values, value) == info.when.values.end()) {
      why_not = std::string(info.when.choice) + " is " + value + "; expected it with " + std::string(info.when.choice) +
                ": " + join_or(info.when.values) + " only";
      return false;
    }
  }
  if (!info.unless.empty() && level.node && level.node->find(info.unless) != nullptr) {
    why_not = std::string(info.unless) + " is given; expected one or the other";
    return false;
  }
  return true;
}

YamlNodePtr ScenarioReader::take(const KeyInfo& info) {
  const Level& level = levels_.back();
  const YamlEntry* entry = level.node ? level.node->find(info.name) : nullptr;
  const std::string path = path_of(info.name);
  std::string why_not;
  const bool fits = applies(info, why_not);
  if (entry == nullptr) {
    locations_.set(path, level.where, false);
    if (info.required && fits) {
      const KeyNode::Kind kind = info.choices.empty() ? KeyNode::Kind::section : KeyNode::Kind::text;
      const std::string expected = info.choices.empty() ? std::string(info.doc) : expectation(info, kind);
      throw InputError(level.where, path, "missing", "expected this key: " + expected);
    }
    return nullptr;
  }
  const SourceLocation where = entry->mark.in(file_);
  locations_.set(path, where, true);
  if (!fits) throw InputError(where, path, "does not apply, because " + why_not, "");
  return entry->value;
}

double ScenarioReader::checked_number(const KeyInfo& info, const YamlNode& node, const std::string& expected) const {
  const bool plain = node.kind == YamlNode::Kind::scalar && !node.quoted;
  const std::optional<double> value = plain ? parse_number(node.text) : std::nullopt;
  if (!value) reject(info.name, node, "found " + shown(node), expected);
  if (!std::isfinite(*value)) reject(info.name, node, "found " + shown(node) + ", which is not finite", expected);
  if (!info.range.contains(*value)) reject(info.name, node, "found " + shown(node), expected);
  return *value + 0.0;  // never a negative zero
}

void ScenarioReader::number(const KeyInfo& info, double& value) {
  const YamlNodePtr node = take(info);
  if (node) value = checked_number(info, *node, expectation(info, KeyNode::Kind::number));
}

void ScenarioReader::integer(const KeyInfo& info, int& value) {
  const YamlNodePtr node = take(info);
  if (!node) return;
  const std::string expected = expectation(info, KeyNode::Kind::integer);
  const double number = checked_number(info, *node, expected);
  const bool digits_only = node->text.find_first_not_of("+-0123456789") == std::string::npos;
  if (!digits_only) reject(info.name, *node, "found " + shown(*node), expected);
  value = static_cast<int>(number);
}

void ScenarioReader::flag(const KeyInfo& info, bool& value) {
  const YamlNodePtr node = take(info);
  if (!node) return;
  const bool plain = node->kind == YamlNode::Kind::scalar && !node->quoted;
  if (!plain || (node->text != "true" && node->text != "false")) {
    reject(info.name, *node, "found " + shown(*node), expectation(info, KeyNode::Kind::flag));
  }
  value = node->text == "true";
}

std::string ScenarioReader::checked_text(const KeyInfo& info, const YamlNode& node) const {
  const std::string expected = expectation(info, KeyNode::Kind::text);
  if (node.kind != YamlNode::Kind::scalar) reject(info.name, node, "found " + shown(node), expected);
  const bool number = !info.number_too && parse_number(node.text);
  const bool other_type =
      !node.quoted && !node.mark.override_text && (number || node.text == "true" || node.text == "false");
  if (other_type)
    reject(info.name, node, "found " + shown(node), expected + " (in quotes where it looks like a number)");
  if (node.text.empty() && info.text != TextKind::output_folder) reject(info.name, node, "found \"\"", expected);
  const auto is_control = [](char c) { return (c >= 0 && c < 0x20) || c == 0x7f; };
  if (std::ranges::any_of(node.text, is_control)) {
    reject(info.name, node, "found " + shown(node), expected + " without line breaks or control characters");
  }
  return node.text;
}

void ScenarioReader::text(const KeyInfo& info, std::string& value) {
  if (const YamlNodePtr node = take(info)) {
    const std::string text = checked_text(info, *node);
    const bool known = info.choices.empty() || std::ranges::find(info.choices, text) != info.choices.end();
    if (!known) reject(info.name, *node, "found " + shown(*node), expectation(info, KeyNode::Kind::text));
    const SourceLocation where = node->mark.in(file_);
    value = info.text == TextKind::word ? text : resolve_path(text, info.text, folder_, where, path_of(info.name));
  }
  if (!info.choices.empty()) levels_.back().chosen[info.name] = value;
}

void ScenarioReader::choices(const KeyInfo& info, std::vector<std::string>& values) {
  const YamlNodePtr node = take(info);
  if (!node) return;
  const std::string expected = expectation(info, KeyNode::Kind::choices);
  if (node->kind != YamlNode::Kind::sequence || node->items.empty()) {
    reject(info.name, *node, "found " + shown(*node), expected);
  }
  values.clear();
  for (const auto& item : node->items) {
    const bool known =
        item->kind == YamlNode::Kind::scalar && std::ranges::find(info.choices, item->text) != info.choices.end();
    if (!known) reject(info.name, *item, "found " + shown(*item), expected);
    if (std::ranges::find(values, item->text) != values.end()) {
      reject(info.name, *item, "found " + item->text + " twice", expected + ", each once");
    }
    values.push_back(item->text);
  }
}

void ScenarioReader::names(const KeyInfo& info, std::vector<std::string>& values) {
  const YamlNodePtr node = take(info);
  if (!node) return;
  const std::string expected = expectation(info, KeyNode::Kind::names);
  const auto add = [&](const YamlNode& item) {
    const bool plain_number = item.kind == YamlNode::Kind::scalar && !item.quoted && parse_number(item.text);
    const bool whole = item.text.find_first_not_of("0123456789") == std::string::npos;
    if (plain_number && !whole) reject(info.name, item, "found " + shown(item), expected);
    KeyInfo name = info;
    name.number_too = true;
    values.push_back(checked_text(name, item));
  };
  values.clear();
  if (node->kind != YamlNode::Kind::sequence) return add(*node);
  if (node->items.empty()) reject(info.name, *node, "found " + shown(*node), expected);
  for (const auto& item : node->items) add(*item);
}

std::vector<double> ScenarioReader::components(const KeyInfo& info, const YamlNode& node, std::size_t count,
                                               const std::string& expected) const {
  if (node.kind != YamlNode::Kind::sequence || node.items.size() != count) {
    reject(info.name, node, "found " + shown(node), expected);
  }
  std::vector<double> out;
  for (const auto& item : node.items) out.push_back(checked_number(info, *item, expected));
  return out;
}

void ScenarioReader::vector(const KeyInfo& info, Vec3& value) {
  std::optional<Vec3> given;
  optional_vector(info, given);
  if (given) value = *given;
}

void ScenarioReader::optional_vector(const KeyInfo& info, std::optional<Vec3>& value) {
  const YamlNodePtr node = take(info);
  if (!node) return;
  const std::string expected = expectation(info, KeyNode::Kind::vector);
  const std::vector<double> numbers = components(info, *node, 3, expected);
  value = Vec3(numbers[0], numbers[1], numbers[2]);
  // Shorter than this, squared lengths lose their digits.
  constexpr double kShortest = 1e-9;
  if (info.nonzero && value->norm() < kShortest) {
    reject(info.name, *node, "found a direction of length 0", expected);
  }
}

void ScenarioReader::points(const KeyInfo& info, std::vector<Vec3>& values) {
  const YamlNodePtr node = take(info);
  if (!node) return;
  const std::string expected = expectation(info, KeyNode::Kind::points);
  if (node->kind != YamlNode::Kind::sequence || std::ssize(node->items) < info.least_points) {
    reject(info.name, *node, "found " + shown(*node), expected);
  }
  values.clear();
  for (const auto& item : node->items) {
    const std::vector<double> numbers = components(info, *item, 3, expected);
    values.emplace_back(numbers[0], numbers[1], numbers[2]);
  }
}

void ScenarioReader::optional_quaternion(const KeyInfo& info, std::optional<Quat>& value) {
  const YamlNodePtr node = take(info);
  if (!node) return;
  const std::string expected = expectation(info, KeyNode::Kind::quaternion);
  const std::vector<double> n = components(info, *node, 4, expected);
  Quat q(n[0], n[1], n[2], n[3]);
  constexpr double kLengthTolerance = 1e-2;  // of a quaternion written with few digits
  if (std::abs(q.norm() - 1) > kLengthTolerance) {
    reject(info.name, *node, "found 4 numbers of length " + number_text(q.norm()), expected);
  }
  // A quaternion that is as unit as doubles allow stays as it is, so that to_yaml() and back changes nothing.
  constexpr double kRounding = 1e-14;
  if (std::abs(q.norm() - 1) > kRounding) q.normalize();
  value = q;
}

void ScenarioReader::group(const KeyGroup& group) {
  const Level& level = levels_.back();
  std::vector<std::string_view> found;
  SourceLocation second;
  for (const auto name : group.names) {
    const YamlEntry* entry = level.node ? level.node->find(name) : nullptr;
    if (entry == nullptr) continue;
    found.push_back(name);
    second = entry->mark.in(file_);
  }
  if (found.size() > 1) {
    throw InputError(second, path_of(found.back()), "given together with " + std::string(found.front()),
                     "expected one of " + join_or(group.names));
  }
  if (found.empty() && group.one_needed) {
    const std::string& path = level.path;
    throw InputError(level.where, path, "none of its keys " + join_or(group.names) + " is given",
                     "expected exactly one of them");
  }
}

void ScenarioReader::push(const KeyInfo& info, YamlNodePtr node) {
  const std::string path = path_of(info.name);
  const SourceLocation where = locations_.of(path);
  levels_.push_back({std::move(node), path, where, {}});
}

bool ScenarioReader::begin_section(const KeyInfo& info) {
  std::string why_not;
  const YamlNodePtr node = take(info);
  if (!applies(info, why_not)) return false;
  if (node && node->kind != YamlNode::Kind::map) {
    reject(info.name, *node, "found " + shown(*node), expectation(info, KeyNode::Kind::section));
  }
  push(info, node);
  return true;
}

bool ScenarioReader::begin_optional_section(const KeyInfo& info, bool) {
  const Level& level = levels_.back();
  const bool given = level.node && level.node->find(info.name) != nullptr;
  if (!given) {
    take(info);
    return false;
  }
  return begin_section(info);
}

void ScenarioReader::end_section() {
  levels_.pop_back();
}

std::size_t ScenarioReader::begin_list(const KeyInfo& info, std::size_t) {
  const YamlNodePtr node = take(info);
  if (node && node->kind != YamlNode::Kind::sequence) {
    reject(info.name, *node, "found " + shown(*node), expectation(info, KeyNode::Kind::list));
  }
  push(info, node);
  return node ? node->items.size() : 0;
}

void ScenarioReader::begin_item(std::size_t index) {
  const YamlNodePtr item = levels_.back().node->items[index];
  const std::string path = levels_.back().path + "." + std::to_string(index);
  const SourceLocation where = item->mark.in(file_);
  if (item->kind != YamlNode::Kind::map) {
    throw InputError(where, path, "found " + shown(*item), "expected a section of keys");
  }
  locations_.set(path, where, true);
  levels_.push_back({item, path, where, {}});
}

void ScenarioReader::end_list() {
  levels_.pop_back();
}

}  // namespace reamsim
