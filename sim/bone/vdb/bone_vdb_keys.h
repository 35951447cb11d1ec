#pragma once

namespace reamsim::vdb_keys {

// Names of grids and metadata in a bone's VDB, shared by writer and reader.
inline constexpr const char* kDensity = "density";
inline constexpr const char* kFill = "fill";
inline constexpr const char* kSurface = "surface";
inline constexpr const char* kRemovedFrame = "removed_frame";

inline constexpr const char* kUnit = "unit";
inline constexpr const char* kFrame = "frame";
inline constexpr const char* kCreator = "creator";
inline constexpr const char* kLengthUnit = "length_unit";
inline constexpr const char* kDims = "lattice_dims";
inline constexpr const char* kOrigin = "lattice_origin_mm";
inline constexpr const char* kVoxel = "voxel_mm";
inline constexpr const char* kAshSlope = "ash_slope_g_cm3_per_hu";
inline constexpr const char* kAshOffset = "ash_offset_g_cm3";
inline constexpr const char* kAshFraction = "ash_fraction";
inline constexpr const char* kErosion = "erosion";
inline constexpr const char* kSide = "bone_side";
inline constexpr const char* kGlenoid = "bone_from_glenoid";
inline constexpr const char* kLandmarks = "scapula_landmarks_mm";

}  // namespace reamsim::vdb_keys
