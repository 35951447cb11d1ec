// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// Removed volumes against closed forms.
#include <limits>
#include <numbers>

#include "sim/verify/suite.h"

namespace reamsim::verify {

namespace {

using std::numbers::pi;

// The reamer of the example in docs/physics.md, 6.
constexpr double kRadius_mm = 29, kDepth_mm = 4;
constexpr double kBlockEdge_mm = 0.05;
constexpr double kVolumeRate_hz = 1000;
constexpr double kVolumeClear_mm = 0.1;
constexpr int kPlungeFrames = 40;
constexpr unsigned kSeed = 29;

Quat tilt(double degrees, double towards_rad) {
  return Quat(Eigen::AngleAxisd(degrees * pi / 180, Vec3(std::cos(towards_rad), std::sin(towards_rad), 0)));
}

/// The ball plunged into the top face of the block, its axis rotated, its centre above (offset x, offset y).
Sample plunged_ball(const Tool& tool, double voxel_mm, const Vec3& offset_mm, const Quat& turned, ErosionMode erosion,
                    const Setting& setting) {
  // The depth varies instead of the face, which is a boundary between layers of voxels.
  const double depth = kDepth_mm + offset_mm.z();
  const auto origin = [&](double z) {
    return ball_origin({offset_mm.x(), offset_mm.y(), kRadius_mm - z}, kRadius_mm, turned);
  };
  const double width = 2 * std::sqrt(2 * kRadius_mm * kDepth_mm) + 4 * voxel_mm + 4;
  const Motion motion = path(kVolumeRate_hz, origin(-kVolumeClear_mm), {{origin(depth), kPlungeFrames, 250, turned}});
  const Reamed reamed =
      ream(scene_of(block({width, width, kDepth_mm + 4}, voxel_mm, kReferenceDensity_g_cm3), tool, motion, erosion),
           setting);
  return {cap_mm3(kRadius_mm, depth), reamed.removed_mm3()};
}

/// At the next finer level the error of the cap would be rounding in single precision and 16 bits of fill.
constexpr double kFinestVoxel_mm = 0.25;

Refinement volume_refinement(double nominal_mm3) {
  return {"removed volume", "mm³", "voxel, mm", nominal_mm3};
}

constexpr double kOrderLimit = 1.8;
constexpr double kAim = 5e-5;
const char* const kAimReason = "aim of this project at 0.25 mm; its limit is 0.02 %";

void check_order(const Refinement& refinement, Report& out) {
  out.at_least("observed order", "", kOrderLimit, refinement.order.value_or(std::numeric_limits<double>::quiet_NaN()),
               "a plane in each voxel is of second order; 0.2 for scatter");
}

/// Root mean square over tilts of 0 to 60° at random offsets, by erosion and voxel size.
Level tilted_level(const Tool& tool, double voxel_mm, int tilts, ErosionMode erosion, const Setting& setting) {
  std::mt19937 random(kSeed);
  std::vector<Sample> samples;
  for (int i = 0; i < tilts; ++i) {
    const Vec3 offset = draw_offset(random, voxel_mm);
    samples.push_back(plunged_ball(tool, voxel_mm, offset, tilt(60.0 * i / (tilts - 1), 1.0 * i), erosion, setting));
  }
  return level_of(voxel_mm, samples, cap_mm3(kRadius_mm, kDepth_mm));
}

constexpr double kOuter_mm = 8, kLength_mm = 5;

/// A flat-ended cylinder plunged along its axis, at random offsets.
Level plunged_cylinder(const Tool& tool, double voxel_mm, const Quat& turned, int runs, const Setting& setting) {
  constexpr int kFrames = 120;
  constexpr double kEntry_mm = 4;  // clear of the face even when tilted
  std::mt19937 random(kSeed);
  const Vec3 axis = turned * Vec3(0, 0, 1);
  std::vector<Sample> samples;
  for (int i = 0; i < runs; ++i) {
    const Vec3 offset = draw_offset(random, voxel_mm), entry(offset.x(), offset.y(), 0);
    const double length = kLength_mm + offset.z();
    const Motion motion =
        path(kVolumeRate_hz, entry + kEntry_mm * axis, {{entry - length * axis, kFrames, 250, turned}});
    const SimulationInput scene = scene_of(block({24, 24, 11}, voxel_mm, kReferenceDensity_g_cm3), tool, motion);
    samples.push_back({pi * kOuter_mm * kOuter_mm * length, ream(scene, setting).removed_mm3()});
  }
  return level_of(voxel_mm, samples, pi * kOuter_mm * kOuter_mm * kLength_mm);
}

}  // namespace

void half_space_case(const Setting& setting, Report& out) {
  out.title = "Half-space and spherical cap";
  out.scene = "ball of 29 mm radius plunged 4 mm into the face of a block, along a lattice axis, centred on a vertex";
  out.form = "π·d²·(R − d/3)";
  const double cap = cap_mm3(kRadius_mm, kDepth_mm);
  const Tool tool = make_tool(ball_profile(kRadius_mm, kBlockEdge_mm));
  Refinement refinement = volume_refinement(cap);
  for (const double voxel_mm : four_voxels(kFinestVoxel_mm)) {
    const Sample sample = plunged_ball(tool, voxel_mm, Vec3::Zero(), Quat::Identity(), ErosionMode::exact, setting);
    refinement.levels.push_back(level_of(voxel_mm, {sample}, cap));
  }
  out.refinement(std::move(refinement), kAim, kAimReason);
  check_order(out.refinements.back(), out);
}

void tilted_cap_case(const Setting& setting, Report& out) {
  constexpr double kLimitVoxel_mm = 0.25, kLeastRatio = 50;
  constexpr double kShellVoxels = 0.4721;  // the default of a run
  out.title = "Cap under tilt and random sub-voxel offset";
  const int tilts = setting.quick ? 4 : 13;
  out.scene = "the same ball, its axis tilted by 0 to 60° in " + std::to_string(tilts) +
              " steps, offset at random by up to half a voxel along each axis (seed " + std::to_string(kSeed) + ")";
  out.form = "π·d²·(R − d/3)";
  const Tool tool = make_tool(ball_profile(kRadius_mm, kBlockEdge_mm));
  Refinement refinement = volume_refinement(cap_mm3(kRadius_mm, kDepth_mm));
  double at_limit = std::numeric_limits<double>::quiet_NaN();
  for (const double voxel_mm : four_voxels(kFinestVoxel_mm)) {
    refinement.levels.push_back(tilted_level(tool, voxel_mm, tilts, ErosionMode::exact, setting));
    if (voxel_mm == kLimitVoxel_mm) at_limit = *refinement.levels.back().error;
  }
  finish(refinement);
  const Tool sampled = make_tool(ball_profile(kRadius_mm, 10 * kBlockEdge_mm), kShellVoxels * kLimitVoxel_mm);
  const double whole = *tilted_level(sampled, kLimitVoxel_mm, 2, ErosionMode::remove, setting).error;
  out.at_most("RMS volume error at 0.25 mm, exact", "", kAim, at_limit, kAimReason);
  check_order(refinement, out);
  out.reported("RMS volume error at 0.25 mm, remove", "", whole, "beside it");
  out.at_least("remove / exact", "", kLeastRatio, whole / at_limit);
  out.refinements.push_back(std::move(refinement));
}

void cylinder_case(const Setting& setting, Report& out) {
  out.title = "Cylinder plunge";
  out.scene =
      "flat-ended cylinder of 8 mm radius, along its axis, perpendicular to the face and tilted by 20°, 5 mm of the "
      "axis in bone, random offsets";
  out.form = "π·a²·L, L the length of the axis below the face";
  const Tool tool = make_tool(flat_profile(kOuter_mm, 0, 20));
  for (const double degrees : {0.0, 20.0}) {
    Refinement refinement = volume_refinement(pi * kOuter_mm * kOuter_mm * kLength_mm);
    refinement.quantity += degrees > 0 ? ", tilted" : ", square";
    for (const double voxel_mm : four_voxels(setting.quick ? 0.125 : 0.0625)) {
      refinement.levels.push_back(plunged_cylinder(tool, voxel_mm, tilt(degrees, 0.4), setting.quick ? 2 : 6, setting));
    }
    out.refinement(std::move(refinement), kAim, kAimReason);
  }
}

void sweep_case(const Setting& setting, Report& out) {
  constexpr double kBall_mm = 8, kDeep_mm = 3, kSweep_mm = 10, kStep_mm = 0.05;
  out.title = "Sideways sweep";
  out.scene = "ball of 8 mm radius plunged 3 mm, then moved 10 mm sideways at 25° to the lattice in steps of 0.05 mm";
  out.form =
      "π·d²·(R − d/3) + L·[R²·acos((R − d)/R) − (R − d)·√(2Rd − d²)]: "
      "the part of a capsule below the face";
  const double volume = cap_mm3(kBall_mm, kDeep_mm) + kSweep_mm * segment_mm2(kBall_mm, kDeep_mm);
  const Tool tool = make_tool(ball_profile(kBall_mm, kBlockEdge_mm));
  const Quat turned = tilt(20, 0.7);
  const Vec3 way = kSweep_mm * Vec3(std::cos(25 * pi / 180), std::sin(25 * pi / 180), 0);
  Refinement refinement = volume_refinement(volume);
  for (const double voxel_mm : four_voxels(setting.quick ? 0.125 : 0.0625)) {
    const Vec3 start(-0.5 * way.x() + 0.31 * voxel_mm, -0.5 * way.y() + 0.17 * voxel_mm, kBall_mm - kDeep_mm);
    const auto origin = [&](const Vec3& center) { return ball_origin(center, kBall_mm, turned); };
    const Motion motion = path(
        kVolumeRate_hz, origin(start + Vec3(0, 0, kDeep_mm + kVolumeClear_mm)),
        {{origin(start), 62, 250, turned}, {origin(start + way), static_cast<int>(kSweep_mm / kStep_mm), 250, turned}});
    const SimulationInput scene = scene_of(block({30, 24, 5}, voxel_mm, kReferenceDensity_g_cm3), tool, motion);
    add_level(refinement, voxel_mm, ream(scene, setting).removed_mm3());
  }
  out.refinement(std::move(refinement), 2e-4,
                 "limit of the cap; the ridges between two frames are 1.3·10⁻⁵ of the volume");
}

}  // namespace reamsim::verify
