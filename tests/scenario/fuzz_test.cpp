// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <iostream>
#include <random>

#include "tests/scenario/scenario_fixture.h"

namespace reamsim::test {
namespace {

class Fuzz : public ScenarioTest {
 protected:
  /// Parses; InputError is fine if each mistake is one line, anything else fails the test. Returns whether it parsed.
  bool try_parse(const std::string& yaml, const std::vector<std::string>& overrides = {}) const {
    try {
      const Scenario s = parse(yaml, overrides);
      parse(to_yaml(s));
      return true;
    } catch (const InputError& error) {
      EXPECT_FALSE(error.mistakes().empty());
      for (const Mistake& mistake : error.mistakes()) {
        EXPECT_EQ(mistake.line().find_first_of("\n\r\t\x1b"), std::string::npos) << mistake.line();
        EXPECT_NE(mistake.line(), "");
      }
    } catch (const std::exception& error) {
      ADD_FAILURE() << "not an InputError: " << error.what() << "\n" << yaml;
    }
    return false;
  }
};

std::string mutate(std::string text, std::mt19937& random) {
  static const std::string kSyntax = "{}[],:#&*!|>'\"%@`-? \n\t0123456789.eE<~$";
  const auto pick = [&](std::size_t size) { return std::uniform_int_distribution<std::size_t>(0, size - 1)(random); };
  const std::size_t changes = 1 + pick(4);
  for (std::size_t i = 0; i < changes && !text.empty(); ++i) {
    const std::size_t at = pick(text.size());
    switch (pick(6)) {
      case 0:
        text[at] = static_cast<char>(pick(256));
        break;
      case 1:
        text[at] = kSyntax[pick(kSyntax.size())];
        break;
      case 2:
        text.insert(at, 1, kSyntax[pick(kSyntax.size())]);
        break;
      case 3:
        text.erase(at, 1 + pick(12));
        break;
      case 4:
        text.insert(at, text.substr(pick(text.size()), 1 + pick(40)));
        break;
      default:
        text[at] = static_cast<char>(text[at] ^ (1 << pick(8)));
    }
  }
  return text;
}

TEST_F(Fuzz, MutatedBytesGiveInputErrorsOnly) {
  constexpr unsigned kSeed = 20261121;
  constexpr int kRuns = 4000;
  std::cout << "seed " << kSeed << ", " << kRuns << " mutations\n";
  std::mt19937 random(kSeed);
  const std::string rich = with(kValid, "  voxel_mm: 0.5\n",
                                "  voxel_mm: &v 0.5\n  side: left\n  density: {ash_fraction: 0.6}\n"
                                "  glenoid: {center_mm: [0, 0, 0], normal: [0, 0, 1], superior: [0, 1, 0]}\n"
                                "  pilot_hole: {<<: {depth_mm: 3}, diameter_mm: 2.5}\n") +
                           "cutting: {law: energy, density_exponent: 2}\noutput:\n  dir: \"$${x}/\\u00e4\"\n";
  ASSERT_TRUE(try_parse(rich));
  int parsed = 0;
  for (int i = 0; i < kRuns; ++i) parsed += try_parse(mutate(rich, random)) ? 1 : 0;
  EXPECT_GT(parsed, 0) << "those that change a digit";
  EXPECT_LT(parsed, kRuns / 2);
}

TEST_F(Fuzz, EveryTruncation) {
  std::size_t parsed = 0;
  for (std::size_t size = 0; size < kValid.size(); ++size) parsed += try_parse(kValid.substr(0, size)) ? 1 : 0;
  EXPECT_LT(parsed, 50U) << "those without a part of the last keys";
}

TEST_F(Fuzz, RandomBytes) {
  std::mt19937 random(20261122);
  std::uniform_int_distribution<int> byte(0, 255);
  for (int i = 0; i < 500; ++i) {
    std::string text(static_cast<std::size_t>(byte(random)), ' ');
    for (char& c : text) c = static_cast<char>(byte(random));
    EXPECT_FALSE(try_parse(text) && !text.empty());
  }
}

TEST_F(Fuzz, MutatedOverrides) {
  std::mt19937 random(20261123);
  int parsed = 0;
  for (int i = 0; i < 1000; ++i) {
    const std::string assignment = i % 2 == 0 ? "motion.keyframes.1.position_mm=[0, 0, 5]" : "bone.phantom.size_mm.2=4";
    std::string mutated = mutate(assignment, random);
    parsed += try_parse(kValid, {mutated.substr(0, mutated.find('\0'))}) ? 1 : 0;
  }
  EXPECT_GT(parsed, 0) << "those that change a digit";
  EXPECT_LT(parsed, 500);
}

}  // namespace
}  // namespace reamsim::test
