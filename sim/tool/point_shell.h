// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <vector>

#include "kernels/shared.h"
#include "sim/base/geometry.h"
#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

// Morton codes of shell points on the host: 21 bits per axis interleaved into 63, x in bit 0, y in bit 1, z in bit 2.
// Up to kNarrowResolution they are the paper's codes (§3.3) of 10 bits per axis and fit into 32 bits.

/// Most cells per axis whose codes fit into 32 bits; the device then stores 4 bytes per point, else 8.
inline constexpr int kNarrowResolution = 1024;

/// Most cells per axis of a shell: the error of fixed-point positions is then below 2⁻¹¹ voxel (kernels/shared.h), and
/// a tool's shell has some 10⁸ points. Codes have room for 2²¹.
inline constexpr int kMaxShellResolution = 4096;

/// Spreads the low 21 bits of `value` so that two zero bits follow each.
constexpr std::uint64_t spread_bits(std::uint64_t value) {
  value &= 0x1fffffu;
  value = (value ^ (value << 32)) & 0x001f00000000ffffu;
  value = (value ^ (value << 16)) & 0x001f0000ff0000ffu;
  value = (value ^ (value << 8)) & 0x100f00f00f00f00fu;
  value = (value ^ (value << 4)) & 0x10c30c30c30c30c3u;
  value = (value ^ (value << 2)) & 0x1249249249249249u;
  return value;
}

/// Code of cell (x, y, z); each coordinate in 0…2²¹ − 1.
constexpr std::uint64_t morton_encode(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  return spread_bits(x) | (spread_bits(y) << 1) | (spread_bits(z) << 2);
}

/// Cell (x, y, z) of a code.
inline Vec3i morton_decode(std::uint64_t code) {
  return {rs_compact_wide_bits(code), rs_compact_wide_bits(code >> 1), rs_compact_wide_bits(code >> 2)};
}

/// The points that sample the tool's surface (paper §3.3): centres of the cells of an M³ grid that the surface
/// intersects, as Morton codes with x in bit 0, ascending and unique. Point of code (x,y,z): origin_mm +
/// cell_mm·(x + ½, y + ½, z + ½), tool frame T.
struct PointShell {
  int resolution = 0;  ///< M, cells per axis, 1…kMaxShellResolution
  double cell_mm = 0;
  Vec3 origin_mm = Vec3::Zero();
  std::vector<std::uint64_t> codes;
};

/// The cells of a cubic grid of `resolution`³ around the mesh that triangles touch. The longest side of the box spans M
/// − 1 cells, from centre to centre; x and y are centred; the lowest point lies at the centres of the lowest cells.
/// Throws InputError when resolution is outside 1…kMaxShellResolution or the mesh has no extent.
PointShell voxelize_surface(const TriangleMesh& mesh, int resolution);
/// The grid of voxelize_surface() for a surface with this box, without points. Throws likewise.
PointShell shell_grid(const Aabb& box, int resolution);

/// Fraction (0…1) of the swept voxels that a point shell misses when it moves in half-voxel steps, for a shell spacing
/// of s voxels. This is the worst case, a flat face along its normal, whose points at all steps form a lattice of s × s
/// × ½ voxels: the fraction of unit cubes without a lattice point, averaged over orientations.
double expected_leak(double spacing_voxels);
/// Up to the first of these spacings (voxels) expected_leak() is an upper bound: no miss was found in 4·10⁶ cubes.
/// Beyond the second it is a lower bound, the value there.
inline constexpr double kHardlyLeakingSpacing = 0.7, kLargestMeasuredSpacing = 3;

}  // namespace reamsim
