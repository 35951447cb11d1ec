// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Forces of a cannulated reamer against closed forms: in full contact, their ratio, which does not depend on the bone,
// and those on a face half over bone. The energy balance (docs/physics.md, 5) from separate sums of its two sides, and
// the energy of the removed bone.

#include <fmt/core.h>
#include <limits>

#include "sim/verify/suite.h"

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
    const double removal = mean.removed_mm3 / voxel_mm * plunge.feed_mm_s;
    const double found[] = {mean.spin_torque_nmm, mean.axial_force_n, removal};
    for (std::size_t i = 0; i < refinements.size(); ++i) add_level(refinements[i], voxel_mm, found[i]);
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

std::vector<SteadyPlunge> ratio_plunges(bool quick) {
  std::vector<SteadyPlunge> out = {kExample, example_with(&SteadyPlunge::density_g_cm3, 0.4),
                                   example_with(&SteadyPlunge::density_g_cm3, 1.0), kFlatExample};
  if (quick) return out;
  for (const double outer_mm : {8.0, 12.5}) out.push_back(example_with(&SteadyPlunge::outer_mm, outer_mm));
  for (const double rpm : {100.0, 500.0}) out.push_back(example_with(&SteadyPlunge::rpm, rpm));
  for (const double feed_mm_s : {0.05, 0.5}) out.push_back(example_with(&SteadyPlunge::feed_mm_s, feed_mm_s));
  for (const double radius_mm : {20.0, 40.0}) out.push_back(example_with(&SteadyPlunge::radius_mm, radius_mm));
  return out;
}

std::string with_density(const SteadyPlunge& plunge) {
  return text_of(plunge) + fmt::format(", {:g} g/cm³", plunge.density_g_cm3);
}

double measured_ratio_mm(const PlungeRun& run, const Setting& setting) {
  const MeanLoads mean = mean_loads(steady_rows(run, setting));
  return mean.spin_torque_nmm / mean.axial_force_n;
}

/// e and t of HalfFaceLoads in B are those of a tool that stands upright.
HalfFaceLoads measured_half(const PlungeRun& run, const Setting& setting) {
  const Vec3 e = toward(*run.half_toward_deg), t = Vec3::UnitZ().cross(e);
  const MeanLoads mean = mean_loads(steady_rows(run, setting));
  return {mean.spin_torque_nmm, mean.axial_force_n,     mean.force_n.dot(e),
          mean.force_n.dot(t),  mean.torque_nmm.dot(e), mean.torque_nmm.dot(t)};
}

/// A load of the half face, its name and its unit.
struct HalfLoad {
  const char* name;
  const char* unit;
  double HalfFaceLoads::*member;
};
constexpr HalfLoad kHalfLoads[] = {
    {"torque", "N·mm", &HalfFaceLoads::torque_nmm}, {"axial force", "N", &HalfFaceLoads::axial_force_n},
    {"F·e", "N", &HalfFaceLoads::along_e_n},        {"F·t", "N", &HalfFaceLoads::along_t_n},
    {"M·e", "N·mm", &HalfFaceLoads::about_e_nmm},   {"M·t", "N·mm", &HalfFaceLoads::about_t_nmm}};

/// The loads of one half face against the closed forms.
void check_half(const PlungeRun& run, const Setting& setting, Report& out) {
  const std::string where = text_of(run.plunge) + fmt::format(", e at {:g}°", *run.half_toward_deg);
  const HalfFaceLoads expected = run.plunge.half_face(), found = measured_half(run, setting);
  for (const HalfLoad& load : kHalfLoads) {
    const double form = expected.*load.member;
    const std::string quantity = std::string(load.name) + ", " + where;
    if (form != 0) {
      out.relative(quantity, load.unit, form, found.*load.member, kFormLimit);
    } else {
      // A flat face has no such load: a fraction of the load across it.
      const bool force = load.member == &HalfFaceLoads::along_e_n;
      const double scale = force ? expected.along_t_n : expected.about_t_nmm;
      out.absolute(quantity, load.unit, 0, found.*load.member, kFormLimit * std::abs(scale));
    }
  }
}

/// The lateral force as refinements over the voxel size, against the law's integral.
std::vector<Refinement> half_refinements(const Setting& setting) {
  std::vector<Refinement> refinements;
  const HalfFaceLoads expected = kExample.full_half_face();
  for (const HalfLoad& load : kHalfLoads) {
    refinements.push_back({load.name, load.unit, "voxel, mm", expected.*load.member});
  }
  for (const double voxel_mm : four_voxels(setting.quick ? 0.25 : 0.125)) {
    const HalfFaceLoads found =
        measured_half({.plunge = kExample, .voxel_mm = voxel_mm, .half_toward_deg = 25}, setting);
    for (std::size_t i = 0; i < refinements.size(); ++i) {
      add_level(refinements[i], voxel_mm, found.*kHalfLoads[i].member);
    }
  }
  for (Refinement& refinement : refinements) finish(refinement);
  return refinements;
}

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

