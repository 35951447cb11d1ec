// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scenario/parse.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <new>
#include <utility>

#include "sim/base/error.h"
#include "sim/base/text.h"
#include "sim/scenario/parse_steps.h"
#include "sim/scenario/paths.h"
#include "sim/scenario/show.h"
#include "sim/scenario/yaml_tree.h"

namespace reamsim {

namespace {

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

/// What a CT is read from: for a DICOMDIR the folder that it indexes.
std::string ct_input(const std::string& path) {
  const fs::path file(path);
  const bool index = lower_case(file.filename().string()) == "dicomdir" && fs::is_regular_file(file);
  return index ? file.parent_path().string() : path;
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
