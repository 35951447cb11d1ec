// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/key_values.h"

#include "sim/scenario/find_key.h"
#include "sim/scenario/paths.h"
#include "sim/scenario/show.h"

namespace reamsim {

namespace {

bool names_input(const KeyNode& key) {
  return key.kind == KeyNode::Kind::text &&
         (key.info.text == TextKind::input_file || key.info.text == TextKind::input_path);
}

std::string plain_text(const YamlNode& node) {
  return node.kind == YamlNode::Kind::scalar ? node.text : flow_text(node);
}

}  // namespace

std::string flow_text(const YamlNode& node) {
  std::string out;
  switch (node.kind) {
    case YamlNode::Kind::null:
      return "null";
    case YamlNode::Kind::scalar:
      return node.quoted ? json_string(node.text) : node.text;
    case YamlNode::Kind::sequence:
      for (const YamlNodePtr& item : node.items) out += (out.empty() ? "" : ", ") + flow_text(*item);
      return "[" + out + "]";
    case YamlNode::Kind::map:
      for (const YamlEntry& entry : node.entries) {
        out += (out.empty() ? "" : ", ") + yaml_scalar(entry.key) + ": " + flow_text(*entry.value);
      }
      return "{" + out + "}";
  }
  return out;
}

KeyValue KeyValues::of_node(const std::string& key, const YamlNode& node, const SourceLocation& where) const {
  const KeyNode& known = find_key(key, where);
  if (!names_input(known) || node.kind != YamlNode::Kind::scalar) return {plain_text(node), flow_text(node)};
  const std::string path = resolve_path(node.text, known.info.text, folder_, where, key);
  return {node.text, json_string(recorded_path(path))};
}

KeyValue KeyValues::of_cell(const std::string& key, const std::string& cell, const SourceLocation& where) const {
  const KeyNode& known = find_key(key, where);
  if (cell.empty()) return {};
  if (!names_input(known)) return {cell, cell};
  const std::string path = resolve_path(cell, known.info.text, folder_, where, key);
  return {cell, json_string(recorded_path(path))};
}

}  // namespace reamsim
