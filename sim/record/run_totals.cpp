#include "sim/record/run_totals.h"

#include <algorithm>
#include <cmath>

namespace reamsim {

void RunTotals::add(const FrameResult& row) {
  ++frames;
  simulated_s = row.time_s;
  removed_mm3 += row.removed_mm3;
  energy_mj += row.energy_mj;
  floor_energy_mj += row.floor_energy_mj;
  balance = row.balance;
  max_depth_mm = std::max(max_depth_mm, row.depth_mm);
  peak_force_n = std::max(peak_force_n, row.force_n.norm());
  peak_axial_force_n = std::max(peak_axial_force_n, row.axial_force_n);
  peak_torque_nmm = std::max(peak_torque_nmm, row.torque_nmm.norm());
  peak_spin_torque_nmm = std::max(peak_spin_torque_nmm, row.spin_torque_nmm);
  const auto layer = layer_.add(row.pose.position_mm, row.axial_force_n, row.spin_torque_nmm);
  peak_layer_axial_force_n = std::max(peak_layer_axial_force_n, layer.axial_force_n);
  peak_layer_spin_torque_nmm = std::max(peak_layer_spin_torque_nmm, layer.spin_torque_nmm);
  if (row.contacts == 0) return;
  ++contact_frames;
  if (first_contact_frame < 0) first_contact_frame = row.frame;
  force_squares_ += row.force_n.squaredNorm();
  torque_squares_ += row.torque_nmm.squaredNorm();
}

double RunTotals::rms_force_n() const {
  return contact_frames == 0 ? 0 : std::sqrt(force_squares_ / static_cast<double>(contact_frames));
}

double RunTotals::rms_torque_nmm() const {
  return contact_frames == 0 ? 0 : std::sqrt(torque_squares_ / static_cast<double>(contact_frames));
}

}  // namespace reamsim
