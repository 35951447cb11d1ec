// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/parse.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <new>
#include <utility>
#include <vector>

#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/scenario/parse_steps.h"
#include "sim/scenario/passes.h"
#include "sim/scenario/paths.h"
#include "sim/scenario/presets.h"
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

YamlNodePtr text_node(const std::string& text, const YamlMark& mark, bool quoted) {
  auto node = std::make_shared<YamlNode>();
  node->kind = YamlNode::Kind::scalar;
  node->mark = mark;
  node->text = text;
  node->quoted = quoted;
  return node;
}

/// A section of one key.
YamlNodePtr section_of(const std::string& key, YamlNodePtr value) {
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
    const fs::path absolute = fs::absolute(path).lexically_normal();
    require_recordable(absolute.string(), {file, 0, 0}, "");
    MistakeList mistakes;
    read_keys(document, file, absolute.parent_path().string(), describe_scenario, scenario, mistakes);
    apply_preset(scenario.keys, scenario.cutting);
    check_rules(scenario, scenario.keys, mistakes);
    mistakes.throw_if_any();
    scenario.file = absolute.string();
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
  Scenario out;
  const YamlNodePtr document = read_document(path, overrides, out.notes);
  MistakeList mistakes;
  const auto describe = [](KeyVisitor& v, Scenario& scenario) {
    v.section("render", scenario.render, describe_render);
    v.section("cutting", scenario.cutting, describe_cutting);
    v.section("output", scenario.output, describe_output);
  };
  read_keys(document, shown_path(path), "", describe, out, mistakes);
  mistakes.throw_if_any();
  check_cameras(out, out.keys);
  if (resolves_cutting_edges(*document)) out.tool.spin = ToolSpin::resolved;
  return {out.render, out.cutting, out.output, out.tool.spin};
}

BoneSettings parse_bone_settings(const std::string& source, const std::string& path,
                                 const std::vector<std::string>& overrides) {
  const std::string recorded = recorded_path(fs::absolute(path).lexically_normal().string());
  YamlNodePtr document = section_of("bone", section_of(source, section_of("path", text_node(recorded, {}, true))));
  document = apply_override(document, "bone.source=" + source);
  for (const auto& assignment : overrides) {
    document = apply_override(document, assignment);
    if (document->entries.size() > 1) {
      throw InputError("--set " + shown_path(assignment) + ": not a key of the bone section; expected bone.KEY=VALUE");
    }
  }
  MistakeList mistakes;
  Scenario scenario;
  const auto describe = [](KeyVisitor& v, Scenario& read) { v.section("bone", read.bone, describe_bone); };
  read_keys(document, shown_path(path), fs::current_path().string(), describe, scenario, mistakes);
  check_rules(scenario, scenario.keys, mistakes);
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
  return text_node(std::string(without_blanks(text, " \t\n")), mark, false);
}

Override take_apart(const std::string& assignment) {
  Override out;
  const std::string shown_assignment = "--set " + shown_path(assignment);
  out.mark.override_text = std::make_shared<const std::string>(shown_assignment);
  const std::size_t equals = assignment.find('=');
  if (equals == std::string::npos) out.fail("found no \"=\"", "expected --set key.path=value");
  out.path = split(assignment.substr(0, equals), '.');
  if (std::ranges::find(out.path, "") != out.path.end())
    out.fail("found an empty key", "expected --set key.path=value");
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

namespace {

constexpr std::array kPowerLawKeys{"specific_energy_j_mm3", "reference_density_g_cm3", "density_exponent"};

bool sets(const std::string& override, const std::string& key) {
  return override.starts_with(key + "=") || override.starts_with(key + ".");
}

/// Throws InputError for a key that the law does not have.
void require_law_keys(const std::vector<std::string>& overrides) {
  for (const std::string& override : overrides) {
    if (override.starts_with("cutting.") || override.starts_with("bone.density.")) continue;
    throw InputError({}, "--set", "found " + shown_text(override),
                     "expected cutting.KEY=VALUE or bone.density.KEY=VALUE; to change anything else, run the scenario "
                     "again");
  }
}

/// The overrides, after those that remove what a preset or a table in them replaces: the file of a run has every
/// default filled in, and its keys would take precedence.
std::vector<std::string> replacing_law(const std::vector<std::string>& overrides) {
  std::vector<std::string> out;
  const auto any_sets = [&](const std::string& key) {
    return std::ranges::any_of(overrides, [&](const std::string& text) { return sets(text, key); });
  };
  const bool preset = any_sets("cutting.preset"), table = any_sets("cutting.specific_energy_table");
  if (preset || table) {
    for (const char* key : kPowerLawKeys) out.push_back(std::string("cutting.") + key + "=null");
    out.push_back(table ? "cutting.preset=null" : "cutting.specific_energy_table=null");
  }
  out.insert(out.end(), overrides.begin(), overrides.end());
  return out;
}

/// The block of a section in YAML of block style: the line `head`, and the more indented lines after it. Empty where
/// there is none.
struct Block {
  std::size_t begin = 0, end = 0;
};
Block block_of(const std::string& text, const std::string& head) {
  std::size_t begin = text.starts_with(head + "\n") ? 0 : text.find("\n" + head + "\n");
  if (begin == std::string::npos) return {};
  begin += text.starts_with(head + "\n") ? 0 : 1;
  const std::size_t indent = head.find_first_not_of(' ');
  std::size_t end = text.find('\n', begin) + 1;
  while (end < text.size() && text.find_first_not_of(' ', end) - end > indent) end = text.find('\n', end) + 1;
  return {begin, end};
}

void replace_block(const std::string& head, const std::string& from, std::string& text) {
  const Block ours = block_of(text, head), theirs = block_of(from, head);
  if (ours.end > 0 && theirs.end > 0)
    text.replace(ours.begin, ours.end - ours.begin, from, theirs.begin, theirs.end - theirs.begin);
}

/// The part of `bone` that the law depends on. The other keys name files, which are not required here.
void describe_source_and_density(KeyVisitor& v, BoneSettings& bone) {
  v.key("source", bone.source, "Source of the bone", {.required = true});
  v.section("density", bone.density, describe_density, "Relation from HU to density");
}

}  // namespace

LawSettings parse_law_settings(const std::string& path, const std::vector<std::string>& overrides) {
  require_law_keys(overrides);
  Scenario scenario;
  const YamlNodePtr document = read_document(path, replacing_law(overrides), scenario.notes);
  MistakeList mistakes;
  const auto describe = [](KeyVisitor& v, Scenario& read) {
    v.section("cutting", read.cutting, describe_cutting);
    v.section("output", read.output, describe_output);
    v.section("engine", read.engine, describe_engine);
    v.section("bone", read.bone, describe_source_and_density);
  };
  read_keys(document, shown_path(path), "", describe, scenario, mistakes);
  apply_preset(scenario.keys, scenario.cutting);
  Scenario checked = scenario;
  checked.bone.source = BoneSource::vdb;  // the rules of the other sources need keys that are not read here
  check_rules(checked, scenario.keys, mistakes);
  mistakes.throw_if_any();
  LawSettings out{.cutting = scenario.cutting,
                  .density = scenario.bone.density,
                  .bone_source = name_of(scenario.bone.source),
                  .yaml = read_scenario_text(path, YamlLimits::kMaxBytes),
                  .force_basis = scenario.output.force_basis};
  const std::string changed = to_yaml(scenario);
  replace_block("cutting:", changed, out.yaml);
  replace_block("  density:", changed, out.yaml);
  return out;
}

}  // namespace reamsim
