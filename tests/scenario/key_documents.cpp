// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/scenario/key_documents.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "sim/scenario/key_tree.h"
#include "sim/scenario/show.h"

namespace reamsim::test {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) {
  // Whole numbers without ".0", as everyone writes them.
  const auto whole = static_cast<std::int64_t>(value);
  return static_cast<double>(whole) == value ? Json(whole) : Json(value);
}

Json number_type(const KeyNode& key, const char* type) {
  const auto [min, max] = key.info.range;
  if (min == max) return {{"type", type}, {"const", number(min)}};
  Json out{{"type", type}};
  if (std::isfinite(min)) out["minimum"] = number(min);
  if (std::isfinite(max)) out["maximum"] = number(max);
  return out;
}

Json numbers_type(const KeyNode& key, int count) {
  return {{"type", "array"}, {"items", number_type(key, "number")}, {"minItems", count}, {"maxItems", count}};
}

/// A point of a markups file of 3D Slicer; with `many` several labels, or all points.
Json markups_schema(bool many) {
  const Json label{{"type", {"string", "number"}}, {"minLength", 1}};
  const Json labels{{"anyOf", Json::array({label, {{"type", "array"}, {"items", label}, {"minItems", 1}}})}};
  return {{"description", "A point of a markups file of 3D Slicer (.mrk.json or .fcsv), by its label"},
          {"type", "object"},
          {"required", {"markups"}},
          {"additionalProperties", false},
          {"properties", {{"markups", {{"type", "string"}, {"minLength", 1}}}, {"point", many ? labels : label}}}};
}

Json markups_type(bool many) {
  return {{"$ref", many ? "#/definitions/points_of_markups" : "#/definitions/point_of_markups"}};
}

/// The type of a vector, or of a point, which markups may give too.
Json vector_type(const KeyNode& key) {
  if (!key.info.point) return numbers_type(key, 3);
  return {{"anyOf", Json::array({numbers_type(key, 3), markups_type(false)})}};
}

Json points_type(const KeyNode& key) {
  const Json list{{"type", "array"}, {"items", vector_type(key)}, {"minItems", key.info.least_points}};
  if (!key.info.point) return list;
  return {{"anyOf", Json::array({list, markups_type(true)})}};
}

/// A name or a whole number, or a list of them.
Json names_type() {
  const Json name{{"type", {"string", "integer"}}, {"minLength", 1}, {"minimum", 0}};
  Json list{{"type", "array"}, {"items", name}, {"minItems", 1}};
  return {{"anyOf", Json::array({name, list})}};
}

Json text_type(const KeyNode& key) {
  if (!key.info.choices.empty()) return {{"type", "string"}, {"enum", key.info.choices}};
  if (key.info.number_too) return {{"type", {"string", "integer"}}, {"minLength", 1}};
  if (key.info.text == TextKind::output_folder) return {{"type", "string"}};
  return {{"type", "string"}, {"minLength", 1}};
}

Json required(const std::vector<std::string_view>& names) {
  return {{"required", names}};
}

/// Forbids, and where it is needed requires, a key that applies with some values of a choice only.
void add_condition(Json& rules, const KeyNode& key, const KeyNode& section) {
  const When& when = key.info.when;
  const KeyNode& choice = *section.find(when.choice);
  const std::string name(key.info.name);
  Json chosen{{"properties", {{std::string(when.choice), {{"enum", when.values}}}}}};
  // Where the choice may be left out, its default decides.
  const std::string fallback = choice.default_json.empty() ? "" : Json::parse(choice.default_json).get<std::string>();
  if (std::ranges::find(when.values, fallback) == when.values.end()) chosen["required"] = {when.choice};
  Json rule{{"if", chosen}};
  if (key.info.required) rule["then"] = required({key.info.name});
  rule["else"] = {{"properties", {{name, false}}}};
  rules.push_back(rule);
}

void add_group(Json& rules, const KeyGroup& group) {
  if (group.one_needed) {
    Json choices = Json::array();
    for (const auto name : group.names) choices.push_back(required({name}));
    rules.push_back({{"oneOf", choices}});
  } else {
    rules.push_back({{"not", required(group.names)}});
  }
}

Json key_schema(const KeyNode& key);

Json section_schema(const KeyNode& section) {
  Json out{{"type", "object"}, {"additionalProperties", false}};
  std::vector<std::string_view> needed;
  Json properties = Json::object();
  Json rules = Json::array();
  for (const auto& key : section.children) {
    properties[std::string(key.info.name)] = key_schema(key);
    const bool conditional = !key.info.when.values.empty();
    if (key.info.required && !conditional) needed.push_back(key.info.name);
    if (conditional) add_condition(rules, key, section);
    if (!key.info.unless.empty()) rules.push_back({{"not", required({key.info.unless, key.info.name})}});
  }
  for (const auto& group : section.groups) add_group(rules, group);
  if (!needed.empty()) out["required"] = needed;
  out["properties"] = properties;
  if (!rules.empty()) out["allOf"] = rules;
  return out;
}

Json type_schema(const KeyNode& key) {
  switch (key.info.kind) {
    case KeyKind::section:
      return section_schema(key);
    case KeyKind::list:
      return {{"type", "array"}, {"items", section_schema(key)}};
    case KeyKind::number:
      return number_type(key, "number");
    case KeyKind::integer:
      return number_type(key, "integer");
    case KeyKind::flag:
      return {{"type", "boolean"}};
    case KeyKind::choices:
      return {{"type", "array"},
              {"items", {{"type", "string"}, {"enum", key.info.choices}}},
              {"minItems", 1},
              {"uniqueItems", true}};
    case KeyKind::names:
      return names_type();
    case KeyKind::vector:
      return vector_type(key);
    case KeyKind::points:
      return points_type(key);
    case KeyKind::quaternion:
      return numbers_type(key, 4);
    case KeyKind::text:
      break;
  }
  return text_type(key);
}