constexpr double kVoxel_mm = 0.25, kEnergyRate_hz = 500, kLayer_mm = 1.5, kDense = 1.8, kSoft = 0.4;

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

/// The removed bone, with its cutting energy by the closed form of the law.
Removed removed_from(const BoneView& remaining) {
  Removed out;
  for_each_bone_voxel(remaining, [&](const Vec3i&, std::uint8_t grade, std::uint16_t fill) {
    const double lost = (1 - double(fill) / FillBricks::kWhole) * remaining.voxmap.grid.voxel_mm3();
    out.volume_mm3 += lost;
    out.energy_mj += lost * specific_energy(DensityMapping::density_from_grade(grade));
  });
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
  constexpr double kRate_hz = 1000;
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

void ratio_case(const Setting& setting, Report& out) {
  out.title = "Ratio of torque to axial force is independent of the bone";
  out.scene = "the reamers of the steady plunge in full contact, in bone of several densities; 0.25 mm voxels";
  out.form = "T/F_z = (a² − r₀²)/(2·k_n·[C(a) − C(r₀)] + 2·(v_f/ω)·ln(a/r₀)); without its last term while v_f ≪ ω·r₀";
  for (const SteadyPlunge& plunge : ratio_plunges(setting.quick)) {
    const double found = measured_ratio_mm({.plunge = plunge}, setting);
    out.relative("T/F_z, " + with_density(plunge), "mm", plunge.torque_nmm() / plunge.axial_force_n(), found,
                 kFormLimit);
    out.add(Measure::reported, "T/F_z in the limit of slow feed, " + with_density(plunge), "mm", plunge.ratio_mm(),
            found, 0, "beside it");
  }
  const double tilted = measured_ratio_mm({.plunge = kExample, .tilt_deg = 17}, setting);
  out.relative("T/F_z, axis tilted by 17°", "mm", kExample.torque_nmm() / kExample.axial_force_n(), tilted, kFormLimit);
}

void half_face_case(const Setting& setting, Report& out) {
  out.title = "Bone under half of the face";
  out.scene =
      "the steady plunge beside a wall: bone only on one side of a plane through the axis, the side to which e points; "
      "t is a quarter turn further; the plane is oblique to the lattice; refinements: e at 25°";
  out.form =
      "torque and axial force half of full contact; F·t = 2u·(v_f/ω)·(a − r₀); F·e = −k_n·u·(v_f/ω)·(a² − r₀²)/R; M·t "
      "= R·F·e; M·e = −2u·(v_f/ω)·R·[(a − r₀) − (C(a) − C(r₀))]";
  out.refinements = half_refinements(setting);
  std::vector<PlungeRun> runs = {{.plunge = kExample, .half_toward_deg = 0},
                                 {.plunge = kExample, .half_toward_deg = 25},
                                 {.plunge = kFlatExample, .half_toward_deg = 25}};
  if (!setting.quick) {
    runs.push_back({.plunge = kExample, .half_toward_deg = 137});
    runs.push_back({.plunge = example_with(&SteadyPlunge::bore_mm, 4), .half_toward_deg = 25});
    runs.push_back({.plunge = example_with(&SteadyPlunge::radius_mm, 20), .half_toward_deg = 25});
  }
  for (const PlungeRun& run : runs) check_half(run, setting, out);
}

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

void energy_case(const Setting& setting, Report& out) {
  out.title = "Energy";
  out.scene =
      "cannulated convex head through two layers: a tilted plunge at 250 rpm, a sideways sweep at 20 rpm, a tilting "
      "plunge at 100 rpm";
  out.form =
      "−Σ(T·ω + F·v)·Δt + E_floor = E_cut = Σu(ρ)·ΔV; an identity of the law, so it checks the bookkeeping and not the "
      "bone";
  const Tool tool = make_tool(convex_profile(12, 5, 1, 8, 0.05));
  const FilledVoxmap bone =
      block({22, 20, 6}, kVoxel_mm, [](const Vec3& p) { return p.z() > -kLayer_mm ? kDense : kSoft; });
  const Reamed reamed = ream(scene_of(bone, tool, every_kind_of_motion()), setting);
  double work = 0;
  for (std::size_t k = 1; k < reamed.rows.size(); ++k) work += work_mj(reamed.rows[k - 1].pose, reamed.rows[k]);
  const double floor = reamed.sum(&FrameResult::floor_energy_mj), cut = reamed.sum(&FrameResult::energy_mj);
  const Removed removed = removed_from(reamed.bone);
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
