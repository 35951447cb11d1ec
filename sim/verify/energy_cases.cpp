// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The energy balance (docs/physics.md, 5) from separate sums of its two sides, and the energy of the removed bone.
#include <cmath>

#include "sim/verify/case_parts.h"

namespace reamsim::verify {

namespace {

constexpr double kVoxel_mm = 0.25, kEnergyRate_hz = 500, kLayer_mm = 1.5, kDense = 1.8, kSoft = 0.4;

double layered_density(const Vec3& p) {
  return p.z() > -kLayer_mm ? kDense : kSoft;
}

/// Down; sideways, so slowly rotating that most of the face is below the speed floor; tilting.
Motion every_kind_of_motion() {
  const Quat first = rotation({1, 0.4, 0}, 10), last = rotation({0.2, 1, 0}, 8) * first;
  return path(
      kEnergyRate_hz, {-1.5, -0.5, 2},
      {{{-1.5, -0.5, -2}, 120, 250, first}, {{0.5, 0.5, -2}, 80, 20, first}, {{0.5, 0.5, -2.5}, 60, 100, last}});
}

/// Work of the tool on the bone in a frame, from its poses and mean loads: −(T·ω + F·v)·Δt, mJ.
double work_mj(const ToolPose& before, const FrameResult& row) {
  const ToolPose& after = row.pose;
  const Eigen::AngleAxisd tilt(after.orientation * before.orientation.conjugate());
  const double spin = after.spin_angle_rad - before.spin_angle_rad;
  const Vec3 turn = tilt.angle() * tilt.axis() - spin * (after.orientation * Vec3::UnitZ());
  return -(row.torque_nmm.dot(turn) + row.force_n.dot(after.position_mm - before.position_mm));
}

/// The removed bone: its cutting energy by the closed form of the law, and its volume.
struct RemovedBone {
  double energy_mj = 0;
  double volume_mm3 = 0;
};

RemovedBone removed_from(const BoneView& remaining) {
  RemovedBone out;
  for_each_bone_voxel(remaining, [&](const Vec3i&, std::uint8_t grade, std::uint16_t fill) {
    const double lost = (1 - double(fill) / FillBricks::kWhole) * remaining.voxmap.grid.voxel_mm3();
    out.volume_mm3 += lost;
    out.energy_mj += lost * specific_energy(DensityMapping::density_from_grade(grade));
  });
  return out;
}

}  // namespace

CaseFindings energy_case(const Setting& setting) {
  CaseFindings out;
  out.title = "Energy";
  out.scene =
      "cannulated convex head through two layers: a tilted plunge at 250 rpm, a sideways sweep at 20 rpm, a tilting "
      "plunge at 100 rpm";
  out.form =
      "−Σ(T·ω + F·v)·Δt + E_floor = E_cut = Σu(ρ)·ΔV; an identity of the law, so it checks the bookkeeping and not the "
      "bone";
  const Tool tool = make_tool(convex_profile(12, 5, 1, 8, 0.05));
  const Reamed reamed =
      ream(scene_of(block({22, 20, 6}, kVoxel_mm, layered_density), tool, every_kind_of_motion()), setting);
  double work = 0, floor = 0, cut = 0;
  for (std::size_t k = 1; k < reamed.rows.size(); ++k) {
    work += work_mj(reamed.rows[k - 1].pose, reamed.rows[k]);
    floor += reamed.rows[k].floor_energy_mj;
    cut += reamed.rows[k].energy_mj;
  }
  const RemovedBone removed = removed_from(reamed.bone);
  const std::string bar = "limit set by this project for every run", reported = "";
  out.checks.push_back({"left side: work of the tool", "mJ", Measure::reported, 0, work, 0, reported});
  out.checks.push_back({"left side: speed-floor energy", "mJ", Measure::reported, 0, floor, 0, reported});
  out.checks.push_back({"left side against right side, E_cut", "mJ", Measure::relative, cut, work + floor, 1e-4, bar});
  out.checks.push_back(
      {"balance reported by the program", "", Measure::absolute, 0, reamed.rows.back().balance, 1e-4, bar});
  out.checks.push_back({"E_cut against the removed bone", "mJ", Measure::relative, removed.energy_mj, cut, 1e-5,
                        "energies are single-precision sums over integer fractions of voxels"});
  out.checks.push_back({"removed volume against the removed bone", "mm³", Measure::relative, removed.volume_mm3,
                        reamed.removed_mm3(), 1e-9, "the same integers"});
  return out;
}

}  // namespace reamsim::verify
