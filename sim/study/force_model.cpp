// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/study/force_model.h"

#include <algorithm>

#include "sim/engine/common/energy_table.h"

namespace reamsim {

namespace {

Vec3 vector_of(const float* values) {
  return {double{values[0]}, double{values[1]}, double{values[2]}};
}

}  // namespace

double Recalibration::density(int grade) const {
  return now.density_from_hu(
      of_run.hu_from_density(DensityMapping::density_from_grade(static_cast<std::uint8_t>(grade))));
}

ForceConstants force_constants(const CuttingSettings& cutting, const std::optional<Recalibration>& recalibration) {
  ForceConstants out;
  for (int grade = 1; grade <= DensityMapping::kMaxGrade; ++grade) {
    const double density = recalibration ? recalibration->density(grade)
                                         : DensityMapping::density_from_grade(static_cast<std::uint8_t>(grade));
    out.specific_energy_n_mm2[static_cast<std::size_t>(grade)] = cutting_energy_mj(cutting, density, 1);
  }
  out.normal_ratio = cutting.normal_ratio;
  if (const auto& edge = cutting.edge_force) {
    out.edge_tangential_n_mm = edge->tangential_n_mm;
    out.edge_normal_n_mm = edge->normal_n_mm;
  }
  return out;
}

std::span<const BasisRow> ForceBasis::of(std::int64_t frame) const {
  const auto begin = std::ranges::lower_bound(rows_, frame, {}, &BasisRow::frame);
  return {begin, std::ranges::upper_bound(begin, rows_.end(), frame, {}, &BasisRow::frame)};
}

FrameForces ForceBasis::forces(std::int64_t frame, const ForceConstants& constants) const {
  FrameForces out;
  for (const BasisRow& row : of(frame)) {
    const bool edge = row.grade == 0;
    const double u =
        edge ? constants.edge_tangential_n_mm : constants.specific_energy_n_mm2[static_cast<std::size_t>(row.grade)];
    const double normal = edge ? constants.edge_normal_n_mm : u * constants.normal_ratio;
    out.force_n += u * vector_of(row.p_mm2) + normal * vector_of(row.n_mm2);
    out.torque_nmm += u * vector_of(row.p_torque_mm3) + normal * vector_of(row.n_torque_mm3);
    out.work_mj += u * double{row.p_work_mm3} + normal * double{row.n_work_mm3};
    out.energy_mj += u * double{row.energy_mm3};
    out.floor_energy_mj += u * double{row.floor_energy_mm3};
  }
  return out;
}

std::array<double, 256> ForceBasis::volume_mm3() const {
  std::array<double, 256> out{};
  for (const BasisRow& row : rows_) {
    if (row.grade > 0) out[static_cast<std::size_t>(row.grade)] += double{row.energy_mm3};
  }
  return out;
}

bool ForceBasis::has_edge() const {
  return std::ranges::any_of(rows_, [](const BasisRow& row) { return row.grade == 0; });
}

}  // namespace reamsim
