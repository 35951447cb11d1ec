// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/bone/voxmap/voxmap.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// Text metadata: (name, value).
using Metadata = std::vector<std::pair<std::string, std::string>>;

/// Writes FloatGrids `density`, `fill`, `surface`, `removed_frame` (docs/results.md) with an isotropic transform in mm,
/// index (0,0,0) at the centre of voxel (0,0,0). Throws RunError when the file cannot be written.
void write_bone_vdb(const std::string& path, const BoneView& bone, const RemovedFrames& removed,
                    const Metadata& metadata);

/// The anatomy in the metadata of a VDB, in B.
struct StoredAnatomy {
  std::optional<GlenoidFrame> glenoid;
  std::optional<LandmarkSettings> landmarks;
  BodySide side = BodySide::unknown;
};

/// The same as text metadata, for write_bone_vdb(): `bone_side`, `bone_from_glenoid`, `scapula_landmarks_mm`.
Metadata metadata_of(const StoredAnatomy& anatomy);

struct StoredBone {
  FilledVoxmap voxmap;
  StoredAnatomy anatomy;
  std::string erosion;       ///< of the run that wrote it; "" if unknown
  double densest_g_cm3 = 0;  ///< of the voxels, before they are limited to DensityMapping::kMaxDensity_g_cm3
};

/// Reads `density`, `fill` and the metadata. Throws as read_bone_vdb(), and InputError for invalid metadata.
StoredBone read_stored_bone(const std::string& path);

/// Reads `density` and `fill`. Throws InputError: no such file, truncated, no such grid, not isotropic, voxels
/// out of the range of bone.voxel_mm, absurdly large.
FilledVoxmap read_bone_vdb(const std::string& path);

}  // namespace reamsim
