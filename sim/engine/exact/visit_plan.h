#pragma once

#include <span>
#include <vector>

#include "kernels/bricks.h"
#include "sim/base/geometry.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/engine/common/nearest_lists.h"

namespace reamsim {

/// Substeps that every brick goes through in one visit (`erosion: exact`), cut into windows of little motion.
struct VisitPlan {
  int first = 0;                       ///< slot
  int end = 0;                         ///< past the last
  std::vector<SubstepWindow> windows;  ///< in order, without gaps
  float shift_mm = 0;                  ///< no point near the tool is further from where it is in `first`, T
  VoxelBox superbricks;                ///< of 4×4×4 bricks, that the tool's box meets in any of the substeps
};

/// Longest motion of a visit, voxels: kernels/list_bricks.cl looks that far round the tool.
inline constexpr double kVisitShiftVoxels = 16;

/// Plans a visit of at most `most` substeps that begins with the one in slot `first`. `tool_box`: T, mm; `bone`: voxels
/// with bone.
VisitPlan plan_visit(std::span<const SubstepArgs> args, int first, int most, const Aabb& tool_box,
                     const VoxelBox& bone);

}  // namespace reamsim
