// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/run/frame_stepper.h"

#include <numbers>

namespace reamsim {

namespace {

constexpr double kRadPerRpm_s = 2 * std::numbers::pi / 60;

/// The tool's origin at the beginning of a substep, B.
Vec3 start_of(const Substep& substep, const PendingFrame& frame) {
  if (frame.substeps == 1) return frame.before.position_mm;
  return substep.pose.position_mm - substep.duration_s * substep.origin_velocity_mm_s;
}

}  // namespace

FrameResult EnergyBalance::close(const PendingFrame& frame, const std::vector<SubstepSums>& sums) {
  FrameResult out;
  out.frame = frame.frame;
  out.pass = frame.pass;
  out.time_s = frame.time_s;
  out.push = frame.push;
  out.deflection_mm = frame.deflection_mm;
  out.pose = frame.pose;
  rs_i64 removed = 0;
  std::optional<Vec3> touched_from_mm;  // where the first substep with contact begins
  for (const auto& [slot, substep] : frame.cut) {
    const SubstepSums& sum = sums[slot];
    const Mat3 bone_from_sums = bone_from_shell(substep.pose, sums_rotate_).linear();
    const Vec3 force = bone_from_sums * force_of(sum);
    const Vec3 torque = bone_from_sums * torque_of(sum);
    run_.work_mj += work_of(substep, force, torque);
    out.force_n += force / frame.substeps;
    out.torque_nmm += torque / frame.substeps;
    out.energy_mj += static_cast<double>(sum.energy) / RS_ENERGY_SCALE;
    out.floor_energy_mj += static_cast<double>(sum.floor_energy) / RS_ENERGY_SCALE;
    if ((sum.contacts > 0 || !force.isZero(0)) && !touched_from_mm) touched_from_mm = start_of(substep, frame);
    out.contacts += sum.contacts;
    removed += sum.removed;
  }
  out.removed_mm3 = static_cast<double>(removed) / RS_WHOLE_FILL * voxel_mm3_;
  run_.floor_mj += out.floor_energy_mj;
  run_.cut_mj += out.energy_mj;
  out.balance = balance();

  const Vec3 tool_z = frame.pose.orientation * Vec3::UnitZ();
  out.axial_force_n = out.force_n.dot(tool_z);
  // The tool spins about −z of T, so the torque of the bone on it is about +z.
  out.spin_torque_nmm = out.torque_nmm.dot(tool_z);
  if (out.push) out.push->drill_power_w = 1e-3 * out.spin_torque_nmm * out.pose.spin_rpm * kRadPerRpm_s;
  if (touched_from_mm && !run_.first_contact_mm) run_.first_contact_mm = contact_mm_.value_or(*touched_from_mm);
  if (run_.first_contact_mm) out.depth_mm = -(frame.pose.position_mm - *run_.first_contact_mm).dot(tool_z);
  return out;
}

}  // namespace reamsim
