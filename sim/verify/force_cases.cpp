// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Forces of a cannulated reamer in full contact against closed forms.
// The energy balance (docs/physics.md, 5) from separate sums of its two sides, and the energy of the removed bone.

#include <cmath>
#include <limits>

#include "sim/verify/case_parts.h"

namespace reamsim::verify {

namespace {

constexpr double kClear_mm = 0.1;
/// Limits of the project for a steady plunge in full contact at 0.25 mm.
constexpr double kFormLimit = 5e-3, kRippleLimit = 2e-3;

/// Torque, axial force and removal rate as refinements over the voxel size.
std::vector<Refinement> steady_refinements(const SteadyPlunge& plunge, const Setting& setting) {
  std::vector<Refinement> refinements = load_refinements(plunge);
  constexpr int kFrames = 64;
  for (const double voxel_mm : four_voxels(setting.quick ? 0.25 : 0.125)) {
    const MeanLoads mean =
        mean_loads(steady_rows({.plunge = plunge, .voxel_mm = voxel_mm, .frames = kFrames}, setting));
    add_levels(refinements, voxel_mm,
               {mean.spin_torque_nmm, mean.axial_force_n, mean.removed_mm3 / voxel_mm * plunge.feed_mm_s});
  }
  for (Refinement& refinement : refinements) finish(refinement);
  return refinements;
}

/// The example with one factor changed at a time, and with a flat face.
std::vector<SteadyPlunge> variations(bool quick) {
  std::vector<SteadyPlunge> out;
  const auto vary = [&](auto member, const std::vector<double>& values) {
    for (const double value : values) out.push_back(example_with(member, value));
  };
  if (quick) {
    vary(&SteadyPlunge::outer_mm, {8});
    vary(&SteadyPlunge::rpm, {100, 500});
    vary(&SteadyPlunge::feed_mm_s, {1});
  } else {
    vary(&SteadyPlunge::outer_mm, {6, 8, 10, 12.5});
    vary(&SteadyPlunge::rpm, {100, 150, 500, 1000});
    vary(&SteadyPlunge::feed_mm_s, {0.05, 0.5, 1, 2});
    vary(&SteadyPlunge::bore_mm, {2, 4});
    vary(&SteadyPlunge::density_g_cm3, {0.4, 0.8, 1.2});
  }
  vary(&SteadyPlunge::radius_mm, {20, 40});
  out.push_back(kFlatExample);
  return out;
}

}  // namespace

void steady_case(const Setting& setting, Report& out) {
  out.title = "Torque and axial force in uniform bone";
  out.scene =
      "cannulated reamer (r₀ 1.25 mm) fed along its axis in full contact, ρ 1.8 g/cm³; means over one voxel of feed; "
      "refinements: R 29, a 15 mm, 250 rpm, 0.2 mm/s";
  out.form = "T = π·u·(a² − r₀²)·v_f/ω; F_z = 2π·k_n·u·(v_f/ω)·[C(a) − C(r₀)] + 2π·u·(v_f/ω)²·ln(a/r₀)";
  out.refinements = steady_refinements(kExample, setting);
  const double simple[] = {kExample.torque_nmm(), kExample.axial_force_n(), kExample.removal_mm3_s()};
  for (std::size_t i = 0; i < out.refinements.size(); ++i) {
    const Refinement& refinement = out.refinements[i];
    out.relative(refinement.quantity + ", " + text_of(kExample), refinement.unit, simple[i],
                 refinement.levels.back().found, kFormLimit);
  }
  for (const SteadyPlunge& plunge : variations(setting.quick)) {
    const MeanLoads mean = mean_loads(steady_rows({.plunge = plunge}, setting));
    out.relative("torque, " + text_of(plunge), "N·mm", plunge.torque_nmm(), mean.spin_torque_nmm, kFormLimit);
    out.relative("axial force, " + text_of(plunge), "N", plunge.axial_force_n(), mean.axial_force_n, kFormLimit);
  }
}

void ripple_case(const Setting& setting, Report& out) {
  constexpr double kVoxel_mm = 0.25, kRate_hz = 1000;
  out.title = "Ripple of a steady plunge";
  out.scene = "the same reamer at 0.25 mm voxels, 0.2 mm/s and 1 kHz, frame by frame over one voxel of feed";
  out.form = "0: standard deviation of the torque over its mean";
  const int frames = static_cast<int>(std::lround(kVoxel_mm / kExample.feed_mm_s * kRate_hz));
  const auto ripple = [&](const SteadyPlunge& plunge, ErosionMode erosion, double tilt_deg) {
    return torque_ripple(steady_rows(
        {.plunge = plunge, .voxel_mm = kVoxel_mm, .frames = frames, .erosion = erosion, .tilt_deg = tilt_deg},
        setting));
  };
  out.at_most("convex, axis tilted by 17°, exact", "", kRippleLimit, ripple(kExample, ErosionMode::exact, 17));
  out.at_most("convex along the lattice, exact", "", kRippleLimit, ripple(kExample, ErosionMode::exact, 0));
  out.reported("flat along the lattice, exact", "", ripple(kFlatExample, ErosionMode::exact, 0),
               "0.2 µm per frame is 52 of the 65535 steps of a voxel, and all voxels round together");
  out.reported("convex along the lattice, remove", "", ripple(kExample, ErosionMode::remove, 0), "beside it");
  if (!setting.quick) {
    out.reported("flat along the lattice, remove", "", ripple(kFlatExample, ErosionMode::remove, 0), "beside it");
  }
}

namespace {

constexpr double kFormLayer_mm = 2, kAround_mm = 1;
constexpr int kAroundFrames = 400;  // from kAround_mm above the interface to as far below it

/// Rows about the interface of a block with a layer of the first plunge's density on that of the second.
std::vector<FrameResult> rows_about_interface(const SteadyPlunge& dense, const SteadyPlunge& soft, double voxel_mm,
                                              const Setting& setting) {
  constexpr int kApproach = 24;
  const FilledVoxmap bone = block({18, 18, 4}, voxel_mm, [&](const Vec3& p) {
    return p.z() > -kFormLayer_mm ? dense.density_g_cm3 : soft.density_g_cm3;
  });
  const double x = 0.12 * voxel_mm, y = 0.21 * voxel_mm, rate = dense.feed_mm_s * kAroundFrames / (2 * kAround_mm);
  const Motion motion = path(rate, {x, y, kClear_mm},
                             {{{x, y, -(kFormLayer_mm - kAround_mm)}, kApproach, dense.rpm},
                              {{x, y, -(kFormLayer_mm + kAround_mm)}, kAroundFrames, dense.rpm}});
  const Reamed reamed = ream(scene_of(bone, make_tool(head_of(dense)), motion), setting);
  const auto rows = reamed.after(kApproach);
  return {rows.begin(), rows.end()};
}

/// Depth of the tool when the torque falls below `torque_nmm`, mm; NaN where it never exceeds it.
double depth_of_step(const std::vector<FrameResult>& rows, double torque_nmm) {
  double depth = std::numeric_limits<double>::quiet_NaN();
  for (const FrameResult& row : rows) {
    if (row.spin_torque_nmm < torque_nmm) break;
    depth = -row.pose.position_mm.z();
  }
  return depth;
}

}  // namespace

void layered_case(const Setting& setting, Report& out) {
  const SteadyPlunge dense{std::nullopt, 8, 1.25, 250, 0.2, 1.8}, soft{std::nullopt, 8, 1.25, 250, 0.2, 0.4};
  out.title = "Layered block: step of the force at the interface";
  out.scene = "flat cannulated reamer (a 8, r₀ 1.25 mm) along a lattice axis through 2 mm of 1.8 g/cm³ into 0.4 g/cm³";
  out.form = "T = π·u(ρ)·(a² − r₀²)·v_f/ω minus the work of the feed, on both sides; the step at 2 mm";
  Refinement above{"torque above the interface", "N·mm", "voxel, mm", dense.full_loads().torque_nmm};
  Refinement below{"torque below the interface", "N·mm", "voxel, mm", soft.full_loads().torque_nmm};
  double step_mm = 0;  // at the finest level
  for (const double voxel_mm : four_voxels(setting.quick ? 0.125 : 0.0625)) {
    const auto rows = rows_about_interface(dense, soft, voxel_mm, setting);
    const std::span<const FrameResult> all(rows);
    step_mm = depth_of_step(rows, 0.5 * (dense.torque_nmm() + soft.torque_nmm()));
    add_level(above, voxel_mm, mean_loads(all.first(kAroundFrames / 2)).spin_torque_nmm);
    add_level(below, voxel_mm, mean_loads(all.last(kAroundFrames / 2)).spin_torque_nmm);
  }
  for (const Refinement& refinement : {above, below}) out.refinement(refinement, kFormLimit);
  out.absolute("depth of the step, finest voxels", "mm", kFormLayer_mm, step_mm, 2 * kAround_mm / kAroundFrames,
               "one frame of feed");
}

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

void energy_case(const Setting& setting, Report& out) {
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
  double work = 0;
  for (std::size_t k = 1; k < reamed.rows.size(); ++k) work += work_mj(reamed.rows[k - 1].pose, reamed.rows[k]);
  const double floor = reamed.sum(&FrameResult::floor_energy_mj), cut = reamed.sum(&FrameResult::energy_mj);
  const RemovedBone removed = removed_from(reamed.bone);
  const std::string bar = "limit set by this project for every run";
  out.reported("left side: work of the tool", "mJ", work);
  out.reported("left side: speed-floor energy", "mJ", floor);
  out.relative("left side against right side, E_cut", "mJ", cut, work + floor, 1e-4, bar);
  out.absolute("balance reported by the program", "", 0, reamed.rows.back().balance, 1e-4, bar);
  out.relative("E_cut against the removed bone", "mJ", removed.energy_mj, cut, 1e-5,
               "energies are single-precision sums over integer fractions of voxels");
  out.relative("removed volume against the removed bone", "mm³", removed.volume_mm3, reamed.removed_mm3(), 1e-9,
               "the same integers");
}

}  // namespace reamsim::verify
