// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scene/predicted_passes.h"

#include <vector>

#include "sim/scene/swept_bone.h"
#include "sim/tool/bounded_path.h"

namespace reamsim {

namespace {

/// Motion of the tool between two poses of a long motion, voxels.
constexpr double kPassStep_voxels = 0.5;

FillBricks predicted_after(const SimulationInput& scene, const FillBricks& fill, const Tool& tool,
                           const Motion& motion) {
  if (motion.poses.empty()) return fill;
  BoundedPath path(tool.reach_mm, kPassStep_voxels * scene.bone.voxmap->grid.voxel_mm);
  path.add(motion.poses);
  std::vector<ToolPose> poses;
  for (const PathSample& sample : path.finish()) poses.push_back(sample.pose);
  const bool whole_voxels = scene.scenario.cutting.erosion != ErosionMode::exact;
  return predict_swept_bone(*scene.bone.voxmap, fill, tool.profile, poses, whole_voxels).fill;
}

}  // namespace

void for_each_predicted_pass(const SimulationInput& scene, const VisitPass& visit) {
  visit(scene.bone.fill, scene.tool, scene.motion);
  if (scene.later_passes.empty()) return;
  FillBricks fill = predicted_after(scene, scene.bone.fill, scene.tool, scene.motion);
  for (const Pass& pass : scene.later_passes) {
    visit(fill, pass.tool, pass.motion);
    fill = predicted_after(scene, fill, pass.tool, pass.motion);
  }
}

}  // namespace reamsim
