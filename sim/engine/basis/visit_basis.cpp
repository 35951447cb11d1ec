// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/basis/visit_basis.h"

#include <algorithm>
#include <cmath>

namespace reamsim {

namespace {

/// Force, torque and energy of the sums, in N, N·mm and mJ.
void add_edge(const LaneSums& sums, std::size_t first, BasisValues& out) {
  for (std::size_t i = 0; i < 3; ++i) {
    out[first + i] = static_cast<double>(sums.force[i]) / RS_FORCE_SCALE;
    out[first + 3 + i] = static_cast<double>(sums.torque[i]) / RS_TORQUE_SCALE;
  }
  out[12] += static_cast<double>(sums.energy) / RS_ENERGY_SCALE;
}

}  // namespace

UnitArgs::UnitArgs(const SubstepArgs& args, float edges_per_turn)
    : without_normal(args), with_normal(args), edge_along(args), edge_normal(args) {
  without_normal.normal_ratio = 0;
  with_normal.normal_ratio = 1;
  edge_along.edge_tangential = edge_normal.edge_normal = edges_per_turn;
  edge_along.edge_normal = edge_normal.edge_tangential = 0;
}

BasisValues unit_response(const UnitArgs& args, const Clip& clip, float volume_mm3) {
  float without[RS_WINDOW_SUMS], with[RS_WINDOW_SUMS];
  rs_window_response(&args.without_normal, &clip, volume_mm3, without);
  rs_window_response(&args.with_normal, &clip, volume_mm3, with);
  BasisValues out{};
  for (std::size_t i = 0; i < RS_SUM_OF_ENERGY; ++i) {
    out[i] = double{without[i]};
    out[6 + i] = double{with[i]} - double{without[i]};
  }
  out[12] = double{without[RS_SUM_OF_ENERGY]};
  out[13] = double{without[RS_SUM_OF_FLOOR]};
  return out;
}

BasisValues edge_response(const UnitArgs& args, const Clip& clip, rs_i32 remaining, rs_i32 outside) {
  LaneSums along{}, normal{};
  rs_edge_force(&args.edge_along, &clip, remaining, outside, &along);
  rs_edge_force(&args.edge_normal, &clip, remaining, outside, &normal);
  BasisValues out{};
  add_edge(along, 0, out);
  add_edge(normal, 6, out);
  return out;
}

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
