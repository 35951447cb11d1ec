// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "sim/bone/voxmap/voxmap.h"
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

}  // namespace reamsim
