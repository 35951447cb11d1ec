#pragma once

#include "sim/tool/tool.h"

namespace reamsim {

/// A grid whose volume is off by more than this share of the mesh's is warned of.
inline constexpr double kGridVolumeTolerance = 5e-3;
/// A wall thinner than this is warned of, voxels: a plane per voxel cannot stand for both of its faces.
inline constexpr double kThinWallVoxels = 2;

/// Whether the tool's teeth turn through the bone, rather than the surface that they sweep: `spin: resolved`, of a mesh
/// that is no surface of revolution.
bool has_turning_teeth(const Tool& tool, const ToolSettings& settings);

/// Readies a tool for `erosion: exact` at voxels of `voxel_mm`: warns of walls too thin for them, and makes the
/// distance grid where teeth turn. Throws InputError where that would take more than `memory_bytes`.
void ready_for_clipping(Tool& tool, const ToolSettings& settings, double voxel_mm, double memory_bytes, Report& report);

}  // namespace reamsim
