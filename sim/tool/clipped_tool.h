// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/tool/tool.h"

namespace reamsim {

/// Tolerated error of the grid's volume relative to the mesh's; larger ones cause a warning.
inline constexpr double kGridVolumeTolerance = 5e-3;
/// Thinner walls cause a warning, voxels: one plane per voxel cannot represent both faces.
inline constexpr double kThinWallVoxels = 2;

/// Whether cutting edges are resolved: `spin: resolved`, and the mesh is no surface of revolution.
bool has_resolved_teeth(const Tool& tool, const ToolSettings& settings);

/// Prepares a tool for `erosion: exact` at voxels of `voxel_mm`: warns of thin walls, and makes the distance grid of
/// resolved cutting edges. Throws InputError where it would need more than `memory_bytes`.
void prepare_clipping(Tool& tool, const ToolSettings& settings, double voxel_mm, double memory_bytes,
                      Diagnostics& report);

}  // namespace reamsim
