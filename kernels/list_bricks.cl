/* Broad phase of exact erosion: lists the bricks with bone that the tool's surface can intersect in a visit. A
 * work-item takes a superbrick of 4x4x4 bricks, which is culled as a whole where it has no bone or lies far from the
 * surface. */
#include "cut_law.h"

/* Whether the surface may come within `reach` mm of the point `p` (T). Conservative. */
bool near_surface(const CoarseGrid g, __global const float* distances, const float* p, const float reach) {
  const float r = (sqrt(p[0] * p[0] + p[1] * p[1])) * g.per_mm, z = (p[2] - g.z0) * g.per_mm;
  /* Points off the grid are far. */
  if (!(r < (float)g.count_r && z >= 0.0f && z < (float)g.count_z)) return false;
  return distances[(int)r + g.count_r * (int)z] <= reach + g.slack_mm;
}

/* The middle of the box of `side` voxels whose lowest voxel is (x, y, z), T. */
void box_middle(__global const SubstepArgs* a, const int x, const int y, const int z, const int side, float* p) {
  const double half_side = 0.5 * (side - 1);
  for (int i = 0; i < 3; ++i) {
    __global const double* row = a->tool_from_voxel + 3 * i;
    p[i] = (float)(a->tool_origin[i] + row[0] * (x + half_side) + row[1] * (y + half_side) + row[2] * (z + half_side));
  }
}

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
  const CoarseGrid g = *coarse;
  float p[3];
  box_middle(a, 32 * sx, 32 * sy, 32 * sz, 32, p);
  if (!near_surface(g, distances, p, RS_SUPERBRICK_RADIUS * a->voxel_mm + shift_mm)) return;
  for (ulong rest = occupied; rest != 0; rest &= rest - 1) {
    const int bit = (int)popcount((rest & -rest) - 1);
    const int x = 4 * sx + (bit & 3), y = 4 * sy + (bit >> 2 & 3), z = 4 * sz + (bit >> 4);
    box_middle(a, 8 * x, 8 * y, 8 * z, 8, p);
    if (!near_surface(g, distances, p, RS_BRICK_RADIUS * a->voxel_mm + shift_mm)) continue;
    listed[atomic_inc(&counts->listed)] = (uint)slot_of_brick[x + (ulong)bricks.x * (y + (ulong)bricks.y * z)];
  }
}
