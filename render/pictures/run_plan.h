#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/bone/voxmap/voxmap.h"
#include "sim/mesh/triangle_mesh.h"
#include "sim/motion/motion.h"

namespace reamsim {

/// All that photographs of a run need beside its snapshots, and all of it known before the simulation begins.
struct RunPlan {
  std::string dir;                     ///< where the snapshots are, or will be
  std::shared_ptr<const Voxmap> bone;  ///< its lattice and grades, which no run changes; its fill means nothing here
  FillBricks fill_before;              ///< that the run begins with
  bool whole_voxels = false;           ///< the run takes voxels whole, not in parts
  std::optional<GlenoidFrame> glenoid;
  BodySide side = BodySide::unknown;      ///< "left", "right", or "" where nobody knows
  std::vector<std::int64_t> frames;       ///< that have a snapshot, ascending
  std::vector<std::int64_t> pose_frames;  ///< the frames of `poses`, ascending; with all of `frames` from the first on
  std::vector<ToolPose> poses;
  TriangleMesh tool;  ///< T, mm

  /// The pose in a frame, or the first one where the frame lies before it.
  [[nodiscard]] const ToolPose& pose_at(std::int64_t frame) const;
};

/// A fill with every voxel that an earlier run took away whole again: depth is measured from before it.
FillBricks with_gone_voxels_whole(const FillBricks& fill);

}  // namespace reamsim
