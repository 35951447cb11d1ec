// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/parse.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <memory>
#include <new>

#include "sim/base/text.h"
#include "sim/scenario/parse_steps.h"
#include "sim/scenario/show.h"
#include "sim/scenario/yaml_tree.h"

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
  const std::string literal(without_blanks(text, " \t\n"));
  return std::make_shared<YamlNode>(YamlNode{.kind = YamlNode::Kind::scalar, .mark = mark, .text = literal});
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
  const std::size_t index = whole_number(step).value_or(list.items.size());
  if (index >= list.items.size()) {
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
    // Names until 1.0.0, though no publication has these energies.
    constexpr std::array<std::string_view, 3> kOld{"literature-low", "literature-mid", "literature-high"};
    if (below != "cutting.preset" || std::ranges::find(kOld, entry.value->text) == kOld.end()) continue;
    const std::string name = "assumed-" + entry.value->text.substr(entry.value->text.find('-') + 1);
    notes.emplace_back(InputError(entry.mark.in(file), below, "outdated: write " + name, "").what());
    entry.value = with_text(*entry.value, name);
  }
  return copy;
}

/// Brings a scenario with keys of format version 1 to version 2: renames keys and drops those that have no effect any
/// more. Adds a note for each ("FILE:LINE:COLUMN: KEY: ..."). Throws InputError where a key is given under both names.
YamlNodePtr migrate(const YamlNodePtr& document, const std::string& file, std::vector<std::string>& notes) {
  const YamlNodePtr changed = changed_section(document, "", file, notes);
  const YamlEntry* version = changed->find("version");
  if (version == nullptr || !is_text(*version->value, "1")) return changed;
  auto copy = std::make_shared<YamlNode>(*changed);
  std::ranges::find(copy->entries, "version", &YamlEntry::key)->value =
      with_text(*version->value, std::to_string(kScenarioVersion));
  return copy;
}

/// The file's document, with overrides, in the present version of the format; `notes` gets a line for each key of an
/// older one. Throws InputError.
YamlNodePtr read_document(const std::string& path, const std::vector<std::string>& overrides,
                          std::vector<std::string>& notes) {
  const std::string file = shown_path(path);
  YamlNodePtr document = parse_yaml(read_scenario_text(path, YamlLimits::kMaxBytes), file);
  if (document->kind == YamlNode::Kind::null)
    refuse_file(file, "is empty", "expected a scenario with the keys version, bone, tool and motion");
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

namespace fs = std::filesystem;

/// "bone: {SOURCE: {path: PATH}}".
YamlNodePtr document_of_bone(const std::string& source, const std::string& path) {
  using Kind = YamlNode::Kind;
  auto node = std::make_shared<YamlNode>(YamlNode{.kind = Kind::scalar, .text = path, .quoted = true});
  for (const std::string& key : {std::string("path"), source, std::string("bone")}) {
    node = std::make_shared<YamlNode>(YamlNode{.kind = Kind::map, .entries = {{key, {}, node}}});
  }
  return node;
}

constexpr std::array kPowerLawKeys{"specific_energy_j_mm3", "reference_density_g_cm3", "density_exponent"};

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
    return std::ranges::any_of(
        overrides, [&](const std::string& text) { return text.starts_with(key + "=") || text.starts_with(key + "."); });
  };
  const bool preset = any_sets("cutting.preset"), table = any_sets("cutting.specific_energy_table");
  const auto is_drill = [](const std::string& text) { return text.starts_with("cutting.preset=drill"); };
  if (std::ranges::any_of(overrides, is_drill)) {  // such a preset sets these as well
    out = {"cutting.normal_ratio=null", "cutting.edge_force=null", "cutting.size_effect=null"};
  }
  if (preset || table) {
    for (const char* key : kPowerLawKeys) out.push_back(std::string("cutting.") + key + "=null");
    out.push_back(table ? "cutting.preset=null" : "cutting.specific_energy_table=null");
  }
  out.insert(out.end(), overrides.begin(), overrides.end());
  return out;
}

/// The block of a section in YAML: the line `head`, and the more indented lines after it. Empty where there is none.
struct Block {
  std::size_t begin = 0, end = 0;
};
Block block_of(const std::string& text, const std::string& head) {
  const std::size_t begin = ("\n" + text).find("\n" + head + "\n");
  if (begin == std::string::npos) return {};
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

}  // namespace

YamlNodePtr apply_override(const YamlNodePtr& document, const std::string& assignment) {
  return assign(document, take_apart(assignment), 0);
}

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
    refuse_file(shown_path(path), "not enough memory", "expected a scenario file (YAML)");
  }
}

ResultSettings parse_result_settings(const std::string& path, const std::vector<std::string>& overrides) {
  Scenario out;
  const YamlNodePtr document = read_document(path, overrides, out.notes);
  MistakeList mistakes;
  const auto describe = [](KeyVisitor& v, Scenario& scenario) {
    v.section("render", scenario.render, describe_render);
    v.section("cutting", scenario.cutting, describe_cutting);
    v.section("output", scenario.output, describe_output);
    // Of the tools the kind of spin. Their other keys name files, which are not required here.
    static constexpr auto spin = [](KeyVisitor& w, ToolSettings& tool) { w.key("spin", tool.spin, ""); };
    v.section("tool", scenario.tool, spin);
    v.section("motion", scenario.motion, [](KeyVisitor& w, MotionSettings& motion) {
      w.list("passes", motion.passes, [](KeyVisitor& x, PassSettings& pass) { x.section("tool", pass.tool, spin); });
    });
  };
  read_keys(document, shown_path(path), "", describe, out, mistakes);
  mistakes.throw_if_any();
  check_cameras(out, out.keys);
  const auto is_resolved = [](const PassSpec& pass) { return pass.tool.spin == ToolSpin::resolved; };
  const bool resolved = std::ranges::any_of(passes_of(out), is_resolved);
  return {out.render, out.cutting, out.output, resolved ? ToolSpin::resolved : ToolSpin::envelope};
}

BoneSettings parse_bone_settings(const std::string& source, const std::string& path,
                                 const std::vector<std::string>& overrides) {
  const std::string recorded = recorded_path(fs::absolute(path).lexically_normal().string());
  YamlNodePtr document = document_of_bone(source, recorded);
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

LawSettings parse_law_settings(const std::string& path, const std::vector<std::string>& overrides) {
  require_law_keys(overrides);
  Scenario scenario;
  const YamlNodePtr document = read_document(path, replacing_law(overrides), scenario.notes);
  MistakeList mistakes;
  const auto describe = [](KeyVisitor& v, Scenario& read) {
    v.section("cutting", read.cutting, describe_cutting);
    v.section("output", read.output, describe_output);
    v.section("engine", read.engine, describe_engine);
    // The other keys of the bone name files, which are not required here.
    v.section("bone", read.bone, [](KeyVisitor& w, BoneSettings& bone) {
      w.key("source", bone.source, "Source of the bone", {.required = true});
      w.section("density", bone.density, describe_density, "Relation from HU to density");
    });
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
