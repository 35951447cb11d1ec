#include "sim/run/frame_ledger.h"

namespace reamsim {

namespace {

Vec3 scaled(const rs_i64* sums, double scale) {
  return Vec3(static_cast<double>(sums[0]), static_cast<double>(sums[1]), static_cast<double>(sums[2])) / scale;
}

}  // namespace

FrameResult FrameLedger::close(const PendingFrame& frame, const std::vector<SubstepSums>& sums) {
  FrameResult out;
  out.frame = frame.frame;
  out.time_s = static_cast<double>(frame.frame) * frame_s_;
  out.pose = frame.pose;
  rs_i64 removed = 0;
  for (const auto& [slot, substep] : frame.cut) {
    const SubstepSums& sum = sums[slot];
    const Mat3 bone_from_sums = bone_from_shell(substep.pose, sums_rotate_).linear();
    const Vec3 force = bone_from_sums * scaled(sum.force, RS_FORCE_SCALE);
    const Vec3 torque = bone_from_sums * scaled(sum.torque, RS_TORQUE_SCALE);
    work_mj_ -= (torque.dot(substep.angular_velocity) + force.dot(substep.origin_velocity_mm_s)) * substep.duration_s;
    out.force_n += force / frame.substeps;
    out.torque_nmm += torque / frame.substeps;
    out.energy_mj += static_cast<double>(sum.energy) / RS_ENERGY_SCALE;
    out.floor_energy_mj += static_cast<double>(sum.floor_energy) / RS_ENERGY_SCALE;
    out.contacts += sum.contacts;
    removed += sum.removed;
  }
  out.removed_mm3 = static_cast<double>(removed) / RS_WHOLE_FILL * voxel_mm3_;
  floor_mj_ += out.floor_energy_mj;
  cut_mj_ += out.energy_mj;
  out.balance = balance();

  const Vec3 tool_z = frame.pose.orientation * Vec3::UnitZ();
  out.axial_force_n = out.force_n.dot(tool_z);
  // The tool spins about −z of T, so the torque of the bone on it is about +z.
  out.spin_torque_nmm = out.torque_nmm.dot(tool_z);
  if (out.contacts > 0 && !first_contact_mm_) first_contact_mm_ = frame.before.position_mm;
  if (first_contact_mm_) out.depth_mm = -(frame.pose.position_mm - *first_contact_mm_).dot(tool_z);
  return out;
}

}  // namespace reamsim
