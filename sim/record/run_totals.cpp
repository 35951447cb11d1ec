// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/record/run_totals.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace reamsim {

void PassTotals::add(const FrameResult& row) {
  last_frame = row.frame;
  if (row.in_contact() && first_contact_frame < 0) first_contact_frame = row.frame;
  removed_mm3 += row.removed_mm3;
  energy_mj += row.energy_mj;
  max_depth_mm = std::max(max_depth_mm, row.depth_mm);
  peak_axial_force_n = std::max(peak_axial_force_n, row.axial_force_n);
  peak_spin_torque_nmm = std::max(peak_spin_torque_nmm, std::abs(row.spin_torque_nmm));
}

void DeflectionTotals::add(const FrameResult& row, bool deepest) {
  const Vec3& mm = *row.deflection_mm;
  if (mm.norm() > peak_mm) {
    peak_mm = mm.norm();
    peak_time_s = row.time_s;
  }
  peak_lateral_mm = std::max(peak_lateral_mm, mm.head<2>().norm());
  if (deepest) at_depth_mm = mm;
  at_end_mm = mm;
}

void RunTotals::add(const FrameResult& row) {
  ++frames;
  if (std::ssize(passes) < row.pass) passes.push_back({.first_frame = row.frame});
  PassTotals& pass = passes.back();
  const bool first_contact = row.in_contact() && pass.first_contact_frame < 0;
  const bool deepest = first_contact || row.depth_mm > pass.max_depth_mm;
  if (deepest) deepest_pose = row.pose;
  pass.add(row);
  simulated_s = row.time_s;
  removed_mm3 += row.removed_mm3;
  energy_mj += row.energy_mj;
  floor_energy_mj += row.floor_energy_mj;
  balance = row.balance;
  max_depth_mm = std::max(max_depth_mm, row.depth_mm);
  peak_force_n = std::max(peak_force_n, row.force_n.norm());
  if (row.axial_force_n > peak_axial_force_n) {
    peak_axial_force_n = row.axial_force_n;
    peak_advance_mm = (row.pose.position_mm - last_position_mm_).norm();
  }
  last_position_mm_ = row.pose.position_mm;
  peak_torque_nmm = std::max(peak_torque_nmm, row.torque_nmm.norm());
  peak_spin_torque_nmm = std::max(peak_spin_torque_nmm, std::abs(row.spin_torque_nmm));
  const auto layer = layer_.add(row.pose.position_mm, row.axial_force_n, row.spin_torque_nmm);
  peak_layer_axial_force_n = std::max(peak_layer_axial_force_n, layer.axial_force_n);
  peak_layer_spin_torque_nmm = std::max(peak_layer_spin_torque_nmm, std::abs(layer.spin_torque_nmm));
  if (row.push) {
    if (!push) push.emplace();
    push->add(row);
  }
  if (row.deflection_mm) {
    if (!deflection) deflection.emplace();
    deflection->add(row, deepest);
  }
  if (!row.in_contact()) return;
  ++contact_frames;
  if (first_contact_frame < 0) first_contact_frame = row.frame;
  last_contact_frame = row.frame;
  sums_.force_n += row.force_n.norm();
  sums_.torque_nmm += row.torque_nmm.norm();
  sums_.axial_force_n += row.axial_force_n;
  sums_.spin_torque_nmm += row.spin_torque_nmm;
  force_squares_ += row.force_n.squaredNorm();
  torque_squares_ += row.torque_nmm.squaredNorm();
}

double RunTotals::rms_force_n() const {
  return contact_frames == 0 ? 0 : std::sqrt(force_squares_ / static_cast<double>(contact_frames));
}

double RunTotals::rms_torque_nmm() const {
  return contact_frames == 0 ? 0 : std::sqrt(torque_squares_ / static_cast<double>(contact_frames));
}

std::int64_t RunTotals::reaming_frames() const {
  return first_contact_frame < 0 ? 0 : last_contact_frame - first_contact_frame + 1;
}

KeyResults RunTotals::headline(bool means) const {
  return {.means = means,
          .peak_axial_force_n = means ? peak_layer_axial_force_n : peak_axial_force_n,
          .peak_spin_torque_nmm = means ? peak_layer_spin_torque_nmm : peak_spin_torque_nmm,
          .tool_depth_mm = max_depth_mm};
}

RunTotals::Means RunTotals::means() const {
  if (reaming_frames() == 0) return {};
  const auto count = static_cast<double>(reaming_frames());
  return {.force_n = sums_.force_n / count,
          .torque_nmm = sums_.torque_nmm / count,
          .axial_force_n = sums_.axial_force_n / count,
          .spin_torque_nmm = sums_.spin_torque_nmm / count};
}

}  // namespace reamsim
