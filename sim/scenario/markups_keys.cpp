// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/ranges.h>

#include <utility>

#include "sim/scenario/key_tree.h"
#include "sim/scenario/markups.h"
#include "sim/scenario/paths.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

constexpr const char* kExpectedValue = "expected {markups: FILE, point: LABEL}";

/// The labels that a value lists; none: those of the file.
std::vector<std::string> labels_of(const YamlNode& node, const std::string& file, const std::string& key) {
  const auto reject = [&](const YamlMark& mark, const std::string& found) {
    throw InputError(mark.in(file), key, found, kExpectedValue);
  };
  std::vector<std::string> out;
  for (const YamlEntry& entry : node.entries) {
    const YamlNode& value = *entry.value;
    if (entry.key != "markups" && entry.key != "point") reject(entry.mark, "found " + shown_key(entry.key));
    const bool list = entry.key == "point" && value.kind == YamlNode::Kind::sequence && !value.items.empty();
    if (!list && value.kind != YamlNode::Kind::scalar) reject(value.mark, shown_key(entry.key) + " is " + shown(value));
    if (entry.key == "markups") continue;
    if (!list) out.push_back(value.text);
    for (const YamlNodePtr& item : value.items) {
      if (item->kind != YamlNode::Kind::scalar) reject(item->mark, "point has " + shown(*item));
      out.push_back(item->text);
    }
  }
  return out;
}

}  // namespace

std::vector<Vec3> MarkupsKeys::points(const KeyInfo& info, const YamlNode& node, const std::string& key, bool several) {
  try {
    return found_points(info, node, key, several);
  } catch (const InputError& error) {  // what it says of the file is said at the value in the scenario
    std::vector<Mistake> mistakes = error.mistakes();
    for (Mistake& mistake : mistakes) {
      if (!mistake.key.empty()) continue;
      mistake.found = mistake.where.text() + ": " + mistake.found;
      mistake.where = node.mark.in(file_);
      mistake.key = key;
    }
    throw InputError(std::move(mistakes));
  }
}

std::vector<Vec3> MarkupsKeys::found_points(const KeyInfo& info, const YamlNode& node, const std::string& key,
                                            bool several) {
  const auto fail = [&](const std::string& found, const std::string& expected) {
    throw InputError(node.mark.in(file_), key, found, expected);
  };
  std::vector<std::string> labels = labels_of(node, file_, key);
  const YamlNode& name = *node.find("markups")->value;
  if (name.text.empty()) throw InputError(name.mark.in(file_), key, "markups is empty", kExpectedValue);
  const std::string path = resolve_path(name.text, TextKind::input_file, folder_, name.mark.in(file_), key);
  auto known = read_.find(path);
  if (known == read_.end()) known = read_.emplace(path, read_markups(path)).first;
  const Markups& markups = known->second;
  if (!several && labels.size() > 1)
    fail("point has " + std::to_string(labels.size()) + " labels", "expected one: this key is one point");
  std::vector<Vec3> out;
  for (const std::string& label : labels) out.push_back(markups.position_mm(label));
  if (labels.empty()) out = several ? markups.positions_mm() : std::vector{markups.only_position_mm()};
  if (several && std::ssize(out) < info.least_points) {
    fail("found " + std::to_string(out.size()) + " points in " + shown_path(path),
         "expected at least " + std::to_string(info.least_points));
  }
  for (const Vec3& p : out) {
    if (info.range.contains(p.x()) && info.range.contains(p.y()) && info.range.contains(p.z())) continue;
    fail("found the point (" + number_text(p.x()) + ", " + number_text(p.y()) + ", " + number_text(p.z()) + ") mm",
         "expected each number " + range_text(info.range));
  }
  for (std::string& label : labels) label = shown_text(label);
  const std::string found = labels.empty() ? fmt::format("{} point{}", out.size(), out.size() == 1 ? "" : "s")
                                           : fmt::format("{}", fmt::join(labels, ", "));
  sources_.push_back({key, path, found + " of " + shown_path(path) + " (" + markups.frame + ")"});
  return out;
}

}  // namespace reamsim
