// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/parse_steps.h"

#include <algorithm>
#include <array>

#include "sim/scenario/scenario.h"

namespace reamsim {

namespace {

/// A key of version 1 and its name in version 2; "" where it has no effect any more.
struct KeyChange {
  std::string_view section;  // "cutting.edge_force"
  std::string_view old_name;
  std::string_view new_name;
};
constexpr std::array<KeyChange, 7> kChanges{{{"engine", "detector", "type"},
                                             {"engine", "kernel_shape", ""},
                                             {"engine", "culling", ""},
                                             {"engine", "work_group_size", ""},
                                             {"cutting", "friction_share", "friction_fraction"},
                                             {"cutting.size_effect", "lips", "cutting_edges"},
                                             {"cutting.edge_force", "lips", "cutting_edges"}}};

std::shared_ptr<YamlNode> with_text(const YamlNode& node, const std::string& text) {
  auto copy = std::make_shared<YamlNode>(node);
  copy->text = text;
  return copy;
}

bool is_text(const YamlNode& node, std::string_view text) {
  return node.kind == YamlNode::Kind::scalar && node.text == text;
}

void apply(const KeyChange& change, const std::string& file, YamlNode& section, std::vector<std::string>& notes) {
  const auto entry = std::ranges::find(section.entries, change.old_name, &YamlEntry::key);
  if (entry == section.entries.end()) return;
  const std::string path = std::string(change.section) + ".", new_name(change.new_name);
  const SourceLocation where = entry->mark.in(file);
  const auto note = [&](const std::string& text) {
    notes.emplace_back(InputError(where, path + entry->key, text, "").what());
  };
  if (new_name.empty()) {
    note("ignored, because it changes no result: remove it");
    section.entries.erase(entry);
    return;
  }
  if (section.find(new_name) != nullptr) {
    throw InputError(where, path + entry->key, "given together with " + new_name, "expected " + new_name + " only");
  }
  // Version 1 had no name of its own for the engine of exact erosion.
  const bool any_sparse = new_name == "type" && is_text(*entry->value, "bricked");
  note("outdated since format version 2: write " + path + new_name + (any_sparse ? ": auto" : ""));
  if (any_sparse) entry->value = with_text(*entry->value, "auto");
  entry->key = new_name;
}

/// `node`, a section of that path, with its keys changed, and those below it.
YamlNodePtr changed_section(const YamlNodePtr& node, const std::string& path, const std::string& file,
                            std::vector<std::string>& notes) {
  if (node->kind != YamlNode::Kind::map) return node;
  auto copy = std::make_shared<YamlNode>(*node);
  for (const KeyChange& change : kChanges) {
    if (change.section == path) apply(change, file, *copy, notes);
  }
  for (YamlEntry& entry : copy->entries) {
    const std::string below = path.empty() ? entry.key : path + "." + entry.key;
    const bool concerned =
        std::ranges::any_of(kChanges, [&](const KeyChange& change) { return change.section.starts_with(below); });
    if (concerned) entry.value = changed_section(entry.value, below, file, notes);
  }
  return copy;
}

}  // namespace

YamlNodePtr migrate(const YamlNodePtr& document, const std::string& file, std::vector<std::string>& notes) {
  const YamlNodePtr changed = changed_section(document, "", file, notes);
  const YamlEntry* version = changed->find("version");
  if (version == nullptr || !is_text(*version->value, "1")) return changed;
  auto copy = std::make_shared<YamlNode>(*changed);
  std::ranges::find(copy->entries, "version", &YamlEntry::key)->value =
      with_text(*version->value, std::to_string(kScenarioVersion));
  return copy;
}

}  // namespace reamsim
