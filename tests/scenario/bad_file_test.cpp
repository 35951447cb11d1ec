// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <gmock/gmock.h>

#include "sim/scenario/yaml_tree.h"
#include "tests/scenario/scenario_fixture.h"

namespace reamsim::test {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

class BadFile : public ScenarioTest {};

TEST_F(BadFile, DoesNotExist) {
  EXPECT_EQ(complaint_of_file("nix.yaml"), "nix.yaml: no such file; expected a scenario file (YAML)");
}

TEST_F(BadFile, EmptyName) {
  EXPECT_THROW(parse_scenario("", {}), InputError);
}

TEST_F(BadFile, IsAFolder) {
  std::filesystem::create_directory(path("sub"));
  EXPECT_EQ(complaint_of_file("sub"), "sub: is a folder; expected a scenario file (YAML)");
}

TEST_F(BadFile, LiesBelowAFile) {
  EXPECT_EQ(complaint_of_file("tool.stl/s.yaml"), "tool.stl/s.yaml: no such file; expected a scenario file (YAML)");
}

TEST_F(BadFile, IsEmptyOrOnlyComments) {
  const std::string expected = "s.yaml: is empty; expected a scenario with the keys version, bone, tool and motion";
  EXPECT_EQ(complaint(""), expected);
  EXPECT_EQ(complaint("# nothing\n\n---\n"), expected);
}

TEST_F(BadFile, IsNoSection) {
  EXPECT_EQ(complaint("hello\n"), "s.yaml:1:1: found the text \"hello\"; expected \"key: value\" lines");
  EXPECT_EQ(complaint("- 1\n- 2\n"), "s.yaml:1:1: found a list of 2; expected \"key: value\" lines");
}

TEST_F(BadFile, SyntaxErrorsNameLineAndColumnInOurWords) {
  EXPECT_EQ(complaint("version: 2\nbone: {source: phantom\n"),
            "s.yaml:2:7: YAML syntax error: a \"{\" that is not closed; expected \"}\"");
  EXPECT_EQ(
      complaint("version: 2\nbone: a: b\n"),
      "s.yaml:2:8: YAML syntax error: a \":\" where no key can be; expected one \"key: value\" per line, with even "
      "indentation, and texts that hold \": \" in quotes");
  EXPECT_EQ(complaint("version: 2\nbone:\n \tsource: ct\n"),
            "s.yaml:3:2: YAML syntax error: a tab in the indentation; expected spaces");
  EXPECT_THAT(complaint("version: \"1\n"), StartsWith("s.yaml:1:"));
  EXPECT_THAT(complaint("version: *x\n"), StartsWith("s.yaml:1:10: YAML syntax error: an alias (*name) without"));
  EXPECT_THAT(complaint("version: 2\n- a\n"), StartsWith("s.yaml:2:1: YAML syntax error: a line that does not"));
  EXPECT_THAT(complaint("name: \"\\q\"\n"), StartsWith("s.yaml:1:10: YAML syntax error: an unknown escape"));
}

TEST_F(BadFile, NeverShowsTheLibrarysPrefix) {
  for (const char* text :
       {"a: [1,", "a: b: c", "a: \"x", "*", "&", "%TAG !\n", "%YAML 9.9\n---\na", "a: @x", "? [", "]"}) {
    const std::string message = complaint(text);
    EXPECT_THAT(message, AllOf(StartsWith("s.yaml:"), Not(HasSubstr("yaml-cpp")), Not(HasSubstr("\n")))) << text;
  }
}

TEST_F(BadFile, ColumnsCountCharacters) {
  EXPECT_EQ(complaint(with(kValid, "source: phantom", "\"söurce\": phantom")),
            "s.yaml:3:3: bone.\"söurce\": unknown key; did you mean source?");
  EXPECT_THAT(complaint("version: 2\nbone: {side: \"ä\", vöxel_mm: 1}\n"), HasSubstr("s.yaml:2:19:"));
}

TEST_F(BadFile, BinaryGarbage) {
  EXPECT_EQ(complaint(std::string("version: 2\nbo\0ne: 3\n", 20)),
            "s.yaml:2:3: found the byte \"\\x00\": not a text file; expected YAML in UTF-8");
  EXPECT_EQ(complaint("\x89PNG\r\n\x1a\n"),
            "s.yaml:1:1: found the byte \"\\x89\": not a text file; expected YAML in UTF-8");
  EXPECT_THAT(complaint("name: \"\xC0\x80\"\n"), StartsWith("s.yaml:1:8: found the byte \"\\xc0\""));
}

TEST_F(BadFile, ByteOrderMarkAndCarriageReturnsAreFine) {
  std::string windows = "\xEF\xBB\xBF";
  for (const char c : kValid) windows += c == '\n' ? std::string("\r\n") : std::string(1, c);
  EXPECT_EQ(complaint(windows), "");
}

TEST_F(BadFile, TooLarge) {
  EXPECT_EQ(complaint(kValid + std::string(YamlLimits::kMaxBytes, '#')),
            "s.yaml: larger than 4 MiB; expected a scenario (put long recordings into motion.csv)");
}

TEST_F(BadFile, TooDeep) {
  EXPECT_EQ(complaint("a: " + std::string(200'000, '[')),
            "s.yaml:1:20: more than 32 levels of nesting; expected the few levels of a scenario");
  std::string dashes;
  for (int i = 0; i < 100'000; ++i) dashes += "- ";
  EXPECT_THAT(complaint(dashes), HasSubstr("more than 32 levels"));
}

TEST_F(BadFile, AliasesCannotBlowUp) {
  std::string bomb = "version: 2\nx0: &x0 [1]\n";
  for (int i = 1; i < 30; ++i) {
    const std::string last = "*x" + std::to_string(i - 1);
    bomb += "x" + std::to_string(i) + ": &x" + std::to_string(i) + " [";
    for (int j = 0; j < 9; ++j) bomb += last + ", ";
    bomb += last + "]\n";
  }
  EXPECT_THAT(complaint(bomb), HasSubstr("x0: unknown key"));
  std::string chain = "x0: &x0 [1]\n";
  for (int i = 1; i < 50'000; ++i) {
    chain += "x" + std::to_string(i) + ": &x" + std::to_string(i) + " [*x" + std::to_string(i - 1) + "]\n";
  }
  EXPECT_THAT(complaint(chain), HasSubstr("levels of nesting through aliases"));
}

TEST_F(BadFile, MergesCannotBlowUp) {
  std::string bomb = "a: &a {";
  for (int i = 0; i < 1000; ++i) bomb += "k" + std::to_string(i) + ": 1, ";
  bomb += "}\nb:\n  <<: [";
  for (int i = 0; i < 2000; ++i) bomb += "*a, ";
  EXPECT_THAT(complaint(bomb + "]\n"), HasSubstr("more than 500000 values"));
}

TEST_F(BadFile, AliasOfItself) {
  EXPECT_EQ(
      complaint("version: 2\nbone: &b {ct: *b}\n"),
      "s.yaml:2:15: an alias that refers to the section that contains it; expected an alias of something complete");
}

TEST_F(BadFile, DuplicateKey) {
  EXPECT_EQ(complaint(with(kValid, "  phantom:\n", "  voxel_mm: 1\n  phantom:\n")),
            "s.yaml:5:3: voxel_mm: duplicate key; give it once; it is on line 4 already");
}

TEST_F(BadFile, KeysThatAreNoNames) {
  EXPECT_EQ(complaint("? [a]\n: b\n"), "s.yaml:1:3: found a list of 1 instead of a key; expected a key name");
  EXPECT_THAT(complaint(": a\n"), HasSubstr("found nothing instead of a key"));
}

TEST_F(BadFile, SecondDocumentAndTags) {
  EXPECT_THAT(complaint(kValid + "---\nversion: 2\n"), HasSubstr("a second YAML document begins here"));
  EXPECT_EQ(complaint(with(kValid, "voxel_mm: 0.5", "voxel_mm: !!float 0.5")),
            "s.yaml:4:13: found the YAML tag \"tag:yaml.org,2002:float\"; expected a value without a tag");
}

TEST_F(BadFile, AnchorsAndMergeKeysWork) {
  const std::string yaml = with(kValid,
                                "    - {time_s: 0, position_mm: [0, 0, 1], axis: [0, 0, 1]}\n"
                                "    - {time_s: 1, position_mm: [0, 0, -1], axis: [0, 0, 1]}\n",
                                "    - &first {time_s: 0, position_mm: [0, 0, 1], axis: &up [0, 0, 1], spin_rpm: 9}\n"
                                "    - {<<: *first, time_s: 1}\n"
                                "    - {time_s: 2, position_mm: [1, 0, 1], axis: *up}\n");
  const Scenario s = parse(yaml);
  ASSERT_EQ(s.motion.keyframes.size(), 3u);
  EXPECT_EQ(s.motion.keyframes[1].time_s, 1);
  EXPECT_EQ(s.motion.keyframes[1].spin_rpm, 9);
  EXPECT_EQ(*s.motion.keyframes[2].axis, Vec3(0, 0, 1));
  EXPECT_EQ(s.motion.keyframes[2].spin_rpm, 0);
}

}  // namespace
}  // namespace reamsim::test
