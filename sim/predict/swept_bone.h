#pragma once

#include <vector>

#include "sim/bone/voxmap/voxmap.h"
#include "sim/motion/motion.h"
#include "sim/tool/profile.h"

namespace reamsim {

/// What a run will remove, predicted from the swept volume of the tool alone: pictures measure depth against it, and so
/// need not wait for the run's end. Accurate to a small part of a voxel where the run removes all bone in the swept
/// volume; too much where teeth that hardly spin leave some, or `erosion: wear` does.
struct PredictedBone {
  FillBricks fill;  ///< of every voxel in the swept volume the fraction outside it, or nothing; else as before
  /// The pose in which the tool is deepest along its axis, from about the first contact on; without one the first.
  ToolPose deepest;
};

/// Follows `tool`, an envelope about z of the tool frame T, through its poses in the bone frame B. `before`:
/// the fill that the run begins with. `whole_voxels`: a voxel that the tool touches is removed whole. There is at least
/// one pose.
PredictedBone predict_swept_bone(const Voxmap& voxmap, const FillBricks& before, const Profile& tool,
                                 const std::vector<ToolPose>& poses, bool whole_voxels);

}  // namespace reamsim
