// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <nlohmann/json.hpp>

#include "sim/scenario/key_tree.h"
#include "sim/study/study.h"

namespace reamsim {

namespace {

using Json = nlohmann::ordered_json;

/// Appends the paths of all keys with values below `section` as regular expressions.
void add_paths(const KeyNode& section, const std::string& above, std::string& out) {
  for (const KeyNode& key : section.children) {
    const std::string path = above + std::string(key.info.name);
    if (key.kind == KeyNode::Kind::section) {
      add_paths(key, path + "\\.", out);
    } else if (key.kind == KeyNode::Kind::list) {
      add_paths(key, path + "\\.[0-9]+\\.", out);
    } else {
      out += (out.empty() ? "" : "|") + path;
    }
  }
}

Json key_names() {
  std::string paths;
  add_paths(key_tree(), "", paths);
  return {{"pattern", "^(" + paths + ")$"}};
}

Json map_of(const Json& values, int least = 1) {
  return {{"type", "object"},
          {"propertyNames", {{"$ref", "#/definitions/key"}}},
          {"additionalProperties", values},
          {"minProperties", least}};
}

Json numbers(int count) {
  return {{"type", "array"}, {"items", {{"type", "number"}}}, {"minItems", count}, {"maxItems", count}};
}

Json distribution(const char* name, const Json& parameters, const char* description) {
  return {{"type", "object"},
          {"description", description},
          {"properties", {{name, parameters}}},
          {"required", {name}},
          {"additionalProperties", false}};
}

Json distributions() {
  const Json spread{{"type", "number"}, {"exclusiveMinimum", 0}};
  return {
      {"oneOf",
       {distribution("normal", numbers(2), "Mean and standard deviation"),
        distribution("lognormal", numbers(2), "Median, and standard deviation of the logarithm"),
        distribution("uniform", numbers(2), "Both ends"),
        distribution("tilt_sd_deg", spread, "Direction: standard deviation of two rotations about axes across it [°]"),
        distribution("shift_sd_mm", spread, "Position: standard deviation of each component [mm]")}}};
}

Json sample_schema() {
  Json out{{"type", "object"}, {"additionalProperties", false}, {"required", {"n", "of"}}};
  out["description"] = "Samples of uncertain keys, the same for every other combination";
  out["properties"]["method"] = {{"enum", {"sobol", "latin_hypercube", "monte_carlo", "saltelli"}},
                                 {"default", "sobol"}};
  out["properties"]["n"] = {{"type", "integer"}, {"minimum", 1}, {"maximum", 1'000'000}};
  out["properties"]["seed"] = {{"type", "integer"}, {"minimum", 0}, {"default", 1}};
  out["properties"]["of"] = map_of(distributions());
  return out;
}

}  // namespace

std::string study_json_schema() {
  const Json list{{"type", "array"}, {"minItems", 1}};
  const Json kept{{"enum", {"summary", "forces", "pictures", "vdb"}}};
  Json entry = map_of(list);
  entry["maxProperties"] = 1;
  const Json zip{{"type", "object"},
                 {"properties", {{"zip", map_of(list)}}},
                 {"required", {"zip"}},
                 {"additionalProperties", false}};
  Json out{{"$schema", "http://json-schema.org/draft-07/schema#"},
           {"title", "reamsim study"},
           {"description", "A base scenario and what varies. Made from the keys of scenarios; do not edit."},
           {"definitions", {{"key", key_names()}}},
           {"type", "object"},
           {"additionalProperties", false},
           {"required", {"version", "base"}}};
  Json& keys = out["properties"];
  keys["version"] = {{"description", "Version of this format"}, {"const", 1}};
  keys["name"] = {{"description", "Name of the study and of its folder; without it that of the file"},
                  {"type", "string"}};
  keys["base"] = {{"description", "The scenario: its path, or the name of a shipped one"}, {"type", "string"}};
  keys["set"] = map_of(Json::object());
  keys["set"]["description"] = "Keys that every run changes";
  keys["vary"] = {{"description", "Every combination of the entries; keys of a zip vary together"},
                  {"type", "array"},
                  {"items", {{"anyOf", {zip, entry}}}},
                  {"minItems", 1}};
  keys["table"] = {{"description", "CSV file: a row per patient, columns are keys, or label"}, {"type", "string"}};
  keys["sample"] = sample_schema();
  keys["keep"] = {{"description", "What stays of a run beside its summary"},
                  {"anyOf", {kept, {{"type", "array"}, {"items", kept}}}},
                  {"default", {"summary"}}};
  return out.dump(2) + "\n";
}

}  // namespace reamsim
