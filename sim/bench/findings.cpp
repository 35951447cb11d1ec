// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bench/findings.h"

#include <algorithm>

namespace reamsim::bench {

Spread spread_of(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const std::size_t n = values.size(), middle = n / 2;
  const double median = n % 2 == 1 ? values[middle] : (values[middle - 1] + values[middle]) / 2;
  return {median, values.front(), values.back(), static_cast<int>(n)};
}

const CaseRow* Findings::find(const Label& who, int voxmap, int shell, const std::string& contact) const {
  const auto row = std::find_if(cases.begin(), cases.end(), [&](const CaseRow& r) {
    return r.at.who.engine == who.engine && r.at.who.variant == who.variant && r.at.voxmap == voxmap &&
           r.at.shell == shell && r.at.contact == contact;
  });
  return row == cases.end() ? nullptr : &*row;
}

}  // namespace reamsim::bench
