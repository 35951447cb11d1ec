#pragma once

#include <vector>

#include "sim/bone/voxmap/voxmap.h"
#include "sim/motion/motion.h"
#include "sim/tool/profile.h"

namespace reamsim {

/// What a run will do to the bone, as its motion alone tells: pictures measure depth against it, and so need not wait
/// for the run's end. As good as a small part of a voxel where the run takes all bone in the tool's way; more is
/// foreseen than goes where teeth that hardly spin leave some, or `erosion: wear` does.
struct ForeseenBone {
  FillBricks fill;  ///< of every voxel in the tool's way the share outside it, or nothing; else as before
  /// The pose in which the tool is deepest along its axis, from about the first contact on; without one the first.
  ToolPose deepest;
};

/// Follows `tool`, an envelope about z of the tool frame T, through its poses in the bone frame B. Of `voxmap` only the
/// lattice and the grades count. `before`: the fill that the run begins with. `whole_voxels`: a voxel that the tool
/// touches goes whole. There is one pose at least.
ForeseenBone foresee(const Voxmap& voxmap, const FillBricks& before, const Profile& tool,
                     const std::vector<ToolPose>& poses, bool whole_voxels);

}  // namespace reamsim
