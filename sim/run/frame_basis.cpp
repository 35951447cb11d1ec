// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/run/frame_basis.h"

#include <map>

#include "sim/bone/voxmap/density.h"

namespace reamsim {

namespace {

/// Sums of one grade over the substeps of a frame, in B.
struct FrameSums {
  Vec3 p = Vec3::Zero(), p_torque = Vec3::Zero(), n = Vec3::Zero(), n_torque = Vec3::Zero();
  double p_work = 0, n_work = 0, energy = 0, floor_energy = 0;
};

double work_of(const Substep& substep, const Vec3& force, const Vec3& torque) {
  return -(torque.dot(substep.angular_velocity) + force.dot(substep.origin_velocity_mm_s)) * substep.duration_s;
}

void add_substep(const Substep& substep, int substeps, const GradeBasis& basis, FrameSums& sums) {
  const Mat3 bone_from_tool = bone_from_shell(substep.pose, false).linear();
  const Vec3 p = bone_from_tool * basis.force(), p_torque = bone_from_tool * basis.torque();
  const Vec3 n = bone_from_tool * basis.normal_force(), n_torque = bone_from_tool * basis.normal_torque();
  sums.p += p / substeps;
  sums.p_torque += p_torque / substeps;
  sums.n += n / substeps;
  sums.n_torque += n_torque / substeps;
  sums.p_work += work_of(substep, p, p_torque);
  sums.n_work += work_of(substep, n, n_torque);
  sums.energy += basis.energy();
  sums.floor_energy += basis.floor_energy();
}

BasisRow row_of(std::int64_t frame, int grade, const FrameSums& sums) {
  BasisRow row;
  row.frame = static_cast<std::int32_t>(frame);
  row.grade = grade;
  row.density_g_cm3 = static_cast<float>(DensityMapping::density_from_grade(static_cast<std::uint8_t>(grade)));
  for (int i = 0; i < 3; ++i) {
    row.p_mm2[i] = static_cast<float>(sums.p[i]);
    row.p_torque_mm3[i] = static_cast<float>(sums.p_torque[i]);
    row.n_mm2[i] = static_cast<float>(sums.n[i]);
    row.n_torque_mm3[i] = static_cast<float>(sums.n_torque[i]);
  }
  row.p_work_mm3 = static_cast<float>(sums.p_work);
  row.n_work_mm3 = static_cast<float>(sums.n_work);
  row.energy_mm3 = static_cast<float>(sums.energy);
  row.floor_energy_mm3 = static_cast<float>(sums.floor_energy);
  return row;
}

}  // namespace

std::vector<BasisRow> basis_rows(const PendingFrame& frame, const std::vector<SubstepBasis>& substeps) {
  std::map<int, FrameSums> by_grade;
  for (const auto& [place, substep] : frame.cut) {
    for (const GradeBasis& basis : substeps[place]) add_substep(substep, frame.substeps, basis, by_grade[basis.grade]);
  }
  std::vector<BasisRow> rows;
  for (const auto& [grade, sums] : by_grade) rows.push_back(row_of(frame.frame, grade, sums));
  return rows;
}

}  // namespace reamsim
