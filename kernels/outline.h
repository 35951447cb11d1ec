/* The tool's outline in (r, z) of T as lines and arcs: smooth where the tool is, where the profile (profile.h) has many
 * short edges. One arithmetic for the host, for a work-item and for sixteen voxels in the lanes of a vector. */
#ifndef REAMSIM_KERNELS_OUTLINE_H
#define REAMSIM_KERNELS_OUTLINE_H

#ifndef REAMSIM_KERNELS_PROFILE_H
#include "profile.h"
#endif

/* A line or an arc of at most 90 degrees from (r0, z0) to (r1, z1), the inside on its left, mm; unit tangents at both
 * ends; the point in its middle with the outward unit normal there. */
typedef struct {
  float r0, z0, r1, z1;
  float along_r0, along_z0, along_r1, along_z1;
  float middle_r, middle_z, normal_r, normal_z;
  float curvature;      /* 1/mm, positive where it bulges outwards, 0 for a line */
  rs_i32 before, after; /* the piece on the other side of a sharp corner at its begin, at its end; -1 where none is */
} OutlinePiece;

/* The outline as a kernel sees it: lists of pieces for cells of (r, z), as ProfileView has them of edges. */
typedef struct {
  RS_GLOBAL const OutlinePiece* pieces;
  RS_GLOBAL const rs_u16* numbers;
  RS_GLOBAL const EdgeList* lists;
  RS_GLOBAL const ProfileGrid* grid;
} OutlineView;

/* What of the outline lies nearest to a point. */
typedef struct {
  rs_real distance; /* mm, negative inside */
  rs_real normal_r, normal_z;
  rs_real curvature;
  rs_int piece;
} NearestPiece;

/* How far the point at w from a piece's middle lies from the piece's circle, mm, on its outer side positive:
 * |w + R n| - R for radius R and normal n there, written so that a line is an arc of no curvature and what is small is
 * no difference of large numbers. `stretch`: |n + w/R|. */
RS_INLINE rs_real rs_from_arc(RS_GLOBAL const OutlinePiece* e, rs_real wr, rs_real wz, rs_real* stretch) {
  const rs_real q = e->curvature * (wr * wr + wz * wz) + 2.0f * (wr * e->normal_r + wz * e->normal_z);
  const rs_real square = (rs_real)1.0f + e->curvature * q;
  *stretch = RS_SQRT(square > 0.0f ? square : (rs_real)0.0f);
  return q / ((rs_real)1.0f + *stretch);
}

/* What lies nearest to (r, z), of the pieces in `list`. The normal is the gradient of the distance. Of two pieces that
 * are as near but for rounding, as next to a vertex, the one seen more squarely decides the sign. */
RS_INLINE NearestPiece rs_outline_nearest(const OutlineView* outline, EdgeList list, rs_real r, rs_real z) {
  const rs_real zero = (rs_real)0.0f, one = (rs_real)1.0f;
  rs_real best = (rs_real)1e30f, best_side = zero, on_best = one, gr = zero, gz = -one, length = one, curvature = zero;
  rs_int piece = (rs_int)0;
  for (rs_u32 i = 0; i < list.count; ++i) {
    const rs_i32 number = outline->numbers[list.first + i];
    RS_GLOBAL const OutlinePiece* e = outline->pieces + number;
    const rs_real wr = r - e->middle_r, wz = z - e->middle_z;
    rs_real stretch;
    const rs_real from_arc = rs_from_arc(e, wr, wz, &stretch);
    const rs_real r0 = r - e->r0, z0 = z - e->z0, r1 = r - e->r1, z1 = z - e->z1;
    const rs_real past = r1 * e->along_r1 + z1 * e->along_z1, short_of = -(r0 * e->along_r0 + z0 * e->along_z0);
    const rs_real on = (past > short_of ? past : short_of) > 0.0f ? zero : one;
    const rs_real pr = past > 0.0f ? r1 : r0, pz = past > 0.0f ? z1 : z0;
    const rs_real end_side = past > 0.0f ? r1 * e->along_z1 - z1 * e->along_r1 : r0 * e->along_z0 - z0 * e->along_r0;
    const rs_real d2 = on > 0.0f ? from_arc * from_arc : pr * pr + pz * pz;
    const rs_real side = on > 0.0f ? from_arc : end_side;
    const rs_real abs_side = side < 0.0f ? -side : side, abs_best = best_side < 0.0f ? -best_side : best_side;
    const rs_real rounding = best * 2e-6f + 1e-10f;
    const rs_real tie = d2 <= best + rounding ? abs_side - abs_best : -one;
    const rs_real gain = d2 < best - rounding ? one : tie;
    best = gain > 0.0f ? d2 : best;
    best_side = gain > 0.0f ? side : best_side;
    on_best = gain > 0.0f ? on : on_best;
    gr = gain > 0.0f ? (on > 0.0f ? e->normal_r + e->curvature * wr : pr) : gr;
    gz = gain > 0.0f ? (on > 0.0f ? e->normal_z + e->curvature * wz : pz) : gz;
    length = gain > 0.0f ? stretch : length;
    curvature = gain > 0.0f ? (rs_real)e->curvature : curvature;
    piece = gain > 0.0f ? (rs_int)number : piece;
  }
  const rs_real sign = best_side < 0.0f ? -one : one;
  const rs_real away = sign * RS_SQRT(best);
  NearestPiece out;
  out.distance = on_best > 0.0f ? best_side : away;
  const rs_real divisor = on_best > 0.0f ? length : away;
  /* In a vertex, or in an arc's centre, every direction is as good as another. */
  const rs_real known = divisor * divisor > 1e-12f ? one : zero;
  const rs_real per = one / (known > 0.0f ? divisor : one);
  out.normal_r = known > 0.0f ? gr * per : zero;
  out.normal_z = known > 0.0f ? gz * per : -one;
  out.curvature = curvature;
  out.piece = piece;
  return out;
}

/* The list of pieces for points within the grid's reach of (r, z). */
RS_INLINE EdgeList rs_pieces_near(const OutlineView* outline, float r, float z) {
  return rs_list_of_cell(outline->grid, outline->lists, r, z);
}

#endif
