#include "render/pictures/subject.h"

#include <algorithm>
#include <cmath>

namespace reamsim {
namespace {

/// The tool's head: what lies no farther than this above its lowest point. The shaft may leave the picture.
constexpr double kHead_mm = 12;

void from_glenoid(Subject& subject, const GlenoidFrame& glenoid, BodySide side, const std::string& frame) {
  const Mat3 axes = glenoid.bone_from_glenoid.linear();
  subject.bone_from_glenoid = glenoid.bone_from_glenoid;
  subject.focus_mm = glenoid.bone_from_glenoid.translation();
  subject.outward = axes.col(2);
  subject.superior = axes.col(1);
  subject.anatomical = true;
  // +x of G is superior × lateral: posterior on a left shoulder, anterior on a right one.
  if (side == BodySide::left) subject.anterior = -axes.col(0);
  if (side == BodySide::right) subject.anterior = axes.col(0);
  // In patient coordinates +y is posterior, whatever the side.
  if (side == BodySide::unknown && frame == "LPS")
    subject.anterior = axes(1, 0) > 0 ? Vec3(-axes.col(0)) : Vec3(axes.col(0));
}

void from_tool(Subject& subject) {
  subject.focus_mm = subject.bone_from_tool.translation();
  subject.outward = subject.bone_from_tool.linear().col(2);
  // Up in the picture is +z of B, or +y where the tool points along z.
  const Vec3 up = std::abs(subject.outward.z()) < 0.9 ? Vec3::UnitZ() : Vec3::UnitY();
  subject.superior = (up - up.dot(subject.outward) * subject.outward).normalized();
}

}  // namespace

Subject make_subject(const RunPlan& plan, const ToolPose& deepest, const UnreamedSurface& unreamed) {
  Subject subject;
  subject.bone_from_tool = deepest.bone_from_tool();
  if (plan.glenoid) {
    from_glenoid(subject, *plan.glenoid, plan.side, plan.bone->frame);
  } else {
    from_tool(subject);
  }
  const VoxelGrid& grid = plan.bone->grid;
  for (const openvdb::Vec3s& p : unreamed.surface().points) {
    const Vec3 index(p.x(), p.y(), p.z());
    subject.bone_mm.emplace_back(grid.origin_mm + grid.voxel_mm * (index + Vec3::Constant(0.5)));
    subject.reach_mm = std::max(subject.reach_mm, (subject.bone_mm.back() - subject.focus_mm).norm());
  }
  double tool_reach_mm = 0;
  double lowest_mm = plan.tool.bounds().min.z();
  for (const Vec3& v : plan.tool.vertices) {
    tool_reach_mm = std::max(tool_reach_mm, v.norm());
    if (v.z() < lowest_mm + kHead_mm) subject.head_mm.push_back(subject.bone_from_tool * v);
  }
  for (const ToolPose& pose : plan.poses) {
    const double away_mm = (pose.position_mm - subject.focus_mm).norm() + tool_reach_mm;
    subject.reach_mm = std::max(subject.reach_mm, away_mm);
  }
  return subject;
}

}  // namespace reamsim
