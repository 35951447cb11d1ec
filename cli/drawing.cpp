#include "cli/drawing.h"

#include "render/pictures/results.h"
#include "sim/scenario/picture_frames.h"

namespace reamsim {

namespace {

/// The pose that forces.csv is read for, so that a run that is drawn again looks the same to the last bit.
ToolPose as_logged(ToolPose pose) {
  pose.orientation.normalize();
  // There is no −0 in it.
  pose.position_mm.array() += 0.0;
  pose.orientation.coeffs().array() += 0.0;
  pose.spin_angle_rad += 0.0;
  return pose;
}

RunPlan plan_of(const ReamingScene& scene, const std::string& dir) {
  RunPlan plan;
  plan.dir = dir;
  plan.bone = scene.bone.voxmap;
  plan.fill_before = scene.bone.fill;
  plan.whole_voxels = scene.scenario.cutting.erosion != ErosionMode::exact;
  plan.glenoid = scene.bone.glenoid;
  plan.side = scene.bone.side;
  plan.poses = scene.motion.poses;
  for (ToolPose& pose : plan.poses) pose = as_logged(pose);
  for (std::int64_t k = 0; k < std::ssize(plan.poses); ++k) plan.pose_frames.push_back(k);
  plan.frames = picture_frames(scene.scenario.render, plan.pose_frames.back());
  plan.tool = read_tool(dir);
  return plan;
}

}  // namespace

std::unique_ptr<Drawing> begin_drawing(const ReamingScene& scene, const std::string& dir) {
  const RenderSettings& settings = scene.scenario.render;
  if (!settings.enabled && !scene.scenario.output.meshes) return nullptr;
  auto drawing = std::make_unique<Drawing>(plan_of(scene, dir));
  if (settings.enabled) {
    drawing->photographer = std::make_unique<Photographer>(drawing->run, settings, PictureChoice(), drawing->snapshots);
  }
  return drawing;
}

}  // namespace reamsim
