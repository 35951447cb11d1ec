// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Narrow phase of Yau et al. as Faieghi et al. rebuilt it (2020, §4.3.2): no shell; one work-item per voxel of the VOI,
 * a box of voxels, against the surface of revolution that the cutting edges sweep. A voxel is touched when its centre
 * lies in the solid or on its surface. No voxel is tested twice, so claims are not needed. */
#include "cut_law.h"

/* voi_min, voi_size: lowest voxel of the VOI and number of voxels along x, y, z; the fourth is padding. bone: dense
 * grades, 0 = air or removed; contacts: room for all voxels that the tool can contain; contact_count[substep]: 0 on
 * entry. */
__kernel void detect_implicit(const uint substep, const int4 voi_min, const uint4 voi_size,
                              __global const SubstepArgs* args, __global const uchar* bone, __global uint* contacts,
                              __global uint* contact_count, __global const OutlinePiece* pieces,
                              __global const ushort* numbers, __global const PieceList* lists,
                              __global const OutlineGrid* grid) {
  const size_t item = get_global_id(0);
  if (item >= (size_t)voi_size.x * voi_size.y * voi_size.z) return;
  __global const SubstepArgs* a = args + substep;
  const size_t row = item / voi_size.x;
  const int i = voi_min.x + (int)(item % voi_size.x);
  const int j = voi_min.y + (int)(row % voi_size.y);
  const int k = voi_min.z + (int)(row / voi_size.y);
  const uint e = i + a->dims[0] * (j + (uint)a->dims[1] * k);
  if (bone[e] == 0) return;
  const OutlineView outline = {pieces, numbers, lists, grid};
  if (rs_contains_voxel(a, &outline, i, j, k)) contacts[atomic_inc(&contact_count[substep])] = e;
}
