// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/scene/swept_bone.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

#include "kernels/bricks.h"
#include "sim/base/parallel.h"
#include "sim/tool/tool_path.h"

namespace reamsim {
namespace {

/// Bound of the motion of the tool between two tested poses, voxels.
constexpr double kStepVoxels = 0.5;
/// Pitch of the distance table, voxels.
constexpr double kTablePitchVoxels = 0.5;
/// Margin around the tool's box, voxels: larger than a brick's radius and a voxel.
constexpr double kToolMarginVoxels = 9;
/// Poses of VoxelCuts, at most.
constexpr std::size_t kMostCutPoses = 4000;
/// Half the diagonal of a voxel, an allowance for the table, and a decrease of the distance that is rounding, voxels.
constexpr double kHalfDiagonal = 0.8660254, kTableSlack = 0.1, kNoNearer = 1e-3;

/// A tested pose of the tool.
struct TestedPose {
  Rigid tool_from_bone;
  Aabb box;              ///< of the tool in B, with the margin
  std::size_t pose = 0;  ///< index of the pose at the end of the step
};

/// `tool_box`: T, with the margin.
std::vector<TestedPose> sample_poses(const std::vector<ToolPose>& poses, const Aabb& tool_box, double step_mm) {
  std::vector<PathSample> path;
  for (std::size_t k = 0; k < poses.size(); ++k) path.push_back({poses[k], k});
  std::vector<TestedPose> out;
  for (const PathSample& sample : sample_path(path, tool_box.reach(), step_mm)) {
    const Rigid bone_from_tool = sample.pose.bone_from_tool();
    const Vec3 middle = bone_from_tool * tool_box.center(), half = bone_from_tool.linear().cwiseAbs() * tool_box.half();
    out.push_back({bone_from_tool.inverse(), {middle - half, middle + half}, sample.frame});
  }
  return out;
}

/// A tested pose in reach of a brick.
struct NearPose {
  const TestedPose* tested;
  double middle_mm;  ///< signed distance of the brick's middle from the tool
};

/// The predicted fill of a brick.
struct BrickLoss {
  Vec3i coord;
  FillBricks::Brick fill;
  std::size_t first_pose;  ///< first pose that removes bone, to within half a brick
};

/// Predicts the bone in the swept volume, brick by brick.
class SweptBone {
 public:
  SweptBone(const Voxmap& voxmap, const FillBricks& before, const Profile& tool, const std::vector<ToolPose>& poses,
            bool whole_voxels)
      : grid_(voxmap.grid),
        grade_(voxmap.grade),
        before_(before),
        whole_voxels_(whole_voxels),
        table_(distance_table_around(tool, kTablePitchVoxels * voxmap.grid.voxel_mm,
                                     kToolMarginVoxels * voxmap.grid.voxel_mm)),
        tested_poses_(sample_poses(poses, tool.bounds().expanded(kToolMarginVoxels * voxmap.grid.voxel_mm),
                                   kStepVoxels * voxmap.grid.voxel_mm)) {}

  /// Of the bricks near the path; nullopt where one loses nothing.
  [[nodiscard]] std::vector<std::optional<BrickLoss>> losses() const {
    std::vector<Vec3i> bricks = grade_.stored_coords();
    Aabb path_box = tested_poses_.front().box;
    for (const TestedPose& tested : tested_poses_) {
      path_box = {path_box.min.cwiseMin(tested.box.min), path_box.max.cwiseMax(tested.box.max)};
    }
    std::erase_if(bricks, [&](const Vec3i& coord) { return !path_box.contains(grid_.brick_center_mm(coord)); });
    std::vector<std::optional<BrickLoss>> found(bricks.size());
    parallel_items(bricks.size(), [&](std::size_t i) { found[i] = loss_of(bricks[i]); });
    return found;
  }

 private:
  [[nodiscard]] std::optional<BrickLoss> loss_of(const Vec3i& coord) const {
    const Vec3 middle = grid_.brick_center_mm(coord);
    const double radius_mm = RS_BRICK_RADIUS * grid_.voxel_mm;
    std::vector<NearPose> near;
    for (const TestedPose& tested : tested_poses_) {
      if (!tested.box.contains(middle)) continue;
      const double mm = table_.at(rz_of(tested.tool_from_bone * middle));
      if (mm < radius_mm) near.push_back({&tested, mm});
    }
    if (near.empty()) return std::nullopt;
    const NearPose& nearest = *std::ranges::min_element(near, {}, &NearPose::middle_mm);
    const double reached_mm = 0.5 * BrickLattice::kSide * grid_.voxel_mm;
    const auto reached = std::ranges::find_if(near, [&](const NearPose& at) { return at.middle_mm < reached_mm; });
    BrickLoss loss{coord, {}, (reached == near.end() ? nearest : *reached).tested->pose};
    return cut(near, nearest.middle_mm < -radius_mm, loss) ? std::optional(loss) : std::nullopt;
  }

