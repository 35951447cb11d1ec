// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scene/voxel_cuts.h"

#include <cmath>

#include "kernels/bricks.h"

namespace reamsim {

namespace {

/// Bound of the motion between two poses, pitch of the table and margin round the tool, voxels.
constexpr double kCutStepVoxels = 0.5;
constexpr double kCutPitchVoxels = 0.5;
constexpr double kCutMarginVoxels = 9;
constexpr std::size_t kMostCutPoses = 4000;
/// Half the diagonal of a voxel, and an allowance for the table, voxels.
constexpr double kHalfDiagonal = 0.8660254;
constexpr double kTableSlack = 0.1;
/// A smaller decrease of the distance is rounding, voxels.
constexpr double kNoNearer = 1e-3;

}  // namespace

std::optional<VoxelPlane> plane_beside(const Profile& tool, const Rigid& tool_from_bone, const Vec3& center_mm,
                                       double voxel_mm) {
  const Vec3 p = tool_from_bone * center_mm;
  const double r = p.head<2>().norm();
  const Profile::Nearest near = tool.nearest({r, p.z()});
  if (near.distance_mm < -kHalfDiagonal * voxel_mm) return std::nullopt;
  const Vec3 outward = r > kOnAxisMm ? Vec3(p.x() / r, p.y() / r, 0) : Vec3::Zero();
  const Vec3 normal_t = near.normal.x() * outward + near.normal.y() * Vec3::UnitZ();
  return VoxelPlane{-(tool_from_bone.linear().transpose() * normal_t).normalized(), near.distance_mm};
}

VoxelCuts::VoxelCuts(const VoxelGrid& grid, const Profile& tool, const PoseSequence& poses)
    : grid_(grid),
      tool_(tool),
      table_(distance_table_around(tool, kCutPitchVoxels * grid.voxel_mm, kCutMarginVoxels * grid.voxel_mm)) {
  const Aabb box = tool.bounds();
  const double reach_mm = box.min.cwiseAbs().cwiseMax(box.max.cwiseAbs()).norm();
  const double step_mm = kCutStepVoxels * grid.voxel_mm;
  BoundedPath path(reach_mm, step_mm, {}, kMostCutPoses);
  path.add(poses);
  for (const PathSample& sample : sample_path(path.finish(), reach_mm, step_mm)) {
    poses_.push_back({sample.pose.bone_from_tool().inverse(), static_cast<std::int64_t>(sample.frame)});
  }
}

VoxelCuts::Brick VoxelCuts::of_brick(const Vec3i& brick) const {
  Brick out;
  const Vec3 middle =
      grid_.origin_mm + grid_.voxel_mm * BrickLattice::kSide * (brick.cast<double>() + Vec3::Constant(0.5));
  std::vector<const Pose*> near;
  for (const Pose& pose : poses_) {
    if (table_.at(rz_of(pose.tool_from_bone * middle)) < (RS_BRICK_RADIUS + 1) * grid_.voxel_mm) near.push_back(&pose);
  }
  if (near.empty()) return out;
  for (int offset = 0; offset < BrickLattice::kVoxels; ++offset) {
    out[static_cast<std::size_t>(offset)] = cut_of(grid_.center_mm(BrickLattice::voxel_at(brick, offset)), near);
  }
  return out;
}

VoxelCut VoxelCuts::cut_of(const Vec3& center_mm, const std::vector<const Pose*>& near) const {
  const Pose* nearest = nullptr;
  double least = kHalfDiagonal + kTableSlack;
  for (const Pose* pose : near) {
    const double away = table_.at(rz_of(pose->tool_from_bone * center_mm)) / grid_.voxel_mm;
    if (away >= least - kNoNearer) continue;
    least = away;
    nearest = pose;
    if (away < -kHalfDiagonal - kTableSlack) break;
  }
  if (nearest == nullptr) return {};
  return {nearest->frame, plane_beside(tool_, nearest->tool_from_bone, center_mm, grid_.voxel_mm)};
}

}  // namespace reamsim
