// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/base/error.h"
#include "sim/bone/bone.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// Builds the bone of the scenario (CT, mesh, VDB or phantom) and drills the pilot hole. The lattice is fitted to the
/// bone (fit_to_bone); only a VDB keeps its lattice, so that a run can continue an earlier one. Does not compare the
/// glenoid frame with the bone: check_glenoid_frame() does. `surface_voxels: automatic` counts as whole; resolve it
/// with with_surface_voxels(). Notes voxels, volumes and pieces in `report`. Throws InputError for invalid data.
Bone load_bone(const BoneSettings& settings, Diagnostics& report, const StageSink& stages = {});

/// Keeps the bone that was loaded last, for runs that follow with the same bone.
class BoneCache {
 public:
  /// As load_bone(), with the same report. A bone is the same where its settings are, and where its files have kept
  /// their length and time of modification. Runs on a CT may have different glenoid frames.
  Bone load(const BoneSettings& settings, Diagnostics& report);
  /// How many different bones it has loaded so far.
  [[nodiscard]] int loaded() const { return loaded_; }

 private:
  std::string key_;
  Bone bone_;
  Diagnostics report_;
  int loaded_ = 0;
};

}  // namespace reamsim
