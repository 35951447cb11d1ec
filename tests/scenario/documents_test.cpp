// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>

#include <array>
#include <cstdio>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>

#include "sim/scenario/show.h"
#include "sim/scenario/yaml_tree.h"
#include "tests/scenario/key_documents.h"
#include "tests/scenario/scenario_fixture.h"

namespace reamsim::test {
namespace {

const std::string kRoot = REAMSIM_ROOT;

std::string file_text(const std::string& file) {
  std::ifstream stream(file, std::ios::binary);
  EXPECT_TRUE(stream) << file;
  return {std::istreambuf_iterator<char>(stream), {}};
}

nlohmann::json to_json(const YamlNode& node) {
  nlohmann::json out;
  switch (node.kind) {
    case YamlNode::Kind::null:
      return nullptr;
    case YamlNode::Kind::sequence:
      out = nlohmann::json::array();
      for (const auto& item : node.items) out.push_back(to_json(*item));
      return out;
    case YamlNode::Kind::map:
      out = nlohmann::json::object();
      for (const auto& entry : node.entries) out[entry.key] = to_json(*entry.value);
      return out;
    case YamlNode::Kind::scalar:
      break;
  }
  if (node.quoted) return node.text;
  if (node.text == "true" || node.text == "false") return node.text == "true";
  const bool whole = node.text.find_first_not_of("-0123456789") == std::string::npos;
  if (const auto value = parse_number(node.text))
    return whole ? nlohmann::json(std::stoll(node.text)) : nlohmann::json(*value);
  return node.text;
}

/// What Debian's python3-jsonschema says of documents.
class SchemaTest : public ScenarioTest {
 protected:
  /// One line per document: "ok", or the first complaint.
  std::vector<std::string> verdicts(const std::vector<std::string>& yamls) const {
    nlohmann::json documents = nlohmann::json::array();
    for (const auto& yaml : yamls) documents.push_back(to_json(*parse_yaml(yaml, "document")));
    write("schema.json", scenario_json_schema());
    write("documents.json", documents.dump());
    write("validate.py",
          "import json, sys\n"
          "from jsonschema import Draft7Validator\n"
          "schema = json.load(open(sys.argv[1]))\n"
          "Draft7Validator.check_schema(schema)\n"
          "for document in json.load(open(sys.argv[2])):\n"
          "    errors = sorted(Draft7Validator(schema).iter_errors(document), key=str)\n"
          "    print(repr(errors[0].message) if errors else 'ok')\n");
    const std::string command =
        "python3 -W ignore " + path("validate.py") + " " + path("schema.json") + " " + path("documents.json") + " 2>&1";
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
    std::string output;
    std::array<char, 4096> buffer{};
    while (std::fgets(buffer.data(), buffer.size(), pipe.get()) != nullptr) output += buffer.data();
    std::vector<std::string> lines;
    for (std::size_t at = 0; at < output.size();) {
      const std::size_t end = output.find('\n', at);
      lines.push_back(output.substr(at, end - at));
      at = end == std::string::npos ? output.size() : end + 1;
    }
    EXPECT_EQ(lines.size(), yamls.size()) << output << "(this test needs python3-jsonschema)";
    lines.resize(yamls.size());
    return lines;
  }
};

TEST(Documents, SchemaFileIsInStep) {
  EXPECT_TRUE(file_text(kRoot + "/assets/scenario.schema.json") == scenario_json_schema())
      << "run: ninja -C BUILD generate_scenario_docs";
}

TEST(Documents, SchemaOfStudiesIsInStep) {
  const std::string schema = file_text(kRoot + "/assets/study.schema.json");
  EXPECT_TRUE(schema == study_json_schema(schema)) << "run: ninja -C BUILD generate_scenario_docs";
}

TEST(Documents, KeyTableIsInStep) {
  const std::string page = file_text(kRoot + "/docs/keys.md");
  const std::string begin = "<!-- keys: begin -->\n";
  const std::size_t from = page.find(begin), to = page.find("<!-- keys: end -->");
  ASSERT_NE(from, std::string::npos);
  ASSERT_NE(to, std::string::npos);
  EXPECT_TRUE(page.substr(from + begin.size(), to - from - begin.size()) == scenario_key_table())
      << "run: ninja -C BUILD generate_scenario_docs";
}

TEST(Documents, EveryKeyIsInTheTable) {
  const std::string table = scenario_key_table();
  for (const char* key : {"version", "bone.ct.cut_spheres[].radius_mm", "motion.keyframes[].quaternion",
                          "motion.plunge.feed_mm_s", "output.vti", "bone.glenoid.landmarks.inferior_angle_mm"}) {
    EXPECT_NE(table.find("| `" + std::string(key) + "` |"), std::string::npos) << key;
  }
}

TEST_F(SchemaTest, AgreesWithTheParser) {
  const std::string half =
      "  source: phantom\n  voxel_mm: 0.5\n  phantom:\n    shape: half_space\n    size_mm: [10, 10, 6]\n";
  const std::vector<std::string> good{
      kValid,
      with(kValid, half, "  source: phantom\n  side: left\n"),
      with(kValid, half, "  source: mesh\n  mesh: {path: tool.stl}\n"),
      with(kValid, half, "  source: ct\n  ct: {path: tool.stl, label_map: {path: tool.stl}}\n"),
      with(kValid, half, "  source: ct\n  ct: {path: tool.stl, label_map: {path: tool.stl, label: 3}, series: 2}\n"),
      with(kValid, half,
           "  source: ct\n  ct: {path: tool.stl, label_map: {path: tool.stl, label: [3, scapula]}, series: 1.2.8}\n"),
      with(kValid, "axis: [0, 0, 1]", "quaternion: [1, 0, 0, 0]"),
      kValid +
          "cutting: {preset: assumed-low, erosion: exact, edge_force: {tangential_n_mm: 1, normal_n_mm: 0, "
          "cutting_edges: 6}}\n",
      to_yaml(parse(kValid)),
  };
  const std::vector<std::string> bad{
      with(kValid, "version: 2\n", ""),
      with(kValid, "version: 2", "version: 3"),
      with(kValid, "version: 2", "version: one"),
      with(kValid, "voxel_mm: 0.5", "voxl_mm: 0.5"),
      with(kValid, "voxel_mm: 0.5", "voxel_mm: 0"),
      with(kValid, "voxel_mm: 0.5", "voxel_mm: \"0.5\""),
      with(kValid, "voxel_mm: 0.5", "voxel_mm:"),
      with(kValid, "source: phantom", "source: mri"),
      with(kValid, "source: phantom", "source: mesh"),
      with(kValid, "shape: half_space", "shape: sphere"),
      with(kValid, "    shape: half_space\n", ""),
      with(kValid, half, "  source: ct\n"),
      with(kValid, half, "  source: ct\n  ct: {path: tool.stl, label_map: {path: tool.stl}, seed_mm: [1, 2, 3]}\n"),
      with(kValid, half, "  source: ct\n  ct: {path: tool.stl, label_map: {path: tool.stl, label: []}}\n"),
      with(kValid, half, "  source: ct\n  ct: {path: tool.stl, label_map: {path: tool.stl, label: 1.5}}\n"),
      with(kValid, half, "  source: ct\n  ct: {path: tool.stl, modality: mr}\n"),
      with(kValid, "[10, 10, 6]", "[10, 10]"),
      with(kValid, "motion:\n", "motion:\n  plunge: {feed_mm_s: 1}\n"),
      with(kValid, "axis: [0, 0, 1]}\n", "axis: [0, 0, 1], quaternion: [1, 0, 0, 0]}\n"),
      with(kValid, "enabled: false", "cameras: [oblique, oblique]"),
      with(kValid, "enabled: false", "cameras: []"),
      with(kValid, "enabled: false", "enabled: no"),
      kValid + "engine: {type: fast}\n",
      kValid + "cutting: {speed_floor_mm_s: 0}\n",
      kValid + "cutting: {preset: literature}\n",
      kValid +
          "cutting: {erosion: exact, size_effect: {exponent: 0.3, reference_mm: 0.05, cutting_edges: 6}, edge_force: "
          "{tangential_n_mm: 1, normal_n_mm: 0, cutting_edges: 6}}\n",
      kValid + "cutting: {erosion: wear, edge_force: {tangential_n_mm: 1, normal_n_mm: 0, cutting_edges: 6}}\n",
      kValid +
          "cutting: {specific_energy_j_mm3: 0.1, specific_energy_table: [{density_g_cm3: 0, energy_j_mm3: 0}, "
          "{density_g_cm3: 1, energy_j_mm3: 1}]}\n",
      with(kValid, "voxel_mm: 0.5",
           "glenoid: {center_mm: [0, 0, 0], landmarks: {glenoid_center_mm: [0, 0, 0], "
           "trigonum_spinae_mm: [9, 0, 0], inferior_angle_mm: [0, 9, 0]}}"),
  };
  std::vector<std::string> all = good;
  all.insert(all.end(), bad.begin(), bad.end());
  const std::vector<std::string> said = verdicts(all);
  for (std::size_t i = 0; i < all.size(); ++i) {
    const bool is_good = i < good.size();
    EXPECT_EQ(said[i] == "ok", is_good) << "schema: " << said[i] << "\n" << all[i];
    EXPECT_EQ(complaint(all[i]).empty(), is_good) << "parser: " << complaint(all[i]) << "\n" << all[i];
  }
}

TEST_F(SchemaTest, ShippedTrajectoriesAreValid) {
  std::vector<std::string> files, yamls;
  for (const auto& entry : std::filesystem::directory_iterator(kRoot + "/trajectories")) {
    if (entry.path().extension() != ".yaml") continue;
    files.push_back(entry.path().string());
    yamls.push_back(file_text(files.back()));
  }
  ASSERT_FALSE(files.empty()) << "no trajectories/*.yaml";
  const std::vector<std::string> said = verdicts(yamls);
  for (std::size_t i = 0; i < files.size(); ++i) EXPECT_EQ(said[i], "ok") << files[i];
}

}  // namespace
}  // namespace reamsim::test