Json key_schema(const KeyNode& key) {
  const std::string_view unit = unit_of(key.info.name);
  Json out{{"description", std::string(key.info.doc) + (unit.empty() ? "" : " [" + std::string(unit) + "]")}};
  out.update(type_schema(key));
  // A default that depends on another key has no place in a schema.
  if (!key.default_json.empty() && key.info.default_by.empty()) out["default"] = Json::parse(key.default_json);
  return out;
}

/// In the order of KeyKind.
constexpr std::array kKindNames{"number",    "integer",         "boolean",    "text", "name, integer or list",
                                "3 numbers", "list of vectors", "quaternion", "list", "section",
                                "list"};

std::string type_text(const KeyInfo& info) {
  if (info.point) return info.kind == KeyKind::vector ? "point" : "points";
  if (info.nonzero) return "direction";
  if (info.kind != KeyKind::text) return kKindNames[static_cast<std::size_t>(info.kind)];
  if (!info.choices.empty()) return "choice";
  if (info.text == TextKind::word) return "text";
  return info.text == TextKind::output_folder ? "folder" : "path";
}

/// The choices, or the range with its unit.
std::string values_text(const KeyInfo& info) {
  std::string out;
  for (const auto choice : info.choices) out += (out.empty() ? "`" : ", `") + std::string(choice) + "`";
  if (!out.empty() || info.nonzero) return out;
  const Range& range = info.range;
  const bool symmetric = std::isfinite(range.max) && range.min == -range.max;
  out = symmetric ? "±" + number_text(range.max) : range_text(range);
  const std::string_view unit = unit_of(info.name);
  return out + (unit.empty() ? "" : " " + std::string(unit));
}

std::string default_text(const KeyNode& key) {
  if (key.info.required) return "**required**";
  if (key.default_json.empty()) return "";
  const std::string by = key.info.default_by.empty() ? "" : ", or by `" + std::string(key.info.default_by) + "`";
  return "`" + key.default_json + "`" + by;
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

/// What a row has after the path.
std::string cells_text(const KeyNode& key, const KeyNode& section) {
  return type_text(key.info) + " | " + default_text(key) + " | " + values_text(key.info) + " | " +
         doc_text(key, section);
}

bool have_same_keys(const KeyNode& a, const KeyNode& b) {
  return std::ranges::equal(a.children, b.children, [&](const KeyNode& one, const KeyNode& other) {
    return one.info.name == other.info.name && cells_text(one, a) == cells_text(other, b) && have_same_keys(one, other);
  });
}

/// The first section below `within` that has the keys of `section`; at the latest `section` itself.
const KeyNode* first_with_keys_of(const KeyNode& section, const KeyNode& within) {
  for (const auto& key : within.children) {
    if (key.children.empty()) continue;
    if (have_same_keys(key, section)) return &key;
    if (const KeyNode* found = first_with_keys_of(section, key)) return found;
  }
  return nullptr;
}

/// Keys that several sections have are listed once.
void add_row(std::string& out, const KeyNode& key, const KeyNode& section) {
  out += "| `" + key.path + "` | " + cells_text(key, section);
  const KeyNode* first = key.children.empty() ? &key : first_with_keys_of(key, key_tree());
  if (first != &key) out += " Keys: as `" + first->path + "`.";
  out += " |\n";
  if (first != &key) return;
  for (const auto& child : key.children) add_row(out, child, key);
}

constexpr const char* kHead = "| key | type | default | values | what it is |\n|---|---|---|---|---|\n";

/// Appends the paths of all keys with values below `section` as regular expressions.
void add_paths(const KeyNode& section, const std::string& above, std::string& out) {
  for (const KeyNode& key : section.children) {
    const std::string path = above + std::string(key.info.name);
    if (key.info.kind == KeyKind::section) {
      add_paths(key, path + "\\.", out);
    } else if (key.info.kind == KeyKind::list) {
      add_paths(key, path + "\\.[0-9]+\\.", out);
    } else {
      out += (out.empty() ? "" : "|") + path;
    }
  }
}

}  // namespace

std::string scenario_json_schema() {
  Json out{{"$schema", "http://json-schema.org/draft-07/schema#"},
           {"title", "reamsim scenario"},
           {"description",
            "Which bone, which reamer, and how the reamer moves. Made from the parser's own description "
            "of keys; do not edit."}};
  out.update(section_schema(key_tree()));
  out["definitions"] = {{"point_of_markups", markups_schema(false)}, {"points_of_markups", markups_schema(true)}};
  return out.dump(2) + "\n";
}

std::string scenario_key_table() {
  const KeyNode& root = key_tree();
  std::string out = kHead;
  for (const auto& key : root.children) {
    if (key.children.empty()) add_row(out, key, root);
  }
  for (const auto& section : root.children) {
    if (section.children.empty()) continue;
    out += "\n### " + section.path + "\n\n" + doc_text(section, root) + "\n\n" + kHead;
    for (const auto& key : section.children) add_row(out, key, section);
  }
  return out;
}

std::string study_json_schema(const std::string& schema) {
  std::string paths;
  add_paths(key_tree(), "", paths);
  auto json = nlohmann::ordered_json::parse(schema);
  json["definitions"]["key"]["pattern"] = "^(" + paths + ")$";
  return json.dump(2) + "\n";
}

}  // namespace reamsim::test
