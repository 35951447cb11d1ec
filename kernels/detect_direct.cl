// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Narrow phase of the paper (§3.5): one work-item per shell point. Decode, cull against the VOI, transform, look up. A
 * touched voxel is claimed once, by a bit, and listed. Results do not depend on the order of the list. */
#include "cut_law.h"

#ifdef RS_WIDE_CODES /* shells of more than 1024 cells per axis: 8 bytes per point */
typedef rs_u64 ShellCode;
#define CELL_COORDINATE rs_compact_wide_bits
#else /* the paper's layout: 4 bytes per point */
typedef rs_u32 ShellCode;
#define CELL_COORDINATE rs_compact_bits
#endif

/* codes[point_count]; bone: dense grades, 0 = air or removed; claims: a bit per voxel, all 0 on entry; contacts: room
 * for min(points, voxels); contact_count[substep]: 0 on entry; sums[substep]. */
__kernel void detect_direct(const uint substep, __global const SubstepArgs* args, __global const ShellCode* codes,
                            const uint point_count, __global const uchar* bone, __global uint* claims,
                            __global uint* contacts, __global uint* contact_count, __global SubstepSums* sums,
                            __global const OutlinePiece* pieces, __global const ushort* numbers,
                            __global const PieceList* lists, __global const OutlineGrid* grid) {
  const uint point = get_global_id(0);
  if (point >= point_count) return;
  __global const SubstepArgs* a = args + substep;

  const ShellCode code = codes[point];
  const int x = CELL_COORDINATE(code), y = CELL_COORDINATE(code >> 1), z = CELL_COORDINATE(code >> 2);
  if (!rs_in_voi(a, x, y, z)) return;

  const int i = rs_voxel_coordinate(a, 0, x, y, z);
  const int j = rs_voxel_coordinate(a, 1, x, y, z);
  const int k = rs_voxel_coordinate(a, 2, x, y, z);
  if (i < 0 || j < 0 || k < 0 || i >= a->dims[0] || j >= a->dims[1] || k >= a->dims[2]) return;
  const uint e = i + a->dims[0] * (j + (uint)a->dims[1] * k);
  if (bone[e] == 0) return;

  if (a->law == RS_LAW_PER_POINT) {
    LaneSums point_sums = {{0, 0, 0}, {0, 0, 0}, 0};
    const OutlineView outline = {pieces, numbers, lists, grid};
    rs_point_force(a, &outline, x, y, z, &point_sums);
    rs_add_point_sums(&sums[substep], &point_sums);
  }
  const uint bit = 1u << (e & 31u);
  if ((atomic_or(&claims[e >> 5], bit) & bit) == 0) contacts[atomic_inc(&contact_count[substep])] = e;
}
