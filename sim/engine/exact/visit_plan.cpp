#include "sim/engine/exact/visit_plan.h"

#include <algorithm>

#include "sim/engine/common/broad_phase.h"

namespace reamsim {

namespace {

Mat3 tool_from_voxel(const SubstepArgs& args) {
  // Stored row by row.
  return Eigen::Map<const Mat3>(args.tool_from_voxel).transpose();
}

/// The turn of the teeth about the spin axis.
Mat3 teeth_turn(const SubstepArgs& args) {
  const double c = double{args.spin_cos}, s = double{args.spin_sin};
  Mat3 turn = Mat3::Identity();
  turn.topLeftCorner<2, 2>() << c, -s, s, c;
  return turn;
}

/// How far a point of the lattice that lies in `box` (T) in substep `b` can be from where it is in substep `a`, mm. The
/// way is linear in the point, so that its length is greatest in a corner. `spin`: how far the tool turns back from `b`
/// to `a` beside.
double longest_way(const SubstepArgs& a, const SubstepArgs& b, const Aabb& box, const Mat3& spin) {
  const Mat3 turn = spin * tool_from_voxel(a) * tool_from_voxel(b).inverse();
  const Vec3 shift = spin * Eigen::Map<const Vec3>(a.tool_origin) - turn * Eigen::Map<const Vec3>(b.tool_origin);
  double longest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p((corner & 1) != 0 ? box.max.x() : box.min.x(), (corner & 2) != 0 ? box.max.y() : box.min.y(),
                 (corner & 4) != 0 ? box.max.z() : box.min.z());
    longest = std::max(longest, (turn * p + shift - p).norm());
  }
  return longest;
}

/// The same for points that lie in the box in the frame that turns with the teeth, and no less than without the spin.
double longest_way_of_teeth(const SubstepArgs& a, const SubstepArgs& b, const Aabb& box) {
  const double still = longest_way(a, b, box, Mat3::Identity());
  if (a.spin_cos == b.spin_cos && a.spin_sin == b.spin_sin) return still;
  return std::max(still, longest_way(a, b, box, teeth_turn(b).transpose() * teeth_turn(a)));
}

void include(const VoxelBox& part, VoxelBox& whole) {
  if (part.empty()) return;
  whole.first = whole.empty() ? part.first : Vec3i(whole.first.cwiseMin(part.first));
  whole.last = whole.last.cwiseMax(part.last);
}

}  // namespace

VisitPlan plan_visit(std::span<const SubstepArgs> args, int first, int most, const Aabb& tool_box,
                     const VoxelBox& bone) {
  const double voxel_mm = args[static_cast<std::size_t>(first)].voxel_mm;
  const Aabb box = tool_box.expanded(voxel_mm);  // a voxel that the surface meets may stick out
  const auto at = [&](int slot) -> const SubstepArgs& { return args[static_cast<std::size_t>(slot)]; };
  VisitPlan plan{.first = first, .end = first, .windows = {}, .superbricks = {Vec3i::Zero(), Vec3i::Constant(-1)}};
  const int last = std::min(static_cast<int>(args.size()), first + std::min(most, RS_VISIT_SUBSTEPS));
  for (int slot = first; slot < last; ++slot) {
    const double way = longest_way(at(first), at(slot), box, Mat3::Identity());
    if (slot > first && way > kVisitShiftVoxels * voxel_mm) break;
    SubstepWindow* window = plan.windows.empty() ? nullptr : &plan.windows.back();
    const double here =
        window == nullptr ? 0 : longest_way_of_teeth(at(static_cast<int>(window->first)), at(slot), box);
    if (window == nullptr || here > kWindowShiftVoxels * voxel_mm) {
      plan.windows.push_back({static_cast<rs_u32>(slot), 0, 0});
      window = &plan.windows.back();
    } else {
      window->shift_mm = std::max(window->shift_mm, static_cast<float>(here));
    }
    window->end = static_cast<rs_u32>(slot + 1);
    plan.end = slot + 1;
    plan.shift_mm = std::max(plan.shift_mm, static_cast<float>(way));
    include(voxel_voi(at(slot), box, bone), plan.superbricks);
  }
  constexpr int kSuperbrickVoxels = 4 * RS_BRICK_SIDE;
  if (!plan.superbricks.empty()) {
    plan.superbricks.first /= kSuperbrickVoxels;
    plan.superbricks.last /= kSuperbrickVoxels;
  }
  return plan;
}

}  // namespace reamsim
