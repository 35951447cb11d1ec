// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "tests/cli/cli_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::HasSubstr;
using Json = nlohmann::ordered_json;

/// Commands with --json: standard output is one JSON document, whatever happens.
class JsonOutput : public CliTest {
 protected:
  Json call(const std::vector<std::string>& arguments, int status = 0) {
    last_ = reamsim({.arguments = arguments, .environment = {}, .folder = "", .interrupt_when = {}});
    EXPECT_EQ(last_.status, status) << last_.err;
    return Json::parse(last_.out);  // throws where it is anything else
  }
  ProgramResult last_;
};

TEST_F(JsonOutput, CheckOfAValidScenario) {
  write("s.yaml", kSmall);
  const Json found = call({"check", "s.yaml", "--json"});
  EXPECT_EQ(found["ok"], true);
  EXPECT_TRUE(found["mistakes"].empty());
  EXPECT_EQ(found["estimate"]["voxel_mm"], 0.5);
  EXPECT_NEAR(found["estimate"]["bone_mm3"].get<double>(), 600, 1e-6) << "10 x 10 x 6 mm";
  EXPECT_GT(found["estimate"]["frames"], 10);
  EXPECT_GT(found["estimate"]["simulate_s"], 0);
  EXPECT_GT(found["estimate"]["process_bytes"], 1e6);
  write("again.yaml", found["resolved"]);
  EXPECT_EQ(call({"check", "again.yaml", "--json"})["resolved"].get<std::string>().substr(0, 10), "version: 2");
}

TEST_F(JsonOutput, CheckNamesEveryMistake) {
  write("s.yaml", with(with(kSmall, "voxel_mm: 0.5", "voxel_mm: 9"), "feed_mm_s: 5", "feeding: 5"));
  const Json found = call({"check", "s.yaml", "--json"}, 2);
  EXPECT_EQ(found["ok"], false);
  ASSERT_GE(found["mistakes"].size(), 2U) << found;
  const Json& first = found["mistakes"][0];
  EXPECT_EQ(first["file"], "s.yaml");
  EXPECT_EQ(first["line"], 4);
  EXPECT_EQ(first["column"], 13);
  EXPECT_EQ(first["key"], "bone.voxel_mm");
  EXPECT_THAT(first["found"], HasSubstr("9"));
  EXPECT_THAT(first["expected"], HasSubstr("0.01 to 5"));
  EXPECT_EQ(found["mistakes"][1]["line"], 14);
  EXPECT_THAT(last_.err, HasSubstr("reamsim: error: s.yaml:4:13: bone.voxel_mm: found 9"))
      << "standard error is that of check without --json";
}

TEST_F(JsonOutput, CheckOfWarnings) {
  write("s.yaml", with(kSmall, "    retract_mm: 2\n", "    retract_mm: 2\n    spin_rpm: 0\n"));
  const Json found = call({"check", "s.yaml", "--json"});
  ASSERT_EQ(found["warnings"].size(), 1U) << found;
  EXPECT_THAT(found["warnings"][0], HasSubstr("spindle speed is zero"));
}

TEST_F(JsonOutput, AFileThatIsNotThere) {
  const Json found = call({"check", "nix.yaml", "--json"}, 2);
  EXPECT_EQ(found["mistakes"][0]["file"], "nix.yaml");
}

TEST_F(JsonOutput, Devices) {
  const Json found = call({"devices", "--json"});
  ASSERT_FALSE(found["devices"].empty());
  int selected = 0;
  for (const Json& device : found["devices"]) {
    EXPECT_GT(device["compute_units"], 0);
    EXPECT_TRUE(device["type"] == "cpu" || device["type"] == "gpu");
    if (device["selected"] == true) {
      ++selected;
      EXPECT_EQ(device["name"], found["auto"]);
    }
  }
  EXPECT_EQ(selected, 1);
}

TEST_F(JsonOutput, VerifyRefusesAFolderInJson) {
  std::filesystem::create_directory(path("out"));
  write("out/mine.txt", "mine");
  const Json found = call({"verify", "--quick", "-o", "out", "--overwrite", "--json"}, 2);
  EXPECT_THAT(found["mistakes"][0]["found"], HasSubstr("mine.txt"));
  EXPECT_EQ(read("out/mine.txt"), "mine");
}

}  // namespace
}  // namespace reamsim::test
