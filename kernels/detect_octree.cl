// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Narrow phase of Zheng et al. as Faieghi et al. rebuilt it (2020, §4.3.1): one work-item per shell point, an
 * octree-like descent of the 3D grid through look-up tables, voxels of a float HU and a collision flag, points of three
 * floats, and a parallel reduction over the forces of all points, including those outside the bone. There is no VOI.
 *
 * The descent: the lattice lies in the corner of a cube of 2^levels voxels. A cell of level l is a cube of 2^(levels -
 * l) voxels; children[8·l + o] is the corner of its octant o (x in bit 0, y in bit 1, z in bit 2) relative to the
 * cell's corner: x, y, z in voxels, w as a step in the dense array. A point starts at the root; on each level it is
 * compared with the cell's three middle planes and moves to the child that contains it. After `levels` steps the corner
 * is the point's voxel, and the steps add up to the voxel's index.
 *
 * Floats represent the cell numbers exactly, so that positions are the same integers as in all engines. */
#include "cut_law.h"

/* Index of voxel (i, j, k), found from the root downwards. The voxel lies in the lattice. */
uint descend(__global const uint4* children, const int levels, const uint i, const uint j, const uint k) {
  uint4 corner = (uint4)(0, 0, 0, 0);
  for (int level = 0; level < levels; ++level) {
    const uint half_side = 1u << (levels - 1 - level);
    const uint octant = (i >= corner.x + half_side ? 1u : 0u) | (j >= corner.y + half_side ? 2u : 0u) |
                        (k >= corner.z + half_side ? 4u : 0u);
    corner += children[8 * level + octant];
  }
  return corner.w;
}

#ifdef REAMSIM_GROUP_SIZE
/* Reduces the forces of a group's points pairwise, and adds them to the substep's sums. All work-items call it. */
void reduce_forces(__local rs_i64* partial, __global SubstepSums* total, const LaneSums* own) {
  const uint item = get_local_id(0);
  for (int c = 0; c < 3; ++c) {
    partial[c * REAMSIM_GROUP_SIZE + item] = own->force[c];
    partial[(3 + c) * REAMSIM_GROUP_SIZE + item] = own->torque[c];
  }
  for (uint live = REAMSIM_GROUP_SIZE; live > 1;) {
    const uint kept = (live + 1) / 2;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item + kept < live) {
      for (int c = 0; c < 6; ++c)
        partial[c * REAMSIM_GROUP_SIZE + item] += partial[c * REAMSIM_GROUP_SIZE + item + kept];
    }
    live = kept;
  }
  if (item != 0) return;
  for (int c = 0; c < 3; ++c) {
    atom_add(&total->force[c], partial[c * REAMSIM_GROUP_SIZE]);
    atom_add(&total->torque[c], partial[(3 + c) * REAMSIM_GROUP_SIZE]);
  }
}
#endif

/* points[3 · point_count]: cell numbers; hu: dense, hu_of_air = air or removed; flags: a byte per voxel, four per word
 * (atomics need 32 bits), all 0 on entry; contacts, contact_count, sums: as in detect_direct. Built with
 * REAMSIM_GROUP_SIZE for law per_point. */
__kernel void detect_octree(const uint substep, __global const SubstepArgs* args, __global const float* points,
                            const uint point_count, __global const float* hu, const float hu_of_air,
                            __global uint* flags, __global uint* contacts, __global uint* contact_count,
                            __global SubstepSums* sums, __global const OutlinePiece* pieces,
                            __global const ushort* numbers, __global const PieceList* lists,
                            __global const OutlineGrid* grid, __global const uint4* children, const int levels) {
  const uint point = get_global_id(0);
  __global const SubstepArgs* a = args + substep;
  int touches = 0, x = 0, y = 0, z = 0;
  if (point < point_count) {
    const float3 cell = vload3(point, points);
    x = (int)cell.x;
    y = (int)cell.y;
    z = (int)cell.z;
    const int i = rs_voxel_coordinate(a, 0, x, y, z);
    const int j = rs_voxel_coordinate(a, 1, x, y, z);
    const int k = rs_voxel_coordinate(a, 2, x, y, z);
    if (i >= 0 && j >= 0 && k >= 0 && i < a->dims[0] && j < a->dims[1] && k < a->dims[2]) {
      const uint e = descend(children, levels, i, j, k);
      touches = hu[e] > hu_of_air;
      const uint flag = 1u << (8 * (e & 3u));
      if (touches && (atomic_or(&flags[e >> 2], flag) & flag) == 0) contacts[atomic_inc(&contact_count[substep])] = e;
    }
  }
#ifdef REAMSIM_GROUP_SIZE
  __local rs_i64 partial[6 * REAMSIM_GROUP_SIZE];
  const OutlineView outline = {pieces, numbers, lists, grid};
  LaneSums own = {{0, 0, 0}, {0, 0, 0}, 0};
  rs_point_force(a, &outline, x, y, z, &own);
  for (int c = 0; c < 3; ++c) {
    own.force[c] *= touches;
    own.torque[c] *= touches;
  }
  reduce_forces(partial, &sums[substep], &own);
#endif
}
