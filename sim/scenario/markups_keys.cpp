// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/markups.h"

#include <utility>

#include "sim/scenario/key_tree.h"
#include "sim/scenario/paths.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

constexpr const char* kExpectedValue = "expected {markups: FILE, point: LABEL}";

std::string shown_point(const Vec3& p) {
  return "(" + number_text(p.x()) + ", " + number_text(p.y()) + ", " + number_text(p.z()) + ")";
}

}  // namespace

/// Calls `work`; what it says of the file is said at the value in the scenario.
template <class Work>
decltype(auto) MarkupsKeys::located(const Request& request, const Work& work) const {
  try {
    return work();
  } catch (const InputError& error) {
    std::vector<Mistake> mistakes = error.mistakes();
    for (Mistake& mistake : mistakes) {
      if (!mistake.key.empty()) continue;
      mistake.found = mistake.where.text() + ": " + mistake.found;
      mistake.where = request.node.mark.in(file_);
      mistake.key = request.key;
    }
    throw InputError(std::move(mistakes));
  }
}

MarkupsKeys::Request MarkupsKeys::request_of(const YamlNode& node, const std::string& key) const {
  const auto reject = [&](const YamlMark& mark, const std::string& found) {
    throw InputError(mark.in(file_), key, found, kExpectedValue);
  };
  Request out{.node = node, .key = key};
  for (const YamlEntry& entry : node.entries) {
    const YamlNode& value = *entry.value;
    if (entry.key != "markups" && entry.key != "point") reject(entry.mark, "found " + shown_key(entry.key));
    const bool list = entry.key == "point" && value.kind == YamlNode::Kind::sequence && !value.items.empty();
    if (!list && value.kind != YamlNode::Kind::scalar) reject(value.mark, shown_key(entry.key) + " is " + shown(value));
    if (entry.key == "markups") continue;
    if (!list) out.labels.push_back(value.text);
    for (const YamlNodePtr& item : value.items) {
      if (item->kind != YamlNode::Kind::scalar) reject(item->mark, "point has " + shown(*item));
      out.labels.push_back(item->text);
    }
  }
  return out;
}

const Markups& MarkupsKeys::file_of(const Request& request) {
  const YamlNode& name = *request.node.find("markups")->value;
  if (name.text.empty()) throw InputError(name.mark.in(file_), request.key, "markups is empty", kExpectedValue);
  const std::string path = resolve_path(name.text, TextKind::input_file, folder_, name.mark.in(file_), request.key);
  const auto known = read_.find(path);
  if (known != read_.end()) return known->second;
  return located(request, [&]() -> const Markups& { return read_.emplace(path, read_markups(path)).first->second; });
}

void MarkupsKeys::remember(const Request& request, const Markups& markups, std::size_t points) {
  std::string found;
  for (const std::string& label : request.labels) found += (found.empty() ? "" : ", ") + shown_text(label);
  if (found.empty()) found = std::to_string(points) + (points == 1 ? " point" : " points");
  sources_.push_back(
      {request.key, markups.path, found + " of " + shown_path(markups.path) + " (" + markups.frame + ")"});
}

Vec3 MarkupsKeys::point(const KeyInfo& info, const YamlNode& node, const std::string& key) {
  return read(info, request_of(node, key), true).front();
}

std::vector<Vec3> MarkupsKeys::points(const KeyInfo& info, const YamlNode& node, const std::string& key) {
  return read(info, request_of(node, key), false);
}

std::vector<Vec3> MarkupsKeys::read(const KeyInfo& info, const Request& request, bool one) {
  const auto fail = [&](const std::string& found, const std::string& expected) {
    throw InputError(request.node.mark.in(file_), request.key, found, expected);
  };
  const Markups& markups = file_of(request);
  if (one && request.labels.size() > 1) {
    fail("point has " + std::to_string(request.labels.size()) + " labels", "expected one: this key is one point");
  }
  const std::vector<Vec3> found = located(request, [&] {
    if (request.labels.empty()) return one ? std::vector{markups.only_position_mm()} : markups.positions_mm();
    std::vector<Vec3> named;
    for (const std::string& label : request.labels) named.push_back(markups.position_mm(label));
    return named;
  });
  if (!one && std::ssize(found) < info.least_points) {
    fail("found " + std::to_string(found.size()) + " points in " + shown_path(markups.path),
         "expected at least " + std::to_string(info.least_points));
  }
  for (const Vec3& p : found) {
    if (info.range.contains(p.x()) && info.range.contains(p.y()) && info.range.contains(p.z())) continue;
    fail("found the point " + shown_point(p) + " mm", "expected each number " + range_text(info.range));
  }
  remember(request, markups, found.size());
  return found;
}

}  // namespace reamsim
