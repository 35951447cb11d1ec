// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/parse.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <new>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/scenario/describe_sections.h"
#include "sim/scenario/parse_steps.h"
#include "sim/scenario/passes.h"
#include "sim/scenario/paths.h"
#include "sim/scenario/presets.h"
#include "sim/scenario/reader.h"
#include "sim/scenario/show.h"
#include "sim/scenario/yaml_tree.h"

namespace reamsim {

YamlNodePtr read_document(const std::string& path, const std::vector<std::string>& overrides,
                          std::vector<std::string>& notes) {
  const std::string file = shown_path(path);
  YamlNodePtr document = parse_yaml(read_scenario_text(path, YamlLimits::kMaxBytes), file);
  if (document->kind == YamlNode::Kind::null) {
    throw InputError({file, 0, 0}, "", "is empty", "expected a scenario with the keys version, bone, tool and motion");
  }
  if (document->kind != YamlNode::Kind::map) {
    throw InputError(document->mark.in(file), "", "found " + shown(*document), "expected \"key: value\" lines");
  }
  MistakeList mistakes;
  for (const auto& assignment : overrides) {
    mistakes.attempt([&] { document = apply_override(document, assignment); });
  }
  mistakes.throw_if_any();
  return migrate(document, file, notes);
}

namespace {

namespace fs = std::filesystem;

std::shared_ptr<YamlNode> text_of(const std::string& text) {
  auto node = std::make_shared<YamlNode>();
  node->kind = YamlNode::Kind::scalar;
  node->text = text;
  node->quoted = true;
  return node;
}

/// A section of one key.
std::shared_ptr<YamlNode> section_of(const std::string& key, YamlNodePtr value) {
  auto node = std::make_shared<YamlNode>();
  node->kind = YamlNode::Kind::map;
  node->entries.push_back({key, {}, std::move(value)});
  return node;
}

/// What a CT is read from: for a DICOMDIR the folder that it indexes.
std::string ct_input(const std::string& path) {
  std::string name = fs::path(path).filename().string();
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return std::tolower(c); });
  return name == "dicomdir" && fs::is_regular_file(path) ? fs::path(path).parent_path().string() : path;
}

}  // namespace

Scenario parse_scenario(const std::string& path, const std::vector<std::string>& overrides) {
  try {
    Scenario scenario;
    const YamlNodePtr document = read_document(path, overrides, scenario.notes);
    const std::string file = shown_path(path);
    MistakeList mistakes;
    reject_unknown_keys(*document, file, mistakes);
    const fs::path absolute = fs::absolute(path).lexically_normal();
    require_recordable(absolute.string(), {file, 0, 0}, "");
    ScenarioReader reader(document, file, absolute.parent_path().string(), mistakes);
    describe_scenario(reader, scenario);
    scenario.markups = reader.markups();
    apply_preset(reader.locations(), scenario.cutting);
    check_rules(scenario, reader.locations(), mistakes);
    mistakes.throw_if_any();
    scenario.file = absolute.string();
    scenario.keys = reader.locations();
    if (scenario.name.empty()) scenario.name = absolute.stem().string();
    return scenario;
  } catch (const std::bad_alloc&) {
    throw InputError({shown_path(path), 0, 0}, "", "not enough memory", "expected a scenario file (YAML)");
  }
}

namespace {

/// The value of a key, or nullptr.
const YamlNode* value_of(const YamlNode* node, std::string_view key) {
  const YamlEntry* entry = node == nullptr ? nullptr : node->find(key);
  return entry == nullptr ? nullptr : entry->value.get();
}

/// Whether the tool of any pass is resolved.
bool resolves_cutting_edges(const YamlNode& document) {
  const auto resolved = [](const YamlNode* holder) {
    const YamlNode* spin = value_of(value_of(holder, "tool"), "spin");
    return spin != nullptr && spin->text == name_of(ToolSpin::resolved);
  };
  const YamlNode* passes = value_of(value_of(&document, "motion"), "passes");
  if (passes == nullptr || passes->items.empty()) return resolved(&document);
  return std::ranges::any_of(passes->items, [&](const YamlNodePtr& pass) {
    return value_of(pass.get(), "tool") == nullptr ? resolved(&document) : resolved(pass.get());
  });
}

}  // namespace

ResultSettings parse_result_settings(const std::string& path, const std::vector<std::string>& overrides) {
  std::vector<std::string> unused_notes;
  const YamlNodePtr document = read_document(path, overrides, unused_notes);
  const std::string file = shown_path(path);
  MistakeList mistakes;
  reject_unknown_keys(*document, file, mistakes);
  ScenarioReader reader(document, file, "", mistakes);
  ResultSettings out;
  reader.section("render", out.render, describe_render);
  reader.section("cutting", out.cutting, describe_cutting);
  reader.section("output", out.output, describe_output);
  mistakes.throw_if_any();
  check_cameras(out.render, reader.locations());
  if (resolves_cutting_edges(*document)) out.tool_spin = ToolSpin::resolved;
  return out;
}

BoneSettings parse_bone_settings(const std::string& source, const std::string& path,
                                 const std::vector<std::string>& overrides) {
  const std::string file = shown_path(path);
  YamlNodePtr document = section_of(
      "bone",
      section_of(source, section_of("path", text_of(recorded_path(fs::absolute(path).lexically_normal().string())))));
  document = apply_override(document, "bone.source=" + source);
  for (const auto& assignment : overrides) {
    document = apply_override(document, assignment);
    if (document->entries.size() > 1) {
      throw InputError("--set " + shown_path(assignment) + ": not a key of the bone section; expected bone.KEY=VALUE");
    }
  }
  MistakeList mistakes;
  reject_unknown_keys(*document, file, mistakes);
  ScenarioReader reader(document, file, fs::current_path().string(), mistakes);
  Scenario scenario;
  reader.section("bone", scenario.bone, describe_bone);
  check_rules(scenario, reader.locations(), mistakes);
  mistakes.throw_if_any();
  return scenario.bone;
}

std::vector<std::pair<std::string, std::string>> input_files(const Scenario& scenario) {
  const BoneSettings& bone = scenario.bone;
  std::vector<std::pair<std::string, std::string>> files;
  if (bone.source == BoneSource::ct) {
    files.emplace_back("bone.ct.path", ct_input(bone.ct.path));
    if (bone.ct.label_map) files.emplace_back("bone.ct.label_map.path", bone.ct.label_map->path);
  }
  if (bone.source == BoneSource::mesh) files.emplace_back("bone.mesh.path", bone.mesh.path);
  if (bone.source == BoneSource::vdb) files.emplace_back("bone.vdb.path", bone.vdb.path);
  files.emplace_back("tool.mesh", scenario.tool.mesh);
  for (const PassSpec& pass : passes_of(scenario)) {
    if (pass.tool_key != "tool") files.emplace_back(pass.tool_key + ".mesh", pass.tool.mesh);
  }
  if (scenario.clearance.envelope) files.emplace_back("clearance.envelope.path", scenario.clearance.envelope->path);
  if (scenario.motion.csv) files.emplace_back("motion.csv.path", scenario.motion.csv->path);
  if (scenario.motion.push && !scenario.motion.push->profile.empty())
    files.emplace_back("motion.push.profile", scenario.motion.push->profile);
  for (const MarkupsSource& source : scenario.markups) {
    const auto same = [&](const auto& file) { return file.second == source.path; };
    if (std::ranges::none_of(files, same)) files.emplace_back(source.key, source.path);
  }
  return files;
}

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
