// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <nlohmann/json.hpp>

#include "sim/scenario/key_tree.h"
#include "sim/study/study.h"

namespace reamsim {

namespace {

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

std::string study_json_schema(const std::string& schema) {
  std::string paths;
  add_paths(key_tree(), "", paths);
  auto json = nlohmann::ordered_json::parse(schema);
  json["definitions"]["key"]["pattern"] = "^(" + paths + ")$";
  return json.dump(2) + "\n";
}

}  // namespace reamsim
