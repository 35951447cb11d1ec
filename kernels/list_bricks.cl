// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Broad phase of exact erosion: lists the bricks with bone that the tool's surface can intersect in a visit. A
 * work-item takes a superbrick of 4x4x4 bricks, culled as a whole without bone or far from the surface. */
#include "reach.h"

/* `first_super`, `supers`: box of superbricks that the tool's box overlaps. `shift_mm`: bound of the motion of any
 * point near the tool during the visit, from substep `substep`. */
__kernel void list_bricks(const uint substep, const int4 first_super, const int4 supers, const float shift_mm,
                          __global const SubstepArgs* args, __global const CoarseGrid* coarse,
                          __global const float* distances, __global const uint* occupancy,
                          __global const int* slot_of_brick, const int4 bricks, __global uint* listed,
                          __global VisitCounts* counts) {
  const uint item = get_global_id(0);
  if (item >= (uint)supers.x * (uint)supers.y * (uint)supers.z) return;
  const uint row = item / (uint)supers.x;
  const int sx = first_super.x + (int)(item % (uint)supers.x), sy = first_super.y + (int)(row % (uint)supers.y),
            sz = first_super.z + (int)(row / (uint)supers.y);
  const uint words = 2 * (sx + ((bricks.x + 3) >> 2) * (sy + ((bricks.y + 3) >> 2) * sz));
  const ulong occupied = occupancy[words] | (ulong)occupancy[words + 1] << 32;
  if (occupied == 0) return;
  __global const SubstepArgs* a = args + substep;
  float p[3];
  rs_box_middle(a, 32 * sx, 32 * sy, 32 * sz, 32, p);
  if (!rs_near_surface(coarse, distances, p, RS_SUPERBRICK_RADIUS * a->voxel_mm + shift_mm)) return;
  for (ulong rest = occupied; rest != 0; rest &= rest - 1) {
    const int bit = (int)popcount((rest & -rest) - 1);
    const int x = 4 * sx + (bit & 3), y = 4 * sy + (bit >> 2 & 3), z = 4 * sz + (bit >> 4);
    rs_box_middle(a, 8 * x, 8 * y, 8 * z, 8, p);
    if (!rs_near_surface(coarse, distances, p, RS_BRICK_RADIUS * a->voxel_mm + shift_mm)) continue;
    listed[atomic_inc(&counts->listed)] = (uint)slot_of_brick[x + (ulong)bricks.x * (y + (ulong)bricks.y * z)];
  }
}
