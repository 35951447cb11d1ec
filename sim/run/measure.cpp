// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/run/measure.h"

#include <fmt/core.h>

#include "sim/base/stopwatch.h"
#include "sim/run/slow_trial.h"

namespace reamsim {

void measure(RunFacts& facts, const ReamingScene& scene, const FillBricks& fill_before, const RunTotals& totals) {
  const Stopwatch watch;
  const ReamedBone bone{*scene.bone.voxmap, fill_before, scene.bone.fill};
  const Rigid bone_from_tool = totals.deepest_pose.bone_from_tool();
  BoneAxes axes{.scapula = scene.bone.scapula, .glenoid = {}};
  axes.rim_mm = scene.bone.rim_mm;
  if (scene.bone.glenoid) {
    axes.glenoid = axes_of(*scene.bone.glenoid, scene.bone.side);
    axes.bone_from_glenoid = scene.bone.glenoid->bone_from_glenoid;
    axes.face_center_mm = axes.bone_from_glenoid->translation();
  }
  if (scene.bone.landmarks) axes.face_center_mm = scene.bone.landmarks->glenoid_center_mm;
  facts.metrics = measure_bone(bone, bone_from_tool, axes, scene.scenario.metrics);
  facts.depth_map = depth_map(bone, scene.bone.glenoid, bone_from_tool);
  facts.measure_s = watch.seconds();
}

void warn_of_rounding(const ReamingScene& scene, const RunTotals& totals, Report& report) {
  if (scene.scenario.cutting.erosion != ErosionMode::exact) return;
  const double enough_mm = kFirstLosses * smallest_advance_mm(scene.bone.voxmap->grid.voxel_mm);
  if (totals.peak_advance_mm == 0 || totals.peak_advance_mm >= enough_mm) return;
  report.warn(fmt::format(
      "the tool advances {:.2g} um in the frame of the peak force, near the smallest loss of a "
      "voxel: peaks of single frames are too large, while volume, energy and means are right; set "
      "motion.frame_rate_hz to {:.2g} or less",
      1000 * totals.peak_advance_mm, scene.scenario.motion.frame_rate_hz * totals.peak_advance_mm / enough_mm));
}

}  // namespace reamsim
