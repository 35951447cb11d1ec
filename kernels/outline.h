// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* The outline of the tool's envelope of revolution in (r, z) of T, as lines and arcs. The same code serves host,
 * work-item and lanes (lanes.h). */
#ifndef REAMSIM_KERNELS_OUTLINE_H
#define REAMSIM_KERNELS_OUTLINE_H

#include "lanes.h"

/* A line or an arc of at most 100 degrees from (r0, z0) to (r1, z1), mm, with the inside on its left: unit tangents at
 * both ends, and its middle with the outward unit normal. */
typedef struct {
  float r0, z0, r1, z1;
  float along_r0, along_z0, along_r1, along_z1;
  float middle_r, middle_z, normal_r, normal_z;
  float curvature;      /* 1/mm, positive where it bulges outwards, 0 for a line */
  rs_i32 before, after; /* the piece beyond a sharp corner at the begin, at the end; -1: none */
} OutlinePiece;
RS_SAME_LAYOUT(OutlinePiece, 60);

/* A grid of square cells over (r, z), each with an ascending list of the pieces that can be nearest to a point within
 * the grid's reach of the cell. Cells far from the outline, and points off the grid, use list 0 of all pieces. */
typedef struct {
  float z0; /* mm; r begins at 0 */
  float per_mm;
  rs_i32 count_r, count_z;
} OutlineGrid;
RS_SAME_LAYOUT(OutlineGrid, 16);

typedef struct {
  rs_u32 first; /* into the array of piece numbers */
  rs_u32 count;
} PieceList;
RS_SAME_LAYOUT(PieceList, 8);

/* The outline in device memory. */
typedef struct {
  RS_GLOBAL const OutlinePiece* pieces;
  RS_GLOBAL const rs_u16* numbers;  /* of pieces, list after list */
  RS_GLOBAL const PieceList* lists; /* [1 + count_r * count_z]; cell (r, z) has list 1 + r + count_r * z */
  RS_GLOBAL const OutlineGrid* grid;
} OutlineView;

/* The nearest point of the outline. */
typedef struct {
  rs_real distance; /* mm, negative inside */
  rs_real normal_r, normal_z;
  rs_real curvature;
  rs_int piece;
} NearestPiece;

/* Distance of a point (r, z) from one piece, negative inside, and its square; distance on the outer side of the piece's
 * tangent; outward direction, to be multiplied by `scale`. */
typedef struct {
  rs_real distance, square, side;
  rs_real r, z, scale;
} PieceDistance;

/* Within this fraction of the radius, the truncation error of the series for roots is below rounding. */
#define RS_NEAR_CIRCLE 0.03125f

/* Distance from the circle of a piece, positive outside: |w + R n| - R for the vector w from its middle, radius R and
 * normal n. Written without cancellation, and so that a line is an arc of curvature 0: q/(1 + sqrt(1 + x)) with x =
 * q/R, q = w^2/R + 2 w.n. */
RS_INLINE PieceDistance rs_circle_distance(RS_GLOBAL const OutlinePiece* e, rs_real r, rs_real z) {
  const rs_real zero = RS_REAL(0.0f), one = RS_REAL(1.0f);
  const rs_real wr = r - e->middle_r, wz = z - e->middle_z;
  const rs_real q = e->curvature * (wr * wr + wz * wz) + 2.0f * (wr * e->normal_r + wz * e->normal_z);
  const rs_real x = e->curvature * q, size = x < 0.0f ? -x : x;
  PieceDistance out;
  out.r = e->normal_r + e->curvature * wr;
  out.z = e->normal_z + e->curvature * wz;
  /* A series next to the surface: no root, no division. */
  out.distance = q * (0.5f + x * (-0.125f + x * (0.0625f + x * (-5.0f / 128.0f + x * (7.0f / 256.0f)))));
  out.scale = one + x * (-0.5f + x * (0.375f + x * (-0.3125f + x * (35.0f / 128.0f))));
  if (RS_ANY(size > RS_NEAR_CIRCLE)) {
    const rs_real root = RS_SQRT(one + x > 0.0f ? one + x : zero);
    /* In the circle's centre the direction is arbitrary. */
    const rs_real known = root > 1e-6f ? one / root : zero;
    out.distance = size > RS_NEAR_CIRCLE ? q / (one + root) : out.distance;
    out.scale = size > RS_NEAR_CIRCLE ? known : out.scale;
  }
  out.side = out.distance;
  out.square = out.distance * out.distance;
  return out;
}

