// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "kernels/window.h"
#include "sim/base/geometry.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/scenario/scenario.h"
#include "sim/tool/motion.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// The motion of the tool in one substep. Frame B.
struct Substep {
  ToolPose pose;                             ///< at the end
  Vec3 origin_velocity_mm_s = Vec3::Zero();  ///< of the tool's origin
  Vec3 angular_velocity = Vec3::Zero();      ///< spin and tilt, rad/s
  double duration_s = 0;
  std::int64_t frame = 0;
};

/// The number of substeps from `a` to `b`, so that no point of the tool moves further than `max_step_mm`. The spin
/// counts only where cutting edges are resolved.
int count_substeps(const ToolPose& a, const ToolPose& b, const Tool& tool, bool spin_resolved, double max_step_mm);

/// The substep between two fractions (0…1) of the motion from `a` to `b`.
Substep make_substep(const ToolPose& a, const ToolPose& b, double begin_fraction, double end_fraction, double frame_s,
                     std::int64_t frame);

/// The pose of the shell in B: with the spin where cutting edges are resolved, without it for the envelope.
Rigid bone_from_shell(const ToolPose& pose, bool spin_resolved);

/// The fill that a tool at rest could remove by errors of single precision; smaller losses are put off.
rs_i32 least_loss(double voxel_mm);

/// From voxel coordinates, 0 at the centre of voxel (0,0,0), to T, mm. `args` has it for bricks.
Eigen::Affine3d tool_from_voxel(const SubstepArgs& args);

/// The voxel in which the point of a cell of the shell lies; it may lie outside the lattice.
inline Vec3i voxel_of_cell(const SubstepArgs& args, const Vec3i& cell) {
  const auto at = [&](int axis) { return rs_voxel_coordinate(&args, axis, cell.x(), cell.y(), cell.z()); };
  return {at(0), at(1), at(2)};
}

/// The arguments of a substep. `voi` is in the shell's frame, mm.
SubstepArgs make_args(const Substep& substep, const Aabb& voi, const PointShell& shell, const VoxelGrid& grid,
                      const CuttingSettings& cutting, bool spin_resolved);

/// Exact overlap test of two boxes by separating axes (Gottschalk's 15 axes), in the frame of one box (paper §3.4).
/// `a` is axis-aligned in frame A, `b` in frame B. Touching boxes overlap.
bool boxes_overlap(const Aabb& a, const Aabb& b, const Rigid& a_from_b);

/// The volume of interest: the intersection of the tool's box with the axis-aligned bounding box, in the tool's frame,
/// of the bone's box (paper §3.4, Fig. 5). Conservative. nullopt when it is empty.
std::optional<Aabb> volume_of_interest(const Aabb& tool, const Aabb& bone, const Rigid& tool_from_bone);

/// OBB against OBB, then the VOI; nullopt where nothing can touch.
std::optional<Aabb> broad_phase(const Aabb& tool, const Aabb& bone, const Rigid& tool_from_bone);

/// The volume of interest in voxmap coordinates (paper §4.3.2): the voxels of `bone` whose centres can lie in
/// `tool_box` (T, mm) in the substep's pose. Conservative.
VoxelBox voxel_voi(const SubstepArgs& args, const Aabb& tool_box, const VoxelBox& bone);

/// Windows of frames whose motion is smooth, for `erosion: exact` (kernels/window.h). They depend on the motion alone:
/// a window is one of frames 64k … 64k + 63, or of their halves, quarters or eighths, and the same in every batch.
class MotionWindows {
 public:
  /// The substep of a frame, or nullopt where it has none or several.
  using ArgsOfFrame = std::function<std::optional<SubstepArgs>(std::int64_t frame)>;

  /// `last`: frame of the motion; `tool_box`: T, mm.
  MotionWindows(ArgsOfFrame args_of, std::int64_t last, const Aabb& tool_box);

  /// The window of a frame (≥ 1); nullptr where the motion is not smooth, or too fast.
  std::shared_ptr<const MotionWindow> of(std::int64_t frame);

 private:
  void plan(std::int64_t block);
  void split(std::int64_t first, std::int64_t end);

  ArgsOfFrame args_of_;
  std::int64_t last_;
  Aabb tool_box_;
  std::int64_t block_ = -1;                                   ///< the planned one
  std::vector<std::optional<SubstepArgs>> args_;              ///< of its frames
  std::vector<std::shared_ptr<const MotionWindow>> windows_;  ///< of its frames
};

}  // namespace reamsim
