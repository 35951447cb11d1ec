// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The ratio of torque to axial force, which does not depend on the bone, and the loads on a face half over bone.
#include <fmt/core.h>
#include <cmath>

#include "sim/verify/case_parts.h"

namespace reamsim::verify {

namespace {

constexpr double kForceLimit = 5e-3;  // of a steady plunge at 0.25 mm

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
      out.relative(quantity, load.unit, form, found.*load.member, kForceLimit);
    } else {
      // A flat face has no such load: a fraction of the load across it.
      const bool force = load.member == &HalfFaceLoads::along_e_n;
      const double scale = force ? expected.along_t_n : expected.about_t_nmm;
      out.absolute(quantity, load.unit, 0, found.*load.member, kForceLimit * std::abs(scale));
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

}  // namespace

void ratio_case(const Setting& setting, Report& out) {
  out.title = "Ratio of torque to axial force is independent of the bone";
  out.scene = "the reamers of the steady plunge in full contact, in bone of several densities; 0.25 mm voxels";
  out.form = "T/F_z = (a² − r₀²)/(2·k_n·[C(a) − C(r₀)] + 2·(v_f/ω)·ln(a/r₀)); without its last term while v_f ≪ ω·r₀";
  for (const SteadyPlunge& plunge : ratio_plunges(setting.quick)) {
    const double found = measured_ratio_mm({.plunge = plunge}, setting);
    out.relative("T/F_z, " + with_density(plunge), "mm", plunge.torque_nmm() / plunge.axial_force_n(), found,
                 kForceLimit);
    out.add(Measure::reported, "T/F_z in the limit of slow feed, " + with_density(plunge), "mm", plunge.ratio_mm(),
            found, 0, "beside it");
  }
  const double tilted = measured_ratio_mm({.plunge = kExample, .tilt_deg = 17}, setting);
  out.relative("T/F_z, axis tilted by 17°", "mm", kExample.torque_nmm() / kExample.axial_force_n(), tilted,
               kForceLimit);
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

}  // namespace reamsim::verify
