// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The quick suite, case by case: every figure within its tolerance.
#include "sim/verify/suite.h"

#include <gtest/gtest.h>

#include <iostream>
#include <set>

#include "sim/base/error.h"

namespace reamsim::verify {
namespace {

std::vector<std::string> ids() {
  std::vector<std::string> out;
  for (const Case& known : cases()) out.emplace_back(known.id);
  return out;
}

class QuickCase : public ::testing::TestWithParam<std::string> {};

TEST_P(QuickCase, HoldsItsTolerances) {
  const CaseFindings found = run_case(GetParam(), {});
  EXPECT_EQ(found.id, GetParam());
  EXPECT_FALSE(found.title.empty());
  EXPECT_FALSE(found.scene.empty());
  EXPECT_FALSE(found.form.empty());
  EXPECT_FALSE(found.checks.empty());
  for (const Check& check : found.checks) {
    EXPECT_TRUE(check.passed()) << check.quantity << ": expected " << check.expected << ", found " << check.found
                                << ", error " << check.error() << ", tolerance " << check.tolerance;
    EXPECT_FALSE(check.measure != Measure::reported && check.reason.empty()) << check.quantity;
  }
  for (const Refinement& refinement : found.refinements) EXPECT_EQ(refinement.levels.size(), 4U) << refinement.quantity;
}

INSTANTIATE_TEST_SUITE_P(Verify, QuickCase, ::testing::ValuesIn(ids()),
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
  const auto all = ids();
  EXPECT_EQ(std::set<std::string>(all.begin(), all.end()).size(), all.size());
  EXPECT_GE(all.size(), 14U);
}

TEST(Suite, WrongCaseOrDeviceIsAnInputError) {
  EXPECT_THROW(run_case("no_such_case", {}), InputError);
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
