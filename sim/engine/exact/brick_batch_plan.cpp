// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/exact/brick_batch_plan.h"

#include <algorithm>
#include <cmath>

#include "sim/engine/common/substep.h"

namespace reamsim {

namespace {

/// The rotation of resolved cutting edges about the spin axis.
Mat3 spin_rotation(const SubstepArgs& args) {
  const double c = double{args.spin_cos}, s = double{args.spin_sin};
  Mat3 out = Mat3::Identity();
  out.topLeftCorner<2, 2>() << c, -s, s, c;
  return out;
}

/// Bound of the motion from substep `a` to `b` of a lattice point that lies in `box` (T) in `b`, mm. The displacement
/// is linear in the point, and so largest in a corner. `spin`: additional rotation of the tool from `b` back to `a`.
double motion_bound(const SubstepArgs& a, const SubstepArgs& b, const Aabb& box, const Mat3& spin = Mat3::Identity()) {
  const Eigen::Affine3d motion = spin * tool_from_voxel(a) * tool_from_voxel(b).inverse();
  double longest = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3 p = box.corner(corner);
    longest = std::max(longest, (motion * p - p).norm());
  }
  return longest;
}

/// The same in the frame that rotates with resolved cutting edges, and at least the bound without spin.
double motion_bound_with_spin(const SubstepArgs& a, const SubstepArgs& b, const Aabb& box) {
  const double without_spin = motion_bound(a, b, box);
  if (a.spin_cos == b.spin_cos && a.spin_sin == b.spin_sin) return without_spin;
  return std::max(without_spin, motion_bound(a, b, box, spin_rotation(b).transpose() * spin_rotation(a)));
}

void include(const VoxelBox& part, VoxelBox& whole) {
  if (part.empty()) return;
  whole.first = whole.empty() ? part.first : Vec3i(whole.first.cwiseMin(part.first));
  whole.last = whole.last.cwiseMax(part.last);
}

/// Adds a substep to the last window of the plan, or to a new one.
void add_to_window(std::span<const SubstepArgs> args, const MotionsOfSlots& motions, int slot, const Aabb& box,
                   BrickBatchPlan& plan) {
  const auto here = static_cast<std::size_t>(slot);
  const MotionWindow* motion = motions[here].get();
  SubstepWindow* window = plan.windows.empty() ? nullptr : &plan.windows.back();
  const bool same = window != nullptr && motions[window->first].get() == motion;
  if (motion != nullptr) {
    if (!same) {
      // Bound of the motion between any two frames of the window.
      const auto shift_mm = static_cast<float>(motion_bound(motion->first, motion->middle, box) +
                                               motion_bound(motion->middle, motion->last, box));
      plan.windows.push_back({static_cast<rs_u32>(slot), 0, shift_mm, static_cast<rs_i32>(plan.motions.size())});
      plan.motions.push_back(*motion);
    }
  } else {
    const double moved = same ? motion_bound_with_spin(args[window->first], args[here], box) : 0;
    if (!same || moved > kWindowShiftVoxels * double{args[here].voxel_mm}) {
      plan.windows.push_back({static_cast<rs_u32>(slot), 0, 0, -1});
    } else {
      window->shift_mm = std::max(window->shift_mm, static_cast<float>(moved));
    }
  }
  plan.windows.back().end = static_cast<rs_u32>(slot + 1);
}

}  // namespace

BrickBatchPlan plan_brick_batch(std::span<const SubstepArgs> args, const MotionsOfSlots& motions, int first, int most,
                                const Aabb& tool_box, const VoxelBox& bone) {
  const double voxel_mm = args[static_cast<std::size_t>(first)].voxel_mm;
  const Aabb box = tool_box.expanded(voxel_mm);  // an intersected voxel may protrude
  const auto at = [&](int slot) -> const SubstepArgs& { return args[static_cast<std::size_t>(slot)]; };
  BrickBatchPlan plan{
      .first = first, .end = first, .windows = {}, .motions = {}, .superbricks = {Vec3i::Zero(), Vec3i::Constant(-1)}};
  const int last = std::min(static_cast<int>(args.size()), first + std::min(most, RS_VISIT_SUBSTEPS));
  for (int slot = first; slot < last; ++slot) {
    const double motion = motion_bound(at(first), at(slot), box);
    if (slot > first && motion > kVisitShiftVoxels * voxel_mm) break;
    add_to_window(args, motions, slot, box, plan);
    plan.end = slot + 1;
    plan.shift_mm = std::max(plan.shift_mm, static_cast<float>(motion));
    include(voxel_voi(at(slot), box, bone), plan.superbricks);
  }
  constexpr int kSuperbrickVoxels = 4 * RS_BRICK_SIDE;
  if (!plan.superbricks.empty()) {
    plan.superbricks.first /= kSuperbrickVoxels;
    plan.superbricks.last /= kSuperbrickVoxels;
  }
  return plan;
}

DistanceTable brick_distances(const Profile& profile, double voxel_mm, double slack_mm) {
  constexpr double kCellVoxels = 4, kMaxCells = 1 << 14;
  const Aabb tool = profile.bounds();
  const double margin = (double{RS_SUPERBRICK_RADIUS} + kVisitShiftVoxels + kCellVoxels) * voxel_mm + slack_mm;
  const double width = tool.max.x() + margin, height = tool.max.z() - tool.min.z() + 2 * margin;
  const double cell_mm = std::max(kCellVoxels * voxel_mm, std::sqrt(width * height / kMaxCells));
  return make_distance_table(profile, Vec2(0, tool.min.z() - margin) + Vec2::Constant(0.5 * cell_mm), cell_mm,
                             static_cast<int>(std::ceil(width / cell_mm)),
                             static_cast<int>(std::ceil(height / cell_mm)));
}

CoarseGrid coarse_grid(const DistanceTable& table) {
  constexpr double kRounding_mm = 1e-3;  // may move a point into the next cell
  return {static_cast<float>(table.first.y() - 0.5 * table.pitch_mm), static_cast<float>(1 / table.pitch_mm),
          static_cast<float>(std::sqrt(0.5) * table.pitch_mm + kRounding_mm), table.count_r, table.count_z};
}

}  // namespace reamsim
