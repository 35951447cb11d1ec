#pragma once

#include "kernels/shared.h"
#include "sim/bone/voxmap/voxel_grid.h"
#include "sim/motion/motion.h"
#include "sim/scenario/scenario.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// What the tool does in one substep: where it ends, and how fast it got there. Frame B.
struct Substep {
  ToolPose pose;                             ///< at the end
  Vec3 origin_velocity_mm_s = Vec3::Zero();  ///< of the tool's origin
  Vec3 angular_velocity = Vec3::Zero();      ///< spin and tilt, rad/s
  double duration_s = 0;
  std::int64_t frame = 0;
};

/// Substeps that a frame from `a` to `b` is cut into, so that no point of the tool moves further than `max_step_mm`.
/// The spin counts only where teeth are resolved.
int count_substeps(const ToolPose& a, const ToolPose& b, const Tool& tool, bool spin_resolved, double max_step_mm);

/// The substep that ends `share_end` of the way from `a` to `b` and begins at `share_begin`.
Substep make_substep(const ToolPose& a, const ToolPose& b, double share_begin, double share_end, double frame_s,
                     std::int64_t frame);

/// The pose of the shell in B: with the spin where teeth are resolved, without it for the envelope.
Rigid bone_from_shell(const ToolPose& pose, bool spin_resolved);

/// The arguments that the device and the serial engine read. `voi` is in the shell's frame, mm.
SubstepArgs make_args(const Substep& substep, const Aabb& voi, const PointShell& shell, const VoxelGrid& grid,
                      const CuttingSettings& cutting, bool spin_resolved);

}  // namespace reamsim
