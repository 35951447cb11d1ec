// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Feeds that follow from the balance of forces, and a tool on springs (docs/feeds.md, 10 and 11), against closed forms.
#include <fmt/core.h>
#include <limits>
#include <memory>

#include "sim/verify/suite.h"

namespace reamsim::verify {

namespace {

constexpr double kFeedLimit = 5e-3;
constexpr double kPushHead_mm = 8, kPushEdge_mm = 0.1;

/// A push straight down on a block, with the head in the bone by `begin_mm` at its start.
struct Push {
  Profile head;
  DensityField density = [](const Vec3&) { return 1.8; };
  double voxel_mm = 0.25;
  double rate_hz = 200;
  double begin_mm = 0;   ///< what it contains there is removed without force
  double block_mm = 6;   ///< height
  double width_mm = 33;  ///< of the block
  PushSettings settings = {};
  std::optional<EdgeForceSettings> edge = {};
  double energy_factor = 1;  ///< of the specific energy
};

Reamed pushed(const Push& push, const Setting& setting) {
  PushSettings settings = push.settings;
  settings.entry_mm = entry_mm(push.voxel_mm) - Vec3(0, 0, push.begin_mm);
  const Vec3 size(push.width_mm, push.width_mm, push.block_mm);
  SimulationInput scene = scene_of(block(size, push.voxel_mm, push.density), make_tool(push.head), {});
  auto plan = std::make_shared<const PushPlan>(settings, push.rate_hz, std::nullopt);
  scene.motion.frame_rate_hz = push.rate_hz;
  scene.motion.poses = unresisted_poses(plan, push.rate_hz);
  scene.motion.push = std::move(plan);
  scene.scenario.cutting.edge_force = push.edge;
  scene.scenario.cutting.specific_energy_j_mm3 *= push.energy_factor;
  return ream(std::move(scene), setting);
}

double depth_of(const FrameResult& row) {
  return -row.pose.position_mm.z();
}

/// The time at which the tool's apex is at a depth; NaN where it does not come there.
double time_at(const Reamed& reamed, double depth_mm) {
  for (std::size_t k = 1; k < reamed.rows.size(); ++k) {
    const FrameResult &a = reamed.rows[k - 1], &b = reamed.rows[k];
    if (depth_of(b) < depth_mm) continue;
    return a.time_s + (b.time_s - a.time_s) * (depth_mm - depth_of(a)) / (depth_of(b) - depth_of(a));
  }
  return std::numeric_limits<double>::quiet_NaN();
}

/// Mean feed between two depths of the apex.
double mean_feed(const Reamed& reamed, double from_mm, double to_mm) {
  return (to_mm - from_mm) / (time_at(reamed, to_mm) - time_at(reamed, from_mm));
}

/// Where the steady feed is measured: over a voxel, after another part of the first.
double steady_feed(const SteadyPlunge& head, double thrust_n, double voxel_mm, const Setting& setting) {
  const double begin = head.full_contact_mm() + 0.3 + 0.37 * voxel_mm;
  Push push{.head = head_of(head), .voxel_mm = voxel_mm, .rate_hz = 50, .begin_mm = begin};
  push.density = [density = head.density_g_cm3](const Vec3&) { return density; };
  push.block_mm = begin + 2 * voxel_mm + 1;
  push.settings = {.approach_mm = 0, .thrust_n = thrust_n, .depth_mm = 1.1 * voxel_mm};
  const Reamed reamed = pushed(push, setting);
  return mean_feed(reamed, begin + 0.05 * voxel_mm, begin + 1.05 * voxel_mm);
}

/// Grades of density are too coarse for 0.1 g/cm³, so the bone has another density and the specific energy of that.
constexpr double kGraded_g_cm3 = 0.8, kSoft_g_cm3 = 0.1;

/// A heavy hand on soft bone, from rest in full contact. `thrust_n` sets how much of the resistance is not linear.
Push heavy(double thrust_n, double rate_hz, double time_s) {
  const double begin = kExample.full_contact_mm() + 0.3;
  Push push{.head = head_of(kExample), .voxel_mm = 0.5, .rate_hz = rate_hz, .begin_mm = begin, .block_mm = begin + 6};
  push.density = [](const Vec3&) { return kGraded_g_cm3; };
  push.energy_factor = std::pow(kSoft_g_cm3 / kGraded_g_cm3, kDensityExponent);
  push.settings.approach_mm = 0;
  push.settings.thrust_n = thrust_n;
  push.settings.max_feed_mm_s = 100;
  push.settings.mass_kg = 10;
  push.settings.until = PushEnd::time;
  push.settings.time_s = time_s;
  return push;
}

constexpr double kTimeLimit = 0.02;
constexpr double kRigid_n_mm = ComplianceSettings::kRigid_n_mm;

/// The deflection of a steady plunge, over the last voxel of feed. The tool reaches full contact at many times the feed
/// rate, with a deflection to match, which the voxels before let decay.
Vec3 steady_deflection_mm(PlungeRun run, const ComplianceSettings& springs, const Setting& setting) {
  run.compliance = springs;
  run.voxels = 4;
  const std::vector<FrameResult> rows = steady_rows(run, setting);
  Vec3 sum = Vec3::Zero();
  for (const FrameResult& row : std::span(rows).last(static_cast<std::size_t>(run.frames))) sum += *row.deflection_mm;
  return sum / static_cast<double>(run.frames);
}

/// The example fed from full contact and no deflection.
Reamed approach_of(double stiffness_n_mm, double damping_n_s_mm, double time_s, const Setting& setting) {
  constexpr double kVoxel_mm = 0.5, kRate_hz = 1000;
  const Vec3 entry = entry_mm(kVoxel_mm);
  const double begin = kExample.full_contact_mm() + 0.3, end = begin + kExample.feed_mm_s * time_s;
  const Motion motion =
      path(kRate_hz, entry - Vec3(0, 0, begin),
           {{entry - Vec3(0, 0, end), static_cast<int>(std::lround(kRate_hz * time_s)), kExample.rpm}});
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

void push_steady_case(const Setting& setting, Report& out) {
  out.title = "Feed rate under a constant thrust";
  out.scene =
      "cannulated reamer (R 29, a 15, r₀ 1.25 mm, 250 rpm) in full contact in ρ 1.8 g/cm³, pushed with 20, 50 and 100 "
      "N; "
      "mean feed over a voxel; flat head through layers of 1.8 and 0.4 g/cm³";
  out.form = "A·v + B·v² = F with A = 2πk_n·(u/ω)·[C(a) − C(r₀)], B = 2πu·ln(a/r₀)/ω²";
  for (const double thrust_n : {20.0, 50.0, 100.0}) {
    const double found = steady_feed(kExample, thrust_n, setting.quick ? 0.5 : 0.25, setting);
    out.relative(fmt::format("feed at {:g} N", thrust_n), "mm/s", quadratic_feed(kExample, thrust_n), found,
                 kFeedLimit);
  }
  constexpr double kLayer_mm = 1.5, kVoxel_mm = 0.5, kThrust_n = 50;
  Push push{.head = head_of(kFlatExample), .voxel_mm = kVoxel_mm, .rate_hz = 100, .begin_mm = 0.3, .block_mm = 4};
  push.density = [](const Vec3& p) { return p.z() > -kLayer_mm ? 1.8 : 0.4; };
  push.settings = {.approach_mm = 0, .thrust_n = kThrust_n, .max_feed_mm_s = 20, .depth_mm = 2.5};
  const Reamed reamed = pushed(push, setting);
  SteadyPlunge soft = kFlatExample;
  soft.density_g_cm3 = 0.4;
  out.relative("feed in the upper layer, flat head", "mm/s", balanced_feed_of(kFlatExample, kThrust_n),
               mean_feed(reamed, 0.6, 1.1), kFeedLimit);
  out.relative("feed in the lower layer, flat head", "mm/s", balanced_feed_of(soft, kThrust_n),
               mean_feed(reamed, 1.8, 2.3), kFeedLimit);
  out.relative("ratio of the linear parts", "", 20.25, linear_resistance(kFlatExample) / linear_resistance(soft), 1e-9,
               "(1.8/0.4)²");
}

void push_ball_case(const Setting& setting, Report& out) {
  out.title = "Time to a depth under a constant thrust";
  out.scene = "head without bore (R 29, a 15 mm, 250 rpm) from first contact in ρ 1.8 g/cm³ under 50 N, at most 5 mm/s";
  out.form = "t(d) = ∫dδ/v(δ), where the force on the cap of depth δ at feed v, with the speed floor, is the thrust";
  const SteadyPlunge head = example_with(&SteadyPlunge::bore_mm, 0);
  const double deepest = setting.quick ? 1 : 4;
  Push push{.head = convex_profile(29, 15, 0, kPushHead_mm, kPushEdge_mm),
            .voxel_mm = 0.25,
            .rate_hz = 500,
            .block_mm = deepest + 1,
            .width_mm = setting.quick ? 20.0 : 33.0};
  push.settings = {.approach_mm = 0.2, .depth_mm = deepest + 0.02};
  const Reamed reamed = pushed(push, setting);
  const double contact_s = time_at(reamed, 0);
  const auto add = [&](double depth_mm) {
    out.relative(fmt::format("time from contact to {:g} mm", depth_mm), "s", time_to_depth_s(head, 50, 5, depth_mm),
                 time_at(reamed, depth_mm) - contact_s, kFeedLimit);
  };
  add(1);
  if (!setting.quick) add(4);
}

void push_mass_case(const Setting& setting, Report& out) {
  out.title = "Mass of the hand";
  out.scene = "the reamer in full contact in ρ 0.1 g/cm³, pushed from rest with a mass of 10 kg";
  out.form = "M·dv/dt = F − A·v − B·v²; for a small thrust v = F/A·(1 − exp(−t/τ)) with τ = M/A";
  const SteadyPlunge soft = example_with(&SteadyPlunge::density_g_cm3, kSoft_g_cm3);
  constexpr double kSmall_n = 0.2;
  const Reamed slow = pushed(heavy(kSmall_n, 1000, 0.06), setting);
  const double steady = quadratic_feed(soft, kSmall_n);
  out.relative(
      "τ from the velocities at 5 and 30 ms", "ms", 10 / linear_resistance(soft),
      1e3 * time_constant_s(slow, 5, 30, [&](const FrameResult& row) { return 1 - row.push->velocity_mm_s / steady; }),
      0.02);
  constexpr double kThrust_n = 2;
  Refinement travel{"travel in 32 ms under 2 N", "mm", "frame, s", travel_of_mass_mm(soft, kThrust_n, 10, 0.032)};
  for (const double frame_s : {8e-3, 4e-3, 2e-3, 1e-3}) {
    const Reamed reamed = pushed(heavy(kThrust_n, 1 / frame_s, 0.032), setting);
    add_level(travel, frame_s, depth_of(reamed.rows.back()) - depth_of(reamed.rows.front()));
  }
  out.refinement(std::move(travel), kFeedLimit);
}

void push_stall_case(const Setting& setting, Report& out) {
  out.title = "Stall below the edge force";
  out.scene = "flat cannulated head in contact (a 15, r₀ 1.25 mm, 250 rpm), one cutting edge of 1 N/mm normal force";
  out.form = "no feed below F_edge = K_n·(a − r₀); above, the feed of F − F_edge";
  constexpr double kMore_n = 100;
  const double edge_n = kFlatExample.outer_mm - kFlatExample.bore_mm;
  const auto run = [&](double thrust_n) {
    Push push{.head = head_of(kFlatExample), .voxel_mm = 0.5, .rate_hz = 100, .begin_mm = 0.3, .block_mm = 3};
    push.edge = EdgeForceSettings{.tangential_n_mm = 1e-6, .normal_n_mm = 1};
    push.settings = {.approach_mm = 0, .thrust_n = thrust_n, .until = PushEnd::stall, .time_s = 2};
    return pushed(push, setting);
  };
  const Reamed below = run(0.95 * edge_n), above = run(edge_n + kMore_n);
  out.absolute("travel below the edge force", "mm", 0, depth_of(below.rows.back()) - depth_of(below.rows.front()),
               1e-12, "the bone holds the thrust");
  out.at_most("the stall ends the push", "s", 0.2, below.rows.back().time_s, "0.1 s");
  out.relative("feed 100 N above it", "mm/s", balanced_feed_of(kFlatExample, kMore_n), mean_feed(above, 0.35, 0.85),
               kFeedLimit);
}

void push_energy_case(const Setting& setting, Report& out) {
  out.title = "Energy of a push";
  out.scene =
      "head without bore from first contact through two layers (1.8 and 0.4 g/cm³) with 0.5 kg and 0.5 N·s/mm, to 1.5 "
      "mm";
  out.form = "work of the hand + work of the drive + E_floor = E_cut + kinetic + damping energy + loss within frames";
  Push push{.head = convex_profile(12, 5, 0, kPushHead_mm, 0.05), .voxel_mm = 0.25, .rate_hz = 500, .block_mm = 3};
  push.width_mm = 13;
  push.density = [](const Vec3& p) { return p.z() > -1 ? 1.8 : 0.4; };
  push.settings = {.approach_mm = 0.2, .thrust_n = 40, .depth_mm = 1.5, .mass_kg = 0.5, .damping_n_s_mm = 0.5};
  const Reamed reamed = pushed(push, setting);
  const double floor = reamed.sum(&FrameResult::floor_energy_mj), cut = reamed.sum(&FrameResult::energy_mj);
  const FeedState& feed = reamed.feed;
  const double given = feed.hand_mj + feed.spindle_work_mj + floor;
  const double taken = cut + feed.kinetic_mj + feed.damping_mj + feed.lost_mj;
  out.reported("work of the hand", "mJ", feed.hand_mj);
  out.reported("work of the drive", "mJ", feed.spindle_work_mj);
  out.reported("damping energy", "mJ", feed.damping_mj);
  out.reported("loss within frames", "mJ", feed.lost_mj);
  out.relative("both sides", "mJ", taken, given, 1e-4);
}

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
    out.relative(fmt::format("d at {:g} N/mm", k), "mm", kExample.axial_force_n() / k, found.z(), kFeedLimit);
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
