// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// A tool on springs (docs/feeds.md, 11), against closed forms.
#include <fmt/core.h>
#include <algorithm>
#include <cmath>

#include "sim/verify/case_parts.h"

namespace reamsim::verify {

namespace {

constexpr double kLimit = 5e-3, kTimeLimit = 0.02;
constexpr double kRigid_n_mm = ComplianceSettings::kRigid_n_mm;

Vec3 mean_deflection_mm(std::span<const FrameResult> rows) {
  Vec3 sum = Vec3::Zero();
  for (const FrameResult& row : rows) sum += *row.deflection_mm;
  return sum / static_cast<double>(rows.size());
}

/// The deflection of a steady plunge, over the last voxel of feed. The tool reaches full contact at many times the feed
/// rate, with a deflection to match, which the voxels before let decay.
Vec3 steady_deflection_mm(PlungeRun run, const ComplianceSettings& springs, const Setting& setting) {
  run.compliance = springs;
  run.voxels = 4;
  const std::vector<FrameResult> rows = steady_rows(run, setting);
  return mean_deflection_mm(std::span(rows).last(static_cast<std::size_t>(run.frames)));
}

/// The example fed from full contact and no deflection.
Reamed approach_of(double stiffness_n_mm, double damping_n_s_mm, double time_s, const Setting& setting) {
  constexpr double kVoxel_mm = 0.5, kRate_hz = 1000;
  const double x = 0.12 * kVoxel_mm, y = 0.21 * kVoxel_mm;
  const double begin = kExample.full_contact_mm() + 0.3, end = begin + kExample.feed_mm_s * time_s;
  const Motion motion =
      path(kRate_hz, {x, y, -begin}, {{{x, y, -end}, static_cast<int>(std::lround(kRate_hz * time_s)), kExample.rpm}});
  SimulationInput scene =
      scene_of(block({33, 33, end + 1}, kVoxel_mm, kExample.density_g_cm3), make_tool(head_of(kExample)), motion);
  scene.scenario.motion.compliance = {{kRigid_n_mm, kRigid_n_mm, stiffness_n_mm}, damping_n_s_mm};
  return ream(std::move(scene), setting);
}

/// A ball fed down on the edge of a block, whose other half is air, through a dense layer.
SimulationInput ball_on_edge(double feed_mm_s, double depth_mm, double rate_hz) {
  constexpr double kRadius_mm = 5, kVoxel_mm = 0.25, kLayer_mm = 0.6, kEdge_mm = 0.05;
  const FilledVoxmap bone = half_block(
      {9, 9, 3}, kVoxel_mm, [](const Vec3& p) { return p.z() > -kLayer_mm ? 1.8 : 0.4; }, Vec3::Zero(),
      Vec3(1, 0.3, 0).normalized());
  const double above = 0.1;
  const int frames = static_cast<int>(std::lround((depth_mm + above) / feed_mm_s * rate_hz));
  const Motion motion = path(rate_hz, {0.03, 0.05, above}, {{{0.03, 0.05, -depth_mm}, frames, 250}});
  return scene_of(bone, make_tool(ball_profile(kRadius_mm, kEdge_mm)), motion);
}

}  // namespace

void compliance_steady_case(const Setting& setting, Report& out) {
  out.title = "Deflection along the axis";
  out.scene =
      "cannulated reamer (R 29, a 15, r₀ 1.25 mm, 250 rpm, 0.2 mm/s) in full contact in ρ 1.8 g/cm³, on a spring along "
      "z";
  out.form = "d = F_z/k; d = d_∞·(1 − exp(−t/τ)) with τ = (A + c)/k, A = dF_z/dv";
  const double voxel_mm = setting.quick ? 0.5 : 0.25;
  for (const double k : {1000.0, 4000.0}) {
    const Vec3 found =
        steady_deflection_mm({.plunge = kExample, .voxel_mm = voxel_mm}, {{kRigid_n_mm, kRigid_n_mm, k}, 0}, setting);
    out.relative(fmt::format("d at {:g} N/mm", k), "mm", kExample.axial_force_n() / k, found.z(), kLimit);
  }
  constexpr double kStiffness_n_mm = 4000;
  const double resistance = linear_resistance(kExample);
  for (const double damping : {0.0, 200.0}) {
    const double tau = (resistance + damping) / kStiffness_n_mm;
    const Reamed reamed = approach_of(kStiffness_n_mm, damping, 2.2 * tau, setting);
    const auto missing = [&](const FrameResult& row) {
      return 1 - row.deflection_mm->z() * kStiffness_n_mm / kExample.axial_force_n();
    };
    const auto frame = [&](double taus) { return static_cast<std::size_t>(std::lround(1e3 * taus * tau)); };
    out.relative(fmt::format("τ with c = {:g} N·s/mm", damping), "ms", 1e3 * tau,
                 1e3 * time_constant_s(reamed, frame(0.2), frame(2), missing), kTimeLimit);
  }
}

void compliance_half_case(const Setting& setting, Report& out) {
  out.title = "Deflection from bone under half of the face";
  out.scene = "the same reamer, and a flat one, with bone on the side of e only, on springs along x and y of 5000 N/mm";
  out.form = "k·d·t = 2u·(v_f/ω)·(a − r₀), k·d·e = −k_n·u·(v_f/ω)·(a² − r₀²)/R, t = z × e";
  constexpr double kStiffness_n_mm = 5000, kToward_deg = 25;
  const Vec3 e = toward(kToward_deg), t = Vec3::UnitZ().cross(e);
  for (const SteadyPlunge& plunge : {kExample, kFlatExample}) {
    const Vec3 d =
        steady_deflection_mm({.plunge = plunge, .voxel_mm = setting.quick ? 0.5 : 0.25, .half_toward_deg = kToward_deg},
                             {{kStiffness_n_mm, kStiffness_n_mm, kRigid_n_mm}, 0}, setting);
    const HalfFaceLoads loads = plunge.half_face();
    const std::string name = plunge.radius_mm ? ", convex" : ", flat";
    out.relative("d·t" + name, "µm", 1e3 * loads.along_t_n / kStiffness_n_mm, 1e3 * d.dot(t), 0.01);
    out.absolute("d·e" + name, "µm", 1e3 * loads.along_e_n / kStiffness_n_mm, 1e3 * d.dot(e),
                 0.01 * 1e3 * loads.along_t_n / kStiffness_n_mm, "1 % of d·t");
  }
}

void compliance_stiff_case(const Setting& setting, Report& out) {
  out.title = "Stiff springs";
  out.scene =
      "ball (R 5 mm, 250 rpm) fed 0.5 mm down at 1 mm/s on the edge of a block of two layers, on three equal springs";
  out.form = "the difference of the last forces from those of a rigid tool falls as 1/k";
  constexpr std::size_t kLast = 20;
  const auto force = [&](std::optional<double> stiffness) {
    SimulationInput scene = ball_on_edge(1, 0.5, 500);
    scene.scenario.engine.tuning.windows = false;  // as with springs
    if (stiffness) scene.scenario.motion.compliance = {Vec3::Constant(*stiffness), 0};
    const Reamed reamed = ream(std::move(scene), setting);
    return mean_loads(std::span(reamed.rows).last(kLast)).force_n;
  };
  const Vec3 rigid = force({});
  constexpr double kFactor = 4;
  std::vector<double> differences;
  for (const double k : {4000.0, 16000.0, 64000.0}) {
    differences.push_back((force(k) - rigid).norm());
    out.reported(fmt::format("difference at {:g} N/mm", k), "N", differences.back());
  }
  out.reported("force of the rigid tool", "N", rigid.norm());
  for (std::size_t i = 1; i < differences.size(); ++i) {
    out.absolute(fmt::format("order in 1/k, step {}", i), "", 1,
                 std::log(differences[i - 1] / differences[i]) / std::log(kFactor), 0.15);
  }
}

void compliance_energy_case(const Setting& setting, Report& out) {
  out.title = "Energy of a tool on springs";
  out.scene = "the ball of compliance_stiff fed 1 mm down, on springs of 30, 60 and 100 N/mm with 0.5 N·s/mm";
  out.form = "work of the feed + work of the drive + E_floor = E_cut + spring + damping energy + ½Σk·Δd²";
  SimulationInput scene = ball_on_edge(1, 1, 500);
  scene.scenario.motion.compliance = {{30, 60, 100}, 0.5};
  const Reamed reamed = ream(std::move(scene), setting);
  const double floor = reamed.sum(&FrameResult::floor_energy_mj), cut = reamed.sum(&FrameResult::energy_mj);
  const SpringState& s = reamed.springs;
  const auto report = [&](const char* name, double mj) { out.reported(name, "mJ", mj); };
  report("work of the feed", s.carriage_mj);
  report("work of the drive", s.spindle_work_mj);
  report("spring energy at the end", s.spring_mj);
  report("damping energy", s.damping_mj);
  report("½Σk·Δd²", s.lost_mj);
  out.relative("both sides", "mJ", cut + s.spring_mj + s.damping_mj + s.lost_mj,
               s.carriage_mj + s.spindle_work_mj + floor, 1e-4);
  out.at_most("½Σk·Δd² over the spring energy", "", 0.02, s.lost_mj / s.spring_mj, "it vanishes with the frame");
}

}  // namespace reamsim::verify
