// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/key_tree.h"
#include "sim/scenario/parse.h"

namespace reamsim {

namespace {

using Kind = KeyNode::Kind;

std::string type_text(const KeyNode& key) {
  switch (key.kind) {
    case Kind::section:
      return "section";
    case Kind::list:
      return "list of sections";
    case Kind::number:
      return "number";
    case Kind::integer:
      return "whole number";
    case Kind::flag:
      return "true or false";
    case Kind::choices:
      return "list of words";
    case Kind::names:
      return "name or whole number, or a list of them";
    case Kind::vector:
      return "3 numbers";
    case Kind::points:
      return "list of points, 3 numbers each";
    case Kind::quaternion:
      return "4 numbers";
    case Kind::text:
      break;
  }
  if (!key.info.choices.empty()) return "word";
  if (key.info.text == TextKind::word) return "text";
  return key.info.text == TextKind::output_folder ? "folder" : "path";
}

std::string values_text(const KeyNode& key) {
  std::string out;
  for (const auto choice : key.info.choices) out += (out.empty() ? "`" : ", `") + std::string(choice) + "`";
  if (out.empty()) out = range_text(key.info.range);
  if (key.info.nonzero) out = "not all zero";
  return out;
}

std::string default_text(const KeyNode& key) {
  if (key.info.required) return "**required**";
  if (key.kind == Kind::section) return "";
  const std::string by = key.info.default_by.empty() ? "" : ", or by `" + std::string(key.info.default_by) + "`";
  return (key.default_json.empty() ? "none" : "`" + key.default_json + "`") + by;
}

std::string doc_text(const KeyNode& key, const KeyNode& section) {
  std::string out(key.info.doc);
  if (!key.info.when.values.empty()) {
    out += ". Only with `" + std::string(key.info.when.choice) + ": " + join_or(key.info.when.values) + "`";
  }
  if (!key.info.unless.empty()) out += ". Not with `" + std::string(key.info.unless) + "`";
  for (const auto& group : section.groups) {
    if (group.one_needed && group.names.front() == key.info.name)
      out += ". Give exactly one of " + join_or(group.names);
  }
  return out + ".";
}

void add_rows(std::string& out, const KeyNode& section) {
  for (const auto& key : section.children) {
    const std::string_view unit = unit_of(key.info.name);
    out += "| `" + key.path + "` | " + type_text(key) + " | " + std::string(unit) + " | " + default_text(key) + " | " +
           values_text(key) + " | " + doc_text(key, section) + " |\n";
    add_rows(out, key);
  }
}

constexpr const char* kHead =
    "| key | type | unit | default | values | what it is |\n"
    "|---|---|---|---|---|---|\n";

}  // namespace

std::string scenario_key_table() {
  const KeyNode& root = key_tree();
  std::string out = kHead;
  for (const auto& key : root.children) {
    if (!key.children.empty()) continue;
    out += "| `" + key.path + "` | " + type_text(key) + " |  | " + default_text(key) + " | " + values_text(key) +
           " | " + doc_text(key, root) + " |\n";
  }
  for (const auto& section : root.children) {
    if (section.children.empty()) continue;
    out += "\n### " + section.path + "\n\n" + doc_text(section, root) + "\n\n" + kHead;
    add_rows(out, section);
  }
  return out;
}

}  // namespace reamsim
