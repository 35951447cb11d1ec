// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/run/measure.h"

#include "sim/base/stopwatch.h"
#include "sim/bone/glenoid_frame.h"

namespace reamsim {

void measure(RunFacts& facts, const SimulationInput& scene, const FillBricks& fill_before, const RunTotals& totals) {
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

}  // namespace reamsim