/* Distance from a piece, whose ends are nearest to points beyond them. */
RS_INLINE PieceDistance rs_piece_distance(RS_GLOBAL const OutlinePiece* e, rs_real r, rs_real z) {
  PieceDistance out = rs_circle_distance(e, r, z);
  const rs_real r0 = r - e->r0, z0 = z - e->z0, r1 = r - e->r1, z1 = z - e->z1;
  const rs_real past = r1 * e->along_r1 + z1 * e->along_z1, short_of = -(r0 * e->along_r0 + z0 * e->along_z0);
  const rs_real off = past > short_of ? past : short_of;
  if (!RS_ANY(off > 0.0f)) return out;
  const rs_real pr = past > 0.0f ? r1 : r0, pz = past > 0.0f ? z1 : z0;
  const rs_real end_side = past > 0.0f ? r1 * e->along_z1 - z1 * e->along_r1 : r0 * e->along_z0 - z0 * e->along_r0;
  const rs_real square = pr * pr + pz * pz, root = RS_SQRT(square), away = end_side < 0.0f ? -root : root;
  out.side = off > 0.0f ? end_side : out.side;
  out.square = off > 0.0f ? square : out.square;
  out.distance = off > 0.0f ? away : out.distance;
  out.r = off > 0.0f ? pr : out.r;
  out.z = off > 0.0f ? pz : out.z;
  const rs_real per_away = root > 1e-6f ? RS_REAL(1.0f) / away : RS_REAL(0.0f);
  out.scale = off > 0.0f ? per_away : out.scale;
  return out;
}

/* How far a point lies from the normals at the piece's ends, mm; negative beyond an end. */
RS_INLINE rs_real rs_distance_to_ends(RS_GLOBAL const OutlinePiece* e, rs_real r, rs_real z) {
  const rs_real past = (r - e->r1) * e->along_r1 + (z - e->z1) * e->along_z1;
  const rs_real short_of = -((r - e->r0) * e->along_r0 + (z - e->z0) * e->along_z0);
  return -(past > short_of ? past : short_of);
}

RS_INLINE NearestPiece rs_nearest_piece(const PieceDistance* best, rs_real curvature, rs_int piece) {
  const rs_real known = best->scale < 0.0f ? -best->scale : best->scale;
  NearestPiece out;
  out.distance = best->distance;
  out.normal_r = best->r * best->scale;
  out.normal_z = known > 0.0f ? best->z * best->scale : RS_REAL(-1.0f);
  out.curvature = curvature;
  out.piece = piece;
  return out;
}

/* The nearest point of (r, z), of the pieces in `list`. The normal is the gradient of the distance. Of two pieces
 * equally near up to rounding, as next to a vertex, the more perpendicular one decides the sign. */
RS_INLINE NearestPiece rs_outline_nearest(const OutlineView* outline, PieceList list, rs_real r, rs_real z) {
  const rs_real one = RS_REAL(1.0f);
  rs_i32 number = outline->numbers[list.first];
  PieceDistance best = rs_piece_distance(outline->pieces + number, r, z);
  rs_real curvature = RS_REAL(outline->pieces[number].curvature);
  rs_int piece = RS_INT(number);
  for (rs_u32 i = 1; i < list.count; ++i) {
    number = outline->numbers[list.first + i];
    const PieceDistance found = rs_piece_distance(outline->pieces + number, r, z);
    const rs_real side = found.side < 0.0f ? -found.side : found.side;
    const rs_real best_side = best.side < 0.0f ? -best.side : best.side;
    const rs_real rounding = best.square * 2e-6f + 1e-10f;
    const rs_real tie = found.square <= best.square + rounding ? side - best_side : -one;
    const rs_real gain = found.square < best.square - rounding ? one : tie;
    best.square = gain > 0.0f ? found.square : best.square;
    best.side = gain > 0.0f ? found.side : best.side;
    best.distance = gain > 0.0f ? found.distance : best.distance;
    best.r = gain > 0.0f ? found.r : best.r;
    best.z = gain > 0.0f ? found.z : best.z;
    best.scale = gain > 0.0f ? found.scale : best.scale;
    curvature = gain > 0.0f ? RS_REAL(outline->pieces[number].curvature) : curvature;
    piece = gain > 0.0f ? RS_INT(number) : piece;
  }
  return rs_nearest_piece(&best, curvature, piece);
}

/* The list of pieces for points within the grid's reach of (r, z). */
RS_INLINE PieceList rs_pieces_near(const OutlineView* outline, float r, float z) {
  RS_GLOBAL const OutlineGrid* g = outline->grid;
  const float cr = r * g->per_mm, cz = (z - g->z0) * g->per_mm;
  if (!(cr < (float)g->count_r && cz >= 0 && cz < (float)g->count_z)) return outline->lists[0];
  return outline->lists[1 + (rs_i32)cr + g->count_r * (rs_i32)cz];
}

/* Outward unit normal in T at the surface point nearest to `p` (T, mm), of the pieces in `list`. It has no radial part
 * on the spin axis. */
RS_INLINE void rs_outline_normal(const OutlineView* outline, PieceList list, const rs_real* p, rs_real* normal) {
  const rs_real r = RS_SQRT(p[0] * p[0] + p[1] * p[1]);
  const NearestPiece nearest = rs_outline_nearest(outline, list, r, p[2]);
  const rs_real radial = r > 0.0f ? nearest.normal_r / r : RS_REAL(0.0f);
  normal[0] = radial * p[0];
  normal[1] = radial * p[1];
  normal[2] = nearest.normal_z;
}

#if !defined(RS_LANES)
/* Whether (r, z), r >= 0, lies in the solid of revolution or, up to the rounding of single precision, on its surface.
 */
RS_INLINE int rs_inside_outline(const OutlineView* outline, float r, float z) {
  return rs_outline_nearest(outline, rs_pieces_near(outline, r, z), r, z).distance <= 1e-6f;
}
#endif

#endif