  /// Sets the predicted fill. Returns whether any bone is removed.
  bool cut(const std::vector<NearPose>& near, bool whole, BrickLoss& loss) const {
    const GradeBricks::Brick& grades = *grade_.brick(loss.coord);
    const FillBricks::Brick* before = before_.brick(loss.coord);
    bool any = false;
    for (int offset = 0; offset < BrickLattice::kVoxels; ++offset) {
      const auto at = static_cast<std::size_t>(offset);
      std::uint16_t& fill = loss.fill[at];
      fill = before == nullptr ? FillBricks::kWhole : (*before)[at];
      if (grades[at] == 0 || fill == 0) continue;
      const double remaining = whole ? 0 : remaining_fraction(BrickLattice::voxel_at(loss.coord, offset), near);
      const auto predicted = static_cast<std::uint16_t>(std::lround(remaining * double{FillBricks::kWhole}));
      any |= predicted < fill;
      fill = std::min(fill, predicted);
    }
    return any;
  }

  [[nodiscard]] double remaining_fraction(const Vec3i& voxel, const std::vector<NearPose>& near) const {
    const Vec3 middle = grid_.center_mm(voxel);
    const double distance = distance_mm(middle, near) / grid_.voxel_mm;
    if (!whole_voxels_) return std::clamp(0.5 + distance, 0.0, 1.0);
    if (std::abs(distance) > 0.5 * std::numbers::sqrt3) return distance > 0 ? 1 : 0;
    for (int i = 0; i < 8; ++i) {
      const Vec3 corner(i & 1, i >> 1 & 1, i >> 2);
      if (distance_mm(middle + grid_.voxel_mm * (corner - Vec3::Constant(0.5)), near) < 0) return 0;
    }
    return 1;
  }

  /// Smallest distance over these poses, limited to a voxel.
  [[nodiscard]] double distance_mm(const Vec3& point, const std::vector<NearPose>& near) const {
    double least_mm = grid_.voxel_mm;
    for (const NearPose& at : near) least_mm = std::min(least_mm, table_.at(rz_of(at.tested->tool_from_bone * point)));
    return least_mm;
  }

  const VoxelGrid& grid_;
  const GradeBricks& grade_;
  const FillBricks& before_;
  bool whole_voxels_;
  DistanceTable table_;
  std::vector<TestedPose> tested_poses_;
};

/// The pose of greatest tool depth, which counts along the tool's axis from the pose before the first contact.
const ToolPose& deepest_from(const std::vector<ToolPose>& poses, std::size_t contact) {
  const Vec3& start_mm = poses[contact == 0 ? 0 : contact - 1].position_mm;
  const auto depth_mm = [&](const ToolPose& pose) {
    return -(pose.position_mm - start_mm).dot(pose.orientation * Vec3::UnitZ());
  };
  return *std::ranges::max_element(std::span(poses).subspan(contact), {}, depth_mm);
}

}  // namespace

PredictedBone predict_swept_bone(const Voxmap& voxmap, const FillBricks& before, const Profile& tool,
                                 const std::vector<ToolPose>& poses, bool whole_voxels) {
  PredictedBone out{.fill = before, .deepest = poses.front()};
  std::size_t contact = poses.size();
  for (const auto& loss : SweptBone(voxmap, before, tool, poses, whole_voxels).losses()) {
    if (!loss) continue;
    out.fill.put(loss->coord, loss->fill);
    contact = std::min(contact, loss->first_pose);
  }
  out.touches = contact < poses.size();
  if (out.touches) out.deepest = deepest_from(poses, contact);
  return out;
}

std::optional<VoxelPlane> plane_beside(const Profile& tool, const Rigid& tool_from_bone, const Vec3& center_mm,
                                       double voxel_mm) {
  const Vec3 p = tool_from_bone * center_mm;
  const Profile::Nearest near = tool.nearest(rz_of(p));
  if (near.distance_mm < -kHalfDiagonal * voxel_mm) return std::nullopt;
  return VoxelPlane{-(tool_from_bone.linear().transpose() * Profile::normal_at(p, near)).normalized(),
                    near.distance_mm};
}

VoxelCuts::VoxelCuts(const VoxelGrid& grid, const Profile& tool, const PoseSequence& poses)
    : grid_(grid),
      tool_(tool),
      table_(distance_table_around(tool, kTablePitchVoxels * grid.voxel_mm, kToolMarginVoxels * grid.voxel_mm)) {
  const double reach_mm = tool.bounds().reach(), step_mm = kStepVoxels * grid.voxel_mm;
  BoundedPath path(reach_mm, step_mm, {}, kMostCutPoses);
  path.add(poses);
  for (const PathSample& sample : sample_path(path.finish(), reach_mm, step_mm)) {
    poses_.push_back({sample.pose.bone_from_tool().inverse(), static_cast<std::int64_t>(sample.frame)});
  }
}

VoxelCuts::Brick VoxelCuts::of_brick(const Vec3i& brick) const {
  Brick out;
  const Vec3 middle = grid_.brick_center_mm(brick);
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
