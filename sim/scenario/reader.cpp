// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/reader.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/base/text.h"
#include "sim/scenario/key_tree.h"
#include "sim/scenario/paths.h"
#include "sim/scenario/show.h"

namespace reamsim {

ScenarioReader::ScenarioReader(YamlNodePtr document, std::string file, std::string folder, MistakeList& mistakes)
    : file_(std::move(file)), folder_(std::move(folder)), markups_(file_, folder_), mistakes_(mistakes) {
  Level top;
  top.node = std::move(document);
  top.where = {file_, 0, 0};
  top.has_unknown = mistakes.has_key_in("");
  levels_.push_back(std::move(top));
}

std::string ScenarioReader::path_of(std::string_view name) const {
  const std::string& path = levels_.back().path;
  return path + (path.empty() ? "" : ".") + std::string(name);
}

void ScenarioReader::reject(std::string_view key, const YamlNode& node, const std::string& found,
                            const std::string& expected) const {
  throw InputError(node.mark.in(file_), path_of(key), found, "expected " + expected);
}

ScenarioReader::Applies ScenarioReader::applies(const KeyInfo& info, std::string& why_not) const {
  const Level& level = levels_.back();
  if (!info.when.values.empty()) {
    if (level.unknown_choices.contains(info.when.choice)) return Applies::unknown;
    const auto chosen = level.chosen.find(info.when.choice);
    const std::string value = chosen == level.chosen.end() ? "" : chosen->second;
    if (std::ranges::find(info.when.values, value) == info.when.values.end()) {
      why_not = std::string(info.when.choice) + " is " + value + "; expected it with " + std::string(info.when.choice) +
                ": " + join_or(info.when.values) + " only";
      return Applies::no;
    }
  }
  if (!info.unless.empty() && level.node && level.node->find(info.unless) != nullptr) {
    why_not = std::string(info.unless) + " is given; expected one or the other";
    return Applies::no;
  }
  return Applies::yes;
}

void ScenarioReader::take_missing(const KeyInfo& info) {
  Level& level = levels_.back();
  const KeyNode::Kind kind = info.choices.empty() ? KeyNode::Kind::section : KeyNode::Kind::text;
  const std::string expected = info.choices.empty() ? std::string(info.doc) : expectation(info, kind);
  const InputError error(level.where, path_of(info.name), "missing", "expected this key: " + expected);
  if (!info.choices.empty()) level.unknown_choices.insert(info.name);
  if (level.has_unknown) return;
  if (info.when.values.empty()) throw error;
  level.missing.push_back({info.when.choice, error});
}

YamlNodePtr ScenarioReader::take(const KeyInfo& info) {
  Level& level = levels_.back();
  const YamlEntry* entry = level.node ? level.node->find(info.name) : nullptr;
  const std::string path = path_of(info.name);
  const SourceLocation where = entry == nullptr ? level.where : entry->mark.in(file_);
  locations_.set(path, where, entry != nullptr);
  std::string why_not;
  const Applies fits = applies(info, why_not);
  if (level.skipped || fits == Applies::unknown) return nullptr;
  if (entry == nullptr) {
    if (level.has_unknown) mistakes_.doubt(path);
    if (info.required && fits == Applies::yes) take_missing(info);
    return nullptr;
  }
  if (fits == Applies::yes) return entry->value;
  if (!info.when.values.empty()) level.contradicted.insert(info.when.choice);
  throw InputError(where, path, "does not apply: " + why_not, "");
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
  mistakes_.attempt([&] {
    const YamlNodePtr node = take(info);
    if (node) value = checked_number(info, *node, expectation(info, KeyNode::Kind::number));
  });
}

void ScenarioReader::integer(const KeyInfo& info, int& value) {
  mistakes_.attempt([&] {
    const YamlNodePtr node = take(info);
    if (!node) return;
    const std::string expected = expectation(info, KeyNode::Kind::integer);
    const double number = checked_number(info, *node, expected);
    const bool digits_only = node->text.find_first_not_of("+-0123456789") == std::string::npos;
    if (!digits_only) reject(info.name, *node, "found " + shown(*node), expected);
    value = static_cast<int>(number);
  });
}

void ScenarioReader::flag(const KeyInfo& info, bool& value) {
  mistakes_.attempt([&] {
    const YamlNodePtr node = take(info);
    if (!node) return;
    const bool plain = node->kind == YamlNode::Kind::scalar && !node->quoted;
    if (!plain || (node->text != "true" && node->text != "false")) {
      reject(info.name, *node, "found " + shown(*node), expectation(info, KeyNode::Kind::flag));
    }
    value = node->text == "true";
  });
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
  if (!is_printable(node.text)) {
    reject(info.name, node, "found " + shown(node), expected + " without line breaks or control characters");
  }
  return node.text;
}

void ScenarioReader::read_text(const KeyInfo& info, std::string& value) {
  const YamlNodePtr node = take(info);
  if (!node) return;
  const std::string text = checked_text(info, *node);
  const bool known = info.choices.empty() || std::ranges::find(info.choices, text) != info.choices.end();
  if (!known) reject(info.name, *node, "found " + shown(*node), expectation(info, KeyNode::Kind::text));
  const SourceLocation where = node->mark.in(file_);
  value = info.text == TextKind::word ? text : resolve_path(text, info.text, folder_, where, path_of(info.name));
}

void ScenarioReader::text(const KeyInfo& info, std::string& value) {
  const bool fine = mistakes_.attempt([&] { read_text(info, value); });
  if (info.choices.empty()) return;
  Level& level = levels_.back();
  if (!fine || level.skipped) level.unknown_choices.insert(info.name);
  level.chosen[info.name] = value;
}

void ScenarioReader::choices(const KeyInfo& info, std::vector<std::string>& values) {
  mistakes_.attempt([&] { read_choices(info, values); });
}

void ScenarioReader::read_choices(const KeyInfo& info, std::vector<std::string>& values) {
  const YamlNodePtr node = take(info);
  if (!node) return;
  const std::string expected = expectation(info, KeyNode::Kind::choices);
  if (node->kind != YamlNode::Kind::sequence || node->items.empty()) {
    reject(info.name, *node, "found " + shown(*node), expected);
  }
  std::vector<std::string> found;
  for (const auto& item : node->items) {
    const bool known =
        item->kind == YamlNode::Kind::scalar && std::ranges::find(info.choices, item->text) != info.choices.end();
    if (!known) reject(info.name, *item, "found " + shown(*item), expected);
    if (std::ranges::find(found, item->text) != found.end()) {
      reject(info.name, *item, "found " + item->text + " twice", expected + ", each once");
    }
    found.push_back(item->text);
  }
  values = found;
}

void ScenarioReader::names(const KeyInfo& info, std::vector<std::string>& values) {
  const YamlNodePtr node = take(info);
  if (!node) return;
  const std::string expected = expectation(info, KeyNode::Kind::names);
  const auto add = [&](const YamlNode& item) {
    const bool plain_number = item.kind == YamlNode::Kind::scalar && !item.quoted && parse_number(item.text);
    const bool whole = is_whole_number(item.text);
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
  mistakes_.attempt([&] { read_vector(info, value); });
}

void ScenarioReader::read_vector(const KeyInfo& info, std::optional<Vec3>& value) {
  const YamlNodePtr node = take(info);
  if (!node) return;
  if (MarkupsKeys::are_in(info, *node)) {
    value = markups_.point(info, *node, path_of(info.name));
    return;
  }
  const std::string expected = expectation(info, KeyNode::Kind::vector);
  const std::vector<double> numbers = components(info, *node, 3, expected);
  const Vec3 found(numbers[0], numbers[1], numbers[2]);
  // Shorter than this, squared lengths lose their digits.
  constexpr double kShortest = 1e-9;
  if (info.nonzero && found.norm() < kShortest) {
    reject(info.name, *node, "found a direction of length 0", expected);
  }
  value = found;
}

void ScenarioReader::points(const KeyInfo& info, std::vector<Vec3>& values) {
  mistakes_.attempt([&] { read_points(info, values); });
}

void ScenarioReader::read_points(const KeyInfo& info, std::vector<Vec3>& values) {
  const YamlNodePtr node = take(info);
  if (!node) return;
  if (MarkupsKeys::are_in(info, *node)) {
    values = markups_.points(info, *node, path_of(info.name));
    return;
  }
  const std::string expected = expectation(info, KeyNode::Kind::points);
  if (node->kind != YamlNode::Kind::sequence || std::ssize(node->items) < info.least_points) {
    reject(info.name, *node, "found " + shown(*node), expected);
  }
  values.clear();
  for (const auto& item : node->items) {
    if (MarkupsKeys::are_in(info, *item)) {
      values.push_back(markups_.point(info, *item, path_of(info.name)));
      continue;
    }
    const std::vector<double> numbers = components(info, *item, 3, expected);
    values.emplace_back(numbers[0], numbers[1], numbers[2]);
  }
}

void ScenarioReader::optional_quaternion(const KeyInfo& info, std::optional<Quat>& value) {
  mistakes_.attempt([&] { read_quaternion(info, value); });
}

void ScenarioReader::read_quaternion(const KeyInfo& info, std::optional<Quat>& value) {
  const YamlNodePtr node = take(info);
  if (!node) return;
  const std::string expected = expectation(info, KeyNode::Kind::quaternion);
  const std::vector<double> n = components(info, *node, 4, expected);
  Quat q(n[0], n[1], n[2], n[3]);
  constexpr double kLengthTolerance = 1.0000001e-2;  // of one written with few digits; 1.01 is within it
  if (std::abs(q.norm() - 1) > kLengthTolerance) {
    reject(info.name, *node, "found 4 numbers of length " + number_text(q.norm()), expected);
  }
  // A quaternion that is as unit as doubles allow stays as it is, so that to_yaml() and back changes nothing.
  constexpr double kRounding = 1e-14;
  if (std::abs(q.norm() - 1) > kRounding) q.normalize();
  value = q;
}

void ScenarioReader::group(const KeyGroup& group) {
  mistakes_.attempt([&] { check_group(group); });
}

void ScenarioReader::check_group(const KeyGroup& group) const {
  const Level& level = levels_.back();
  if (level.skipped) return;
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
  if (found.empty() && group.one_needed && !level.has_unknown) {
    const std::string& path = level.path;
    throw InputError(level.where, path, "needs either " + join_or(group.names), "");
  }
}

void ScenarioReader::push(const KeyInfo& info, YamlNodePtr node, bool skipped) {
  Level level;
  level.node = std::move(node);
  level.path = path_of(info.name);
  level.where = locations_.of(level.path);
  level.skipped = skipped || levels_.back().skipped;
  level.has_unknown = mistakes_.has_key_in(level.path);
  levels_.push_back(std::move(level));
}

void ScenarioReader::pop() {
  for (const MissingByChoice& missing : levels_.back().missing) {
    if (!levels_.back().contradicted.contains(missing.choice)) mistakes_.add(missing.error);
  }
  levels_.pop_back();
}

bool ScenarioReader::begin_section(const KeyInfo& info) {
  std::string why_not;
  YamlNodePtr node;
  const bool fine = mistakes_.attempt([&] {
    node = take(info);
    if (node && node->kind != YamlNode::Kind::map) {
      reject(info.name, *node, "found " + shown(*node), expectation(info, KeyNode::Kind::section));
    }
  });
  if (applies(info, why_not) != Applies::yes) return false;
  // The keys of a required section that is missing are not missing as well.
  push(info, fine ? node : nullptr, !fine || (info.required && !node));
  return true;
}

bool ScenarioReader::begin_optional_section(const KeyInfo& info, bool) {
  const Level& level = levels_.back();
  const bool given = level.node && level.node->find(info.name) != nullptr;
  if (!given) {
    mistakes_.attempt([&] { take(info); });
    return false;
  }
  return begin_section(info);
}

void ScenarioReader::end_section() {
  pop();
}

std::size_t ScenarioReader::begin_list(const KeyInfo& info, std::size_t) {
  YamlNodePtr node;
  const bool fine = mistakes_.attempt([&] {
    node = take(info);
    if (node && node->kind != YamlNode::Kind::sequence) {
      reject(info.name, *node, "found " + shown(*node), expectation(info, KeyNode::Kind::list));
    }
  });
  push(info, fine ? node : nullptr, !fine);
  return fine && node ? node->items.size() : 0;
}

void ScenarioReader::begin_item(std::size_t index) {
  const YamlNodePtr item = levels_.back().node->items[index];
  Level level;
  level.path = levels_.back().path + "." + std::to_string(index);
  level.where = item->mark.in(file_);
  level.skipped = item->kind != YamlNode::Kind::map;
  level.has_unknown = mistakes_.has_key_in(level.path);
  if (level.skipped) {
    mistakes_.add(InputError(level.where, level.path, "found " + shown(*item), "expected a section of keys"));
  } else {
    level.node = item;
  }
  locations_.set(level.path, level.where, true);
  levels_.push_back(std::move(level));
}

void ScenarioReader::end_list() {
  pop();
}

}  // namespace reamsim
