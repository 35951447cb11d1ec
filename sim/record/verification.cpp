// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/verification.h"

#include <algorithm>
#include <cmath>

namespace reamsim::verify {

double Check::error() const {
  return measure == Measure::relative ? found / expected - 1 : found - expected;
}

bool Check::passed() const {
  switch (measure) {
    case Measure::relative:
    case Measure::absolute:
      return std::abs(error()) <= tolerance;
    case Measure::at_least:
      return found >= expected;
    case Measure::at_most:
      return found <= expected;
    case Measure::reported:
      return !std::isnan(found);
  }
  return false;
}

bool CaseFindings::passed() const {
  return std::all_of(checks.begin(), checks.end(), [](const Check& check) { return check.passed(); });
}

bool Findings::passed() const {
  return failed_checks() == 0;
}

int Findings::failed_checks() const {
  int failed = 0;
  for (const CaseFindings& row : cases) {
    failed += static_cast<int>(
        std::count_if(row.checks.begin(), row.checks.end(), [](const Check& check) { return !check.passed(); }));
  }
  return failed;
}

}  // namespace reamsim::verify
