#include "sim/scenario/parse.h"

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <new>
#include <system_error>

#include "sim/base/error.h"
#include "sim/scenario/key_visitor.h"
#include "sim/scenario/overrides.h"
#include "sim/scenario/reader.h"
#include "sim/scenario/rules.h"
#include "sim/scenario/show.h"
#include "sim/scenario/unknown_keys.h"
#include "sim/scenario/yaml_tree.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

constexpr const char* kExpectedFile = "expected a scenario file (YAML)";

/// The file's text, at most one byte more than a scenario may have.
std::string read_text(const std::string& path) {
  const SourceLocation where{shown_path(path), 0, 0};
  std::error_code error;
  const fs::file_status status = fs::status(path, error);
  if (path.empty() || status.type() == fs::file_type::not_found) {
    throw InputError(where, "", "no such file", kExpectedFile);
  }
  if (status.type() == fs::file_type::directory) throw InputError(where, "", "is a folder", kExpectedFile);
  errno = 0;
  std::ifstream stream(path, std::ios::binary);
  std::string text(YamlLimits::kMaxBytes + 1, '\0');
  if (stream) stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (!stream.is_open() || stream.bad()) {
    const std::string why = errno == 0 ? "" : " (" + std::generic_category().message(errno) + ")";
    throw InputError(where, "", "cannot be read" + why, kExpectedFile);
  }
  text.resize(static_cast<std::size_t>(stream.gcount()));
  return text;
}

YamlNodePtr read_document(const std::string& path, const std::vector<std::string>& overrides) {
  const std::string file = shown_path(path);
  YamlNodePtr document = parse_yaml(read_text(path), file);
  if (document->kind == YamlNode::Kind::null) {
    throw InputError({file, 0, 0}, "", "is empty", "expected a scenario with the keys version, bone, tool and motion");
  }
  if (document->kind != YamlNode::Kind::map) {
    throw InputError(document->mark.in(file), "", "found " + shown(*document), "expected \"key: value\" lines");
  }
  for (const auto& assignment : overrides) document = apply_override(document, assignment);
  return document;
}

}  // namespace

Scenario parse_scenario(const std::string& path, const std::vector<std::string>& overrides) {
  try {
    const YamlNodePtr document = read_document(path, overrides);
    const std::string file = shown_path(path);
    reject_unknown_keys(*document, file);
    const fs::path absolute = fs::absolute(path).lexically_normal();
    ScenarioReader reader(document, file, absolute.parent_path().string());
    Scenario scenario;
    describe_scenario(reader, scenario);
    check_rules(scenario, reader.locations());
    scenario.file = absolute.string();
    if (scenario.name.empty()) scenario.name = absolute.stem().string();
    return scenario;
  } catch (const std::bad_alloc&) {
    throw InputError({shown_path(path), 0, 0}, "", "needs more memory than there is", kExpectedFile);
  }
}

std::vector<std::pair<std::string, std::string>> input_files(const Scenario& scenario) {
  const BoneSettings& bone = scenario.bone;
  std::vector<std::pair<std::string, std::string>> files{{"scenario", scenario.file}};
  if (bone.source == "ct") {
    files.emplace_back("bone.ct.path", bone.ct.path);
    if (bone.ct.label_map) files.emplace_back("bone.ct.label_map.path", bone.ct.label_map->path);
  }
  if (bone.source == "mesh") files.emplace_back("bone.mesh.path", bone.mesh.path);
  if (bone.source == "vdb") files.emplace_back("bone.vdb.path", bone.vdb.path);
  files.emplace_back("tool.mesh", scenario.tool.mesh);
  if (scenario.motion.csv) files.emplace_back("motion.csv.path", scenario.motion.csv->path);
  return files;
}

}  // namespace reamsim
