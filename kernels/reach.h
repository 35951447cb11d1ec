// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Exact erosion: what the tool's surface can reach. Bricks are culled by a coarse table of distances, voxels by their
 * width along the surface's normal. Conservative: an extra voxel costs time and changes nothing. */
#ifndef REAMSIM_KERNELS_REACH_H
#define REAMSIM_KERNELS_REACH_H

#include "clip.h"

/* Bound of the error of positions in single precision, mm. */
#define RS_POSITION_SLACK 1e-4f

/* Whether the surface may come within `reach` mm of the point `p` (T). */
RS_INLINE int rs_near_surface(RS_GLOBAL const CoarseGrid* g, RS_GLOBAL const float* distances, const float* p,
                              float reach) {
  const float r = RS_SQRT(p[0] * p[0] + p[1] * p[1]) * g->per_mm, z = (p[2] - g->z0) * g->per_mm;
  /* Points off the grid are far. */
  if (!(r < (float)g->count_r && z >= 0.0f && z < (float)g->count_z)) return 0;
  return distances[(rs_i32)r + g->count_r * (rs_i32)z] <= reach + g->slack_mm;
}

/* The middle of the box of `side` voxels whose lowest voxel is (x, y, z), T. Whole bricks. */
RS_INLINE void rs_box_middle(RS_GLOBAL const SubstepArgs* a, rs_i32 x, rs_i32 y, rs_i32 z, rs_i32 side, float* p) {
  const rs_i32 bricks = side / RS_BRICK_SIDE - 1;
  for (int i = 0; i < 3; ++i) {
    p[i] = (float)rs_twice_in_tool(a, i, 2 * (x >> 3) + bricks, 2 * (y >> 3) + bricks, 2 * (z >> 3) + bricks) *
           (0.5f / (float)RS_LENGTH_SCALE);
  }
}

/* Bound of half the width of a voxel along the surface's normal while the tool moves by `shift`, voxels. The normal
 * rotates with the curvature of the surface and with the tool; next to a sharp corner it is discontinuous. `p`: centre,
 * T; `list`: the pieces that can be nearest to the voxel's brick. */
RS_INLINE rs_real rs_half_width(RS_GLOBAL const SubstepArgs* a, const OutlineView* outline, PieceList list,
                                const NearestPiece* nearest, const rs_real* p, rs_real r, float shift) {
  const rs_real widest = RS_REAL(RS_CLIP_REACH);
  RS_GLOBAL const OutlinePiece* piece = outline->pieces + outline->numbers[list.first];
  if (list.count > 1 || piece->before >= 0 || piece->after >= 0) return widest;
  const rs_real per_r = RS_REAL(1.0f) / rs_max(r, RS_REAL(0.5f * a->voxel_mm));
  const ClipPlane plane = rs_clip_plane(a, p[0] * per_r, p[1] * per_r, nearest->normal_r, nearest->normal_z,
                                        nearest->distance, nearest->curvature, per_r);
  const rs_real turn = (rs_abs(nearest->curvature) + rs_abs(nearest->normal_r) * per_r) * a->voxel_mm;
  const rs_real width = 0.5f * (rs_abs(plane.n[0]) + rs_abs(plane.n[1]) + rs_abs(plane.n[2]));
  return rs_min(width + (turn * (1.0f / 24.0f) + 0.02f) + shift * (2.0f * turn + 0.1f), widest);
}

/* Distance of the centre of voxel (x, y, z), counted within its brick, from the surface minus the reach while the tool
 * moves by `shift`, voxels. */
RS_INLINE rs_real rs_distance_beyond_reach(RS_GLOBAL const SubstepArgs* a, const OutlineView* outline, PieceList list,
                                           const BrickMiddle* brick, rs_real x, rs_real y, rs_real z, float shift) {
  rs_real p[3];
  const rs_real r = rs_voxel_in_tool(a, brick, x, y, z, p);
  const NearestPiece nearest = rs_outline_nearest(outline, list, r, p[2]);
  const float slack = shift + RS_POSITION_SLACK * a->per_voxel_mm;
  return nearest.distance * a->per_voxel_mm - rs_half_width(a, outline, list, &nearest, p, r, slack) - slack;
}

