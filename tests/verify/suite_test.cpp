// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The quick suite of the tool on springs, and the suite as a whole.
#include "sim/verify/suite.h"

#include <gtest/gtest.h>

#include <iostream>
#include <set>

#include "sim/base/error.h"
#include "tests/verify/findings.h"

namespace reamsim::verify {
namespace {

/// The cases of a tool on springs, which has no windows; WindowsAgree runs the others.
std::vector<std::string> compliance_ids() {
  std::vector<std::string> out = case_ids();
  std::erase_if(out, [](const std::string& id) { return !id.starts_with("compliance_"); });
  return out;
}

class QuickCase : public ::testing::TestWithParam<std::string> {};

TEST_P(QuickCase, HoldsItsTolerances) {
  expect_complete_and_passed(run_case(GetParam(), {}), GetParam());
}

INSTANTIATE_TEST_SUITE_P(Verify, QuickCase, ::testing::ValuesIn(compliance_ids()),
                         [](const auto& chosen) { return chosen.param; });

/// The whole way of the pushed ball, which the quick suite leaves early.
TEST(Suite, PushedBallToFourMillimetres) {
  const CaseFindings found = run_case("push_ball", {.quick = false});
  ASSERT_EQ(found.checks.size(), 2U);
  EXPECT_NEAR(found.checks[0].expected, 1.793, 1e-3);
  EXPECT_NEAR(found.checks[1].expected, 13.80, 5e-3);
  for (const Check& check : found.checks) {
    EXPECT_TRUE(check.passed()) << check.quantity << ": expected " << check.expected << ", found " << check.found;
    std::cout << check.quantity << ": expected " << check.expected << ", found " << check.found << '\n';
  }
}

TEST(Suite, EveryCaseOnce) {
  const auto all = case_ids();
  EXPECT_EQ(std::set<std::string>(all.begin(), all.end()).size(), all.size());
  EXPECT_GE(all.size(), 14U);
}

TEST(Suite, WrongDeviceIsAnInputError) {
  Setting setting;
  setting.device = "no such device";
  EXPECT_THROW(run_case("energy", setting), InputError);
}

TEST(Suite, StopsWhenAsked) {
  Setting setting;
  setting.stop = [] { return true; };
  EXPECT_THROW(run_suite(setting), Interrupted);
}

}  // namespace
}  // namespace reamsim::verify
