#pragma once

#include "kernels/outline.h"
#include "sim/engine/common/surface_table.h"
#include "sim/tool/outline.h"

namespace reamsim {

/// The tool's outline as exact erosion reads it: lines and arcs (kernels/outline.h).
using OutlineTable = SurfaceTable<OutlinePiece>;
using DeviceOutline = DeviceSurface<OutlinePiece>;

inline OutlineView view_of(const OutlineTable& table) {
  return {table.pieces.data(), table.near.numbers.data(), table.near.lists.data(), &table.near.grid};
}

/// Every piece in one list: the reference. Corners count as sharp where the lines on both sides are as long as a voxel
/// of `voxel_mm`, because two planes stand for the outline there.
OutlineTable full_outline_table(const Profile& profile, double voxel_mm);

/// Lists for voxels of `voxel_mm`. Gives the same distances and normals as full_outline_table(), bit for bit. Throws
/// InputError beyond 65535 pieces.
OutlineTable make_outline_table(const Profile& profile, double voxel_mm);

}  // namespace reamsim
