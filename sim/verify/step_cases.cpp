// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Refinement in time and space, and settings that must not change the result.

#include "sim/verify/suite.h"

namespace reamsim::verify {

namespace {

constexpr double kStepDensity = 1.8;

// A ball swept sideways.
constexpr double kBall_mm = 8, kDeep_mm = 3, kSweep_mm = 8, kSpeed_mm_s = 10, kStepVoxel_mm = 0.5;
constexpr int kDownFrames = 64;

SimulationInput swept_ball(double frame_s, std::optional<double> shell_spacing_mm) {
  const Vec3 way = kSweep_mm * Vec3(std::cos(0.6), std::sin(0.6), 0);
  const Vec3 start(-0.5 * way.x() + 0.15, -0.5 * way.y() + 0.07, kBall_mm - kDeep_mm);
  const auto origin = [](const Vec3& center) { return ball_origin(center, kBall_mm, Quat::Identity()); };
  const int frames = static_cast<int>(std::lround(kSweep_mm / (kSpeed_mm_s * frame_s)));
  const Motion motion = path(1 / frame_s, origin(start + Vec3(0, 0, kDeep_mm + 0.1)),
                             {{origin(start), kDownFrames}, {origin(start + way), frames}});
  return scene_of(block({26, 22, 5}, kStepVoxel_mm, kStepDensity),
                  make_tool(ball_profile(kBall_mm, 0.05), shell_spacing_mm), motion);
}

/// Results of the sweep, without the plunge before it.
struct Sweep {
  double removed_mm3 = 0;  ///< with the plunge
  MeanLoads loads;
};

Sweep sweep_of(const SimulationInput& scene, const Setting& setting) {
  const Reamed reamed = ream(scene, setting);
  return {reamed.removed_mm3(), mean_loads(reamed.after(kDownFrames))};
}

/// Compares runs under settings that must not change the result.
void add_indifference(const Sweep& plain, const Setting& setting, Report& out) {
  const std::string reason = "no shell is used and sums are integers: the same numbers";
  const auto add = [&](const std::string& what, const Sweep& other) {
    out.absolute("removed volume, " + what, "mm³", plain.removed_mm3, other.removed_mm3, 0, reason);
    out.absolute("mean force, " + what, "N", plain.loads.force_n.norm(), other.loads.force_n.norm(), 0, reason);
  };
  constexpr double kFrame_s = 4e-3;
  for (const int batch : {1, 7}) {
    SimulationInput scene = swept_ball(kFrame_s, {});
    scene.scenario.engine.batch_frames = batch;
    add("batches of " + std::to_string(batch), sweep_of(scene, setting));
  }
  add("shell of 0.5 mm spacing", sweep_of(swept_ball(kFrame_s, 0.5), setting));
}

constexpr SteadyPlunge kStepHead{12, 5, 1, 250, 0.2, kStepDensity};

/// Mean loads of the head in full contact, fed along a tilted axis by 1 mm, entering at `entry`. The axial parts and
/// the volume per second are what counts.
MeanLoads tilted_plunge(const Tool& tool, double voxel_mm, const Vec3& entry, const Setting& setting) {
  constexpr double kBegin_mm = 5.5, kTravel_mm = 1;
  constexpr int kFrames = 200, kFramesDown = 110;
  const Quat turned = rotation({1, 0.4, 0}, 25);
  const Vec3 axis = turned * Vec3(0, 0, 1), begin = entry - kBegin_mm * axis, end = begin - kTravel_mm * axis;
  const double seconds = kTravel_mm / kStepHead.feed_mm_s;
  const Motion motion = path(kFrames / seconds, entry + 3 * axis,
                             {{begin, kFramesDown, kStepHead.rpm, turned}, {end, kFrames, kStepHead.rpm, turned}});
  const Reamed reamed = ream(scene_of(block({22, 22, 10}, voxel_mm, kStepDensity), tool, motion), setting);
  MeanLoads mean = mean_loads(reamed.after(kFramesDown));
  mean.removed_mm3 /= seconds;
  return mean;
}

}  // namespace

void time_step_case(const Setting& setting, Report& out) {
  out.title = "Time-step halving";
  out.scene =
      "ball of 8 mm radius plunged 3 mm, then moved 8 mm sideways at 10 mm/s, 0.5 mm voxels; frame time halved three "
      "times; then other batches and another shell";
  out.form = "volume of the part of a capsule below the face; mean loads of the sweep do not change";
  Refinement volume{"removed volume", "mm³", "frame, s", {}};
  Refinement torque{"mean spin torque", "N·mm", "frame, s", {}};
  Refinement force{"mean force", "N", "frame, s", {}};
  std::vector<Sweep> sweeps;
  for (const double frame_s : {4e-3, 2e-3, 1e-3, 0.5e-3}) {
    sweeps.push_back(sweep_of(swept_ball(frame_s, {}), setting));
    volume.levels.push_back({frame_s, sweeps.back().removed_mm3, {}, 1});
    torque.levels.push_back({frame_s, sweeps.back().loads.spin_torque_nmm, {}, 1});
    force.levels.push_back({frame_s, sweeps.back().loads.force_n.norm(), {}, 1});
  }
  for (Refinement* refinement : {&volume, &torque, &force}) finish(*refinement);
  const Sweep &fine = sweeps.back(), &before = sweeps[sweeps.size() - 2];
  const auto relative = [&](const std::string& what, const std::string& unit, double a, double b) {
    out.relative(what + ", 1 ms against 0.5 ms", unit, b, a, 1e-3);
  };
  const double swept_mm3 = cap_mm3(kBall_mm, kDeep_mm) + kSweep_mm * segment_mm2(kBall_mm, kDeep_mm);
  out.relative("removed volume, 0.5 ms", "mm³", swept_mm3, fine.removed_mm3, 1e-3,
               "0.5 mm voxels on a sphere of 8 mm radius; the case sweep shows the convergence");
  relative("removed volume", "mm³", before.removed_mm3, fine.removed_mm3);
  relative("mean spin torque", "N·mm", before.loads.spin_torque_nmm, fine.loads.spin_torque_nmm);
  relative("mean force", "N", before.loads.force_n.norm(), fine.loads.force_n.norm());
  add_indifference(sweeps[0], setting, out);
  out.refinements = {std::move(volume), std::move(torque), std::move(force)};
}

void voxel_case(const Setting& setting, Report& out) {
  out.title = "Voxel halving";
  out.scene =
      "cannulated convex head (R 12, a 5, r₀ 1 mm) in full contact, fed along an axis tilted by 25° at random offsets; "
      "means over 1 mm of feed";
  out.form = "as for the steady plunge, its integral over the face";
  const Tool tool = make_tool(convex_profile(*kStepHead.radius_mm, kStepHead.outer_mm, kStepHead.bore_mm, 12, 0.05));
  std::vector<Refinement> refinements = load_refinements(kStepHead);
  for (const double voxel_mm : four_voxels(setting.quick ? 0.125 : 0.0625)) {
    std::mt19937 random(25);
    std::vector<Sample> samples[3];
    for (int run = 0; run < (setting.quick ? 1 : 4); ++run) {
      const MeanLoads mean = tilted_plunge(tool, voxel_mm, draw_offset(random, voxel_mm), setting);
      const double found[] = {mean.spin_torque_nmm, mean.axial_force_n, mean.removed_mm3};
      for (std::size_t i = 0; i < refinements.size(); ++i) samples[i].push_back({*refinements[i].expected, found[i]});
    }
    for (std::size_t i = 0; i < refinements.size(); ++i) {
      refinements[i].levels.push_back(level_of(voxel_mm, samples[i], *refinements[i].expected));
    }
  }
  for (const Refinement& refinement : refinements) out.refinement(refinement, 5e-3, "limit of a steady plunge");
}

}  // namespace reamsim::verify
