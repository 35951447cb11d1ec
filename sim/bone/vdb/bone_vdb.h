// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

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

/// Reads `density`, `fill` and the metadata. Throws InputError: no such file, truncated, no such grid, not isotropic,
/// voxels out of the range of bone.voxel_mm, absurdly large, invalid metadata.
StoredBone read_stored_bone(const std::string& path);

/// Names of grids and metadata that are written and read.
namespace vdb_keys {

inline constexpr const char* kDensity = "density";
inline constexpr const char* kFill = "fill";
inline constexpr const char* kFrame = "frame";
inline constexpr const char* kDims = "lattice_dims";
inline constexpr const char* kOrigin = "lattice_origin_mm";
inline constexpr const char* kVoxel = "voxel_mm";
inline constexpr const char* kAshSlope = "ash_slope_g_cm3_per_hu";
inline constexpr const char* kAshOffset = "ash_offset_g_cm3";
inline constexpr const char* kAshFraction = "ash_fraction";
inline constexpr const char* kLayers = "cortical_layer";
inline constexpr const char* kErosion = "erosion";
inline constexpr const char* kSide = "bone_side";
inline constexpr const char* kGlenoid = "bone_from_glenoid";
inline constexpr const char* kLandmarks = "scapula_landmarks_mm";

}  // namespace vdb_keys

}  // namespace reamsim
