// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/parse_steps.h"

#include <algorithm>
#include <charconv>
#include <utility>
#include <vector>

#include "sim/scenario/show.h"

namespace reamsim {

namespace {

/// A parsed assignment.
struct Override {
  YamlMark mark;
  std::vector<std::string> path;
  YamlNodePtr value;

  [[noreturn]] void fail(const std::string& found, const std::string& expected) const {
    throw InputError(mark.in(""), "", found, expected);
  }
};

/// A copy that names the assignment as its place, all the way down.
YamlNodePtr marked(const YamlNode& node, const YamlMark& mark) {
  auto copy = std::make_shared<YamlNode>(node);
  copy->mark = mark;
  for (auto& item : copy->items) item = marked(*item, mark);
  for (auto& entry : copy->entries) entry = {entry.key, mark, marked(*entry.value, mark)};
  return copy;
}

YamlNodePtr text_node(const std::string& text, const YamlMark& mark) {
  auto node = std::make_shared<YamlNode>();
  node->kind = YamlNode::Kind::scalar;
  node->text = text;
  node->mark = mark;
  return node;
}

YamlNodePtr parse_value(const std::string& text, const YamlMark& mark) {
  try {
    const YamlNodePtr node = parse_yaml(text, *mark.override_text);
    const bool block_map = node->kind == YamlNode::Kind::map && !text.starts_with('{');
    const bool nothing = node->kind == YamlNode::Kind::null && text != "null" && text != "~";
    const bool plain = node->kind == YamlNode::Kind::scalar && !node->quoted;
    if (!block_map && !nothing && !plain) return marked(*node, mark);
  } catch (const InputError&) {
    // Not YAML, so it is meant literally: a device's name may hold ": " or a bracket.
    if (text.starts_with('[') || text.starts_with('{') || text.starts_with('"')) throw;
  }
  const std::size_t first = text.find_first_not_of(" \t\n"), last = text.find_last_not_of(" \t\n");
  return text_node(first == std::string::npos ? "" : text.substr(first, last - first + 1), mark);
}

Override take_apart(const std::string& assignment) {
  Override out;
  const std::string shown_assignment = "--set " + shown_path(assignment);
  out.mark.override_text = std::make_shared<const std::string>(shown_assignment);
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos) out.fail("found no \"=\"", "expected --set key.path=value");
  std::string rest = assignment.substr(0, equals);
  for (;;) {
    const std::size_t dot = rest.find('.');
    out.path.push_back(rest.substr(0, dot));
    if (out.path.back().empty()) out.fail("found an empty key", "expected --set key.path=value");
    if (dot == std::string::npos) break;
    rest = rest.substr(dot + 1);
  }
  if (out.path.size() > static_cast<std::size_t>(YamlLimits::kMaxDepth)) {
    out.fail("found " + std::to_string(out.path.size()) + " levels of keys", "expected a key of the scenario");
  }
  out.value = parse_value(assignment.substr(equals + 1), out.mark);
  return out;
}

YamlNodePtr assign(const YamlNodePtr& node, const Override& change, std::size_t level);

YamlNodePtr assign_item(const YamlNode& list, const Override& change, std::size_t level) {
  const std::string& step = change.path[level];
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(step.data(), step.data() + step.size(), index);
  if (error != std::errc{} || end != step.data() + step.size() || index >= list.items.size()) {
    const std::size_t size = list.items.size();
    change.fail("found " + shown_key(step) + " where an index into a list of " + std::to_string(size) + " should be",
                size == 0 ? "expected a list with entries" : "expected 0 to " + std::to_string(size - 1));
  }
  auto copy = std::make_shared<YamlNode>(list);
  copy->items[index] = assign(list.items[index], change, level + 1);
  return copy;
}

YamlNodePtr assign_key(const YamlNodePtr& section, const Override& change, std::size_t level) {
  const std::string& step = change.path[level];
  auto copy = section ? std::make_shared<YamlNode>(*section) : std::make_shared<YamlNode>();
  if (copy->kind == YamlNode::Kind::null) copy->mark = change.mark;
  copy->kind = YamlNode::Kind::map;
  const auto entry = std::ranges::find(copy->entries, step, &YamlEntry::key);
  const bool last = level + 1 == change.path.size();
  const bool remove = last && change.value->kind == YamlNode::Kind::null;
  if (entry == copy->entries.end()) {
    if (!remove) copy->entries.push_back({step, change.mark, assign(nullptr, change, level + 1)});
  } else if (remove) {
    copy->entries.erase(entry);
  } else {
    entry->value = assign(entry->value, change, level + 1);
    if (last) entry->mark = change.mark;
  }
  return copy;
}

/// `node` with the value put below it; nullptr where there was none.
YamlNodePtr assign(const YamlNodePtr& node, const Override& change, std::size_t level) {
  if (level == change.path.size()) return change.value;
  if (node && node->kind == YamlNode::Kind::sequence) return assign_item(*node, change, level);
  if (node && node->kind == YamlNode::Kind::scalar) {
    std::string path;
    for (std::size_t i = 0; i < level; ++i) path += (i > 0 ? "." : "") + shown_key(change.path[i]);
    change.fail("found keys below " + path + ", which is " + shown(*node), "expected --set " + path + "=value");
  }
  return assign_key(node, change, level);
}

}  // namespace

YamlNodePtr apply_override(const YamlNodePtr& document, const std::string& assignment) {
  return assign(document, take_apart(assignment), 0);
}

}  // namespace reamsim
