#include "render/pictures/view_target.h"

#include <algorithm>
#include <cmath>

namespace reamsim {
namespace {

/// The tool's head: what lies no farther than this above its lowest point. The shaft may leave the picture.
constexpr double kHead_mm = 12;

void from_glenoid(ViewTarget& target, const GlenoidFrame& glenoid, const std::string& side, const std::string& frame) {
  const Mat3 axes = glenoid.bone_from_glenoid.linear();
  target.bone_from_glenoid = glenoid.bone_from_glenoid;
  target.focus_mm = glenoid.bone_from_glenoid.translation();
  target.outward = axes.col(2);
  target.superior = axes.col(1);
  target.anatomical = true;
  // +x of G is superior × lateral: posterior on a left shoulder, anterior on a right one.
  if (side == "left") target.anterior = -axes.col(0);
  if (side == "right") target.anterior = axes.col(0);
  // In patient coordinates +y is posterior, whatever the side.
  if (side.empty() && frame == "LPS") target.anterior = axes(1, 0) > 0 ? Vec3(-axes.col(0)) : Vec3(axes.col(0));
}

void from_tool(ViewTarget& target) {
  target.focus_mm = target.bone_from_tool.translation();
  target.outward = target.bone_from_tool.linear().col(2);
  // Up in the picture is +z of B, or +y where the tool points along z.
  const Vec3 up = std::abs(target.outward.z()) < 0.9 ? Vec3::UnitZ() : Vec3::UnitY();
  target.superior = (up - up.dot(target.outward) * target.outward).normalized();
}

}  // namespace

ViewTarget make_view_target(const RunInputs& run, const ToolPose& deepest, const IsoSurface& bone) {
  ViewTarget target;
  target.bone_from_tool = deepest.bone_from_tool();
  if (run.glenoid) {
    from_glenoid(target, *run.glenoid, run.side, run.voxmap->frame);
  } else {
    from_tool(target);
  }
  const VoxelGrid& grid = run.voxmap->grid;
  for (const Eigen::Vector3f& p : bone.points) {
    target.bone_mm.emplace_back(grid.origin_mm + grid.voxel_mm * (p.cast<double>() + Vec3::Constant(0.5)));
    target.reach_mm = std::max(target.reach_mm, (target.bone_mm.back() - target.focus_mm).norm());
  }
  double tool_reach_mm = 0;
  double lowest_mm = run.tool.bounds().min.z();
  for (const Vec3& v : run.tool.vertices) {
    tool_reach_mm = std::max(tool_reach_mm, v.norm());
    if (v.z() < lowest_mm + kHead_mm) target.head_mm.push_back(target.bone_from_tool * v);
  }
  for (const ToolPose& pose : run.poses) {
    const double away_mm = (pose.position_mm - target.focus_mm).norm() + tool_reach_mm;
    target.reach_mm = std::max(target.reach_mm, away_mm);
  }
  return target;
}

}  // namespace reamsim
