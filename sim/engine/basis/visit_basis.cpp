// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/basis/visit_basis.h"

#include <algorithm>
#include <cmath>

namespace reamsim {

namespace {

/// Units per mm², mm³ and, of the edge, mm: fine against a voxel's part, and room for 8·10⁶ of them.
constexpr double kBasisScale = 1099511627776.0;  // 2^40

}  // namespace

void BrickBasis::add(int substep, int grade, double factor, const BasisValues& values) {
  auto found = std::ranges::find(grades_, grade, &Grade::grade);
  if (found == grades_.end()) {
    grades_.push_back({grade, std::vector<BasisValues>(static_cast<std::size_t>(substeps_))});
    found = grades_.end() - 1;
  }
  BasisValues& sum = found->sums[static_cast<std::size_t>(substep)];
  for (std::size_t i = 0; i < kBasisValues; ++i) sum[i] += factor * values[i];
}

void VisitBasis::add(const BrickBasis& brick) {
  const std::lock_guard lock(mutex_);
  for (const BrickBasis::Grade& grade : brick.grades_) {
    for (std::size_t s = 0; s < grade.sums.size(); ++s) {
      Units& to = sums_[s * kGrades + static_cast<std::size_t>(grade.grade)];
      for (std::size_t i = 0; i < kBasisValues; ++i) to[i] += std::llround(grade.sums[s][i] * kBasisScale);
    }
  }
}

std::vector<SubstepBasis> VisitBasis::substeps() const {
  std::vector<SubstepBasis> out(sums_.size() / kGrades);
  for (std::size_t s = 0; s < out.size(); ++s) {
    for (std::size_t grade = 0; grade < kGrades; ++grade) {
      const Units& units = sums_[s * kGrades + grade];
      if (std::ranges::all_of(units, [](std::int64_t unit) { return unit == 0; })) continue;
      GradeBasis& basis = out[s].emplace_back(GradeBasis{static_cast<int>(grade), {}});
      for (std::size_t i = 0; i < kBasisValues; ++i) basis.values[i] = static_cast<double>(units[i]) / kBasisScale;
    }
  }
  return out;
}

}  // namespace reamsim
