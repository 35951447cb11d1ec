// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/force_rows.h"

namespace reamsim {

namespace {

constexpr std::size_t kPlannedColumns = 26, kDeflectedColumns = kPlannedColumns + 3;
constexpr std::size_t kFrameColumn = 0, kContactsColumn = 20, kPassColumn = 25;
/// Counts up to here are whole numbers of a double.
constexpr double kLargestCount = 1e15, kLargestPass = 1e4;

std::int64_t count_in(double value, double least, double most, const char* column, const SourceLocation& where) {
  if (value >= least && value <= most) return static_cast<std::int64_t>(value);
  throw InputError(where, column, "out of range", "expected a forces.csv as reamsim wrote it");
}

}  // namespace

std::int64_t frame_number(double value, const SourceLocation& where) {
  return count_in(value, 0, kLargestCount, "frame", where);
}

int pass_number(double value, const SourceLocation& where) {
  return static_cast<int>(count_in(value, 1, kLargestPass, "pass", where));
}

std::string force_columns(PoseFeedback feedback) {
  return std::string(kForceColumns) + (feedback.push ? kPushColumns : "") +
         (feedback.springs ? kDeflectionColumns : "");
}

std::vector<double> force_row(const FrameResult& r) {
  const Vec3 &p = r.pose.position_mm, &f = r.force_n, &t = r.torque_nmm;
  const Quat& q = r.pose.orientation;
  std::vector<double> out{static_cast<double>(r.frame),
                          r.time_s,
                          p.x(),
                          p.y(),
                          p.z(),
                          q.w(),
                          q.x(),
                          q.y(),
                          q.z(),
                          r.pose.spin_rpm,
                          r.pose.spin_angle_rad,
                          r.depth_mm,
                          f.x(),
                          f.y(),
                          f.z(),
                          t.x(),
                          t.y(),
                          t.z(),
                          r.axial_force_n,
                          r.spin_torque_nmm,
                          static_cast<double>(r.contacts),
                          r.removed_mm3,
                          r.energy_mj,
                          r.floor_energy_mj,
                          r.balance,
                          static_cast<double>(r.pass)};
  if (const auto& push = r.push) {
    out.insert(out.end(), {push->feed_mm_s, push->velocity_mm_s, push->thrust_n, push->hand_force_n, push->hand_power_w,
                           push->drill_power_w});
  }
  if (r.deflection_mm) out.insert(out.end(), r.deflection_mm->begin(), r.deflection_mm->end());
  return out;
}

FrameResult result_of(std::span<const double> v, const SourceLocation& where) {
  FrameResult out;
  out.frame = frame_number(v[kFrameColumn], where);
  out.time_s = v[1];
  out.pose = {.position_mm = Vec3(&v[2]),
              .orientation = Quat(v[5], v[6], v[7], v[8]),
              .spin_angle_rad = v[10],
              .spin_rpm = v[9]};
  out.depth_mm = v[11];
  out.force_n = Vec3(&v[12]);
  out.torque_nmm = Vec3(&v[15]);
  out.axial_force_n = v[18];
  out.spin_torque_nmm = v[19];
  out.contacts = count_in(v[kContactsColumn], 0, kLargestCount, "contacts", where);
  out.removed_mm3 = v[21];
  out.energy_mj = v[22];
  out.floor_energy_mj = v[23];
  out.balance = v[24];
  out.pass = pass_number(v[kPassColumn], where);
  if (v.size() == kDeflectedColumns) {
    out.deflection_mm = Vec3(&v[kPlannedColumns]);
  } else if (v.size() > kPlannedColumns) {
    out.push = PushResult{v[26], v[27], v[28], v[29], v[30], v[31]};
  }
  return out;
}

}  // namespace reamsim
