// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <algorithm>
#include <array>

#include "sim/base/error.h"
#include "sim/scenario/describe_sections.h"
#include "sim/scenario/parse.h"
#include "sim/scenario/parse_steps.h"
#include "sim/scenario/paths.h"
#include "sim/scenario/presets.h"
#include "sim/scenario/reader.h"
#include "sim/scenario/show.h"
#include "sim/scenario/yaml_tree.h"

namespace reamsim {

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
  std::vector<std::string> unused_notes;
  const YamlNodePtr document = read_document(path, replacing_law(overrides), unused_notes);
  const std::string file = shown_path(path);
  MistakeList mistakes;
  reject_unknown_keys(*document, file, mistakes);
  ScenarioReader reader(document, file, "", mistakes);
  Scenario scenario;
  reader.section("cutting", scenario.cutting, describe_cutting);
  reader.section("output", scenario.output, describe_output);
  reader.section("engine", scenario.engine, describe_engine);
  reader.section("bone", scenario.bone, describe_source_and_density);
  apply_preset(reader.locations(), scenario.cutting);
  Scenario checked = scenario;
  checked.bone.source = BoneSource::vdb;  // the rules of the other sources need keys that are not read here
  check_rules(checked, reader.locations(), mistakes);
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
