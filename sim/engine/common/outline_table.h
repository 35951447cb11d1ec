#pragma once

#include "kernels/outline.h"
#include "sim/engine/common/surface_table.h"
#include "sim/tool/outline.h"

namespace reamsim {

/// The tool's outline for exact erosion: lines and arcs (kernels/outline.h).
using OutlineTable = SurfaceTable<OutlinePiece>;
using DeviceOutline = DeviceSurface<OutlinePiece>;

inline OutlineView view_of(const OutlineTable& table) {
  return {table.pieces.data(), table.near.numbers.data(), table.near.lists.data(), &table.near.grid};
}

/// All pieces in one list: the reference. Corners count as sharp where the sections on both sides are at least as long
/// as a voxel, because two planes represent the outline there.
OutlineTable full_outline_table(const Profile& profile, double voxel_mm);

/// With lists for voxels of `voxel_mm`. Distances and normals are bitwise those of full_outline_table(). Throws
/// InputError beyond 65535 pieces.
OutlineTable make_outline_table(const Profile& profile, double voxel_mm);

}  // namespace reamsim
