// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "sim/bone/voxel_surface.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/tool/distance_grid.h"
#include "sim/tool/motion.h"
#include "sim/tool/profile.h"

namespace reamsim {

/// The bone after a run, predicted from the swept volume of the tool, so that pictures can show depth before the run
/// ends. Accurate to a small fraction of a voxel where the run removes all bone in the swept volume; with slowly
/// rotating cutting edges or `erosion: wear` it predicts too much removal.
struct PredictedBone {
  FillBricks fill;  ///< voxels in the swept volume: the fraction outside it, or 0; others: as before
  /// The pose in which the tool is deepest along its axis, from about the first contact on; without contact the first.
  ToolPose deepest;
  bool touches = false;  ///< the tool removes bone
};

/// `tool`: an envelope about z of the tool frame T; `poses` in the bone frame B, at least one; `before`: the fill at
/// the start of the run; `whole_voxels`: a touched voxel is removed whole.
PredictedBone predict_swept_bone(const Voxmap& voxmap, const FillBricks& before, const Profile& tool,
                                 const std::vector<ToolPose>& poses, bool whole_voxels);

/// What the envelope of a tool leaves of a voxel.
struct VoxelCut {
  static constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();
  std::int64_t frame = kNever;      ///< from which on no more is removed; kNever: the tool does not come near
  std::optional<VoxelPlane> plane;  ///< bone is left on its inner side; nullopt: none is left
};

/// The plane of an envelope's surface next to a voxel, as VoxelPlane; nullopt where the voxel lies inside.
std::optional<VoxelPlane> plane_beside(const Profile& tool, const Rigid& tool_from_bone, const Vec3& center_mm,
                                       double voxel_mm);

/// Cuts of voxels by the envelope of a tool along a motion, for predictions. The voxel's solid at the end of the motion
/// is that outside the tool at its nearest pose.
class VoxelCuts {
 public:
  using Brick = std::array<VoxelCut, BrickLattice::kVoxels>;

  VoxelCuts(const VoxelGrid& grid, const Profile& tool, const PoseSequence& poses);

  [[nodiscard]] Brick of_brick(const Vec3i& brick) const;

 private:
  struct Pose {
    Rigid tool_from_bone;
    std::int64_t frame;
  };

  [[nodiscard]] VoxelCut cut_of(const Vec3& center_mm, const std::vector<const Pose*>& near) const;

  const VoxelGrid& grid_;
  const Profile& tool_;
  DistanceTable table_;
  std::vector<Pose> poses_;
};

}  // namespace reamsim
