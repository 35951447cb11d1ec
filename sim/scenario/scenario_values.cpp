// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/scenario_values.h"

#include <algorithm>
#include <array>

namespace reamsim {

namespace {

/// Sections and keys that change no number of the results.
constexpr std::array kWithoutEffect{"version", "name", "output", "render"};

std::string flow_text(const YamlNode& node) {
  if (node.kind != YamlNode::Kind::sequence) return node.kind == YamlNode::Kind::null ? "null" : node.text;
  std::string out = "[";
  for (const YamlNodePtr& item : node.items) out += (out.size() > 1 ? ", " : "") + flow_text(*item);
  return out + "]";
}

bool holds_maps(const YamlNode& node) {
  return std::ranges::any_of(node.items, [](const YamlNodePtr& item) { return item->kind == YamlNode::Kind::map; });
}

/// Adds every value below `node`; a list of plain values is one value.
void add_values(const YamlNode& node, const std::string& path, ScenarioValues& out) {
  if (node.kind == YamlNode::Kind::map) {
    for (const YamlEntry& entry : node.entries) {
      const bool shown = !path.empty() || std::ranges::find(kWithoutEffect, entry.key) == kWithoutEffect.end();
      if (shown) add_values(*entry.value, path.empty() ? entry.key : path + "." + entry.key, out);
    }
  } else if (node.kind == YamlNode::Kind::sequence && holds_maps(node)) {
    for (std::size_t i = 0; i < node.items.size(); ++i) add_values(*node.items[i], path + "." + std::to_string(i), out);
  } else {
    out.emplace_back(path, flow_text(node));
  }
}

}  // namespace

ScenarioValues values_of_scenario(const YamlNode& document) {
  ScenarioValues out;
  add_values(document, "", out);
  return out;
}

}  // namespace reamsim