/* Whether one piece alone is nearest to all voxels of a brick, with its ends out of reach, while the tool moves by
 * `shift` mm. `list`: the pieces that can be nearest. */
RS_INLINE int rs_brick_is_smooth(RS_GLOBAL const SubstepArgs* a, const OutlineView* outline, PieceList list,
                                 const BrickMiddle* brick, float shift) {
  if (list.count != 1) return 0;
  RS_GLOBAL const OutlinePiece* e = outline->pieces + outline->numbers[list.first];
  const float* p = brick->p;
  const float r = RS_SQRT(p[0] * p[0] + p[1] * p[1]);
  const float margin = (RS_BRICK_RADIUS + RS_CLIP_REACH) * a->voxel_mm + shift + RS_POSITION_SLACK;
  return !RS_ANY(rs_distance_to_ends(e, RS_REAL(r), RS_REAL(p[2])) <= margin);
}

/* rs_distance_beyond_reach() in such a brick. The width of the voxels is found only where it decides. */
RS_INLINE rs_real rs_distance_beyond_reach_of_piece(RS_GLOBAL const SubstepArgs* a, const OutlineView* outline,
                                                    PieceList list, const BrickMiddle* brick, rs_real x, rs_real y,
                                                    rs_real z, float shift) {
  const float narrowest = 0.5f, slack = shift + RS_POSITION_SLACK * a->per_voxel_mm;
  RS_GLOBAL const OutlinePiece* piece = outline->pieces + outline->numbers[list.first];
  rs_real p[3];
  const rs_real r = rs_voxel_in_tool(a, brick, x, y, z, p);
  const PieceDistance away = rs_circle_distance(piece, r, p[2]);
  const rs_real distance = away.distance * a->per_voxel_mm - slack;
  const rs_real undecided = distance > narrowest ? RS_REAL(RS_CLIP_REACH) - distance : RS_REAL(-1.0f);
  if (!RS_ANY(undecided >= 0.0f)) return distance - narrowest;
  const NearestPiece nearest = rs_nearest_piece(&away, RS_REAL(piece->curvature), RS_INT(0));
  return distance - rs_half_width(a, outline, list, &nearest, p, r, slack);
}

/* For the voxels in the lanes: the section of the brick's list with all pieces that can be nearest to any of them while
 * the tool moves by `shift` mm. Returns whether it is a single piece with its ends out of reach. */
RS_INLINE int rs_find_nearest_pieces(RS_GLOBAL const SubstepArgs* a, const OutlineView* outline, PieceList list,
                                     const BrickMiddle* brick, rs_real x, rs_real y, rs_real z, float shift,
                                     PieceList* near) {
  rs_real p[3];
  const rs_real r = rs_voxel_in_tool(a, brick, x, y, z, p);
  const rs_real limit =
      rs_abs(rs_outline_nearest(outline, list, r, p[2]).distance) + 2.0f * (shift + RS_POSITION_SLACK);
  rs_u32 begin = list.count, end = 0;
  for (rs_u32 i = 0; i < list.count; ++i) {
    const PieceList one = {list.first + i, 1};
    if (!RS_ANY(rs_abs(rs_outline_nearest(outline, one, r, p[2]).distance) <= limit)) continue;
    begin = i < begin ? i : begin;
    end = i + 1;
  }
  near->first = list.first + begin;
  near->count = end - begin;
  RS_GLOBAL const OutlinePiece* piece = outline->pieces + outline->numbers[near->first];
  const float margin = RS_CLIP_REACH * a->voxel_mm + shift + RS_POSITION_SLACK;
  return near->count == 1 && !RS_ANY(rs_distance_to_ends(piece, r, p[2]) <= margin);
}

#endif
