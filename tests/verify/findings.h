// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// What every case of the quick suite must give.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "sim/base/error.h"
#include "sim/verify/suite.h"

namespace reamsim::verify {

inline std::vector<std::string> case_ids() {
  std::vector<std::string> out;
  for (const Case& known : cases()) out.emplace_back(known.id);
  return out;
}

inline CaseFindings run_case(const std::string& id, const Setting& setting) {
  const auto found = std::ranges::find(cases(), id, &Case::id);
  if (found == cases().end()) throw InputError("no verification case " + id);
  return found->findings(setting);
}

/// Every figure is within its tolerance, and every text of the report is there.
inline void expect_complete_and_passed(const CaseFindings& found, const std::string& id) {
  EXPECT_EQ(found.id, id);
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

}  // namespace reamsim::verify
