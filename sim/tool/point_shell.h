#pragma once

#include <cstdint>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// The points that sample the tool's surface (paper §3.3): centres of the cells of an M³ grid that the surface goes
/// through, Morton-coded with x in bit 0 (morton.h). Codes ascend and are unique.
/// Point of a code (x,y,z): origin_mm + cell_mm·(x + ½, y + ½, z + ½), tool frame T.
struct PointShell {
  int resolution = 0;  ///< M, cells per axis, 1…kMaxShellResolution
  double cell_mm = 0;
  Vec3 origin_mm = Vec3::Zero();
  std::vector<std::uint64_t> codes;
};

/// Marks every cell of a `resolution`³ cubic grid round the mesh that a triangle touches (exact triangle–box test).
/// The cell is the box's longest side over M − 1: that side runs from cell centre to cell centre, x and y are centred
/// in the grid, and the mesh's lowest z passes through the centres of the lowest cells. Throws InputError when
/// resolution is outside 1…kMaxShellResolution or the mesh has no extent.
PointShell voxelise_surface(const TriangleMesh& mesh, int resolution);

}  // namespace reamsim
