// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* The signed distance to a tool with resolved cutting edges, sampled on a lattice that rotates with them. Bricks of
 * 8x8x8 cells are stored next to the surface only; in a cell the distance is trilinear. The same code serves host,
 * work-item and lanes, as in lanes.h. */
#ifndef REAMSIM_KERNELS_DISTANCE_GRID_H
#define REAMSIM_KERNELS_DISTANCE_GRID_H

#include "clip.h"

/* A brick stores the samples at all corners of its cells, 9 along an axis, so that a cell reads one brick. */
#define RS_GRID_SIDE 8
#define RS_GRID_ROW 9
#define RS_GRID_SAMPLES 729

/* Largest gradient of the trilinear distance: the square root of 3, because its derivative along each axis is at most
 * 1, as that of its samples (sim/tool/distance_grid.cpp). */
#define RS_GRID_STEEPEST 1.7320509f

typedef struct {
  float origin[3]; /* sample (0,0,0), tool frame with the spin, mm */
  float per_mm;
  float last[3];  /* middle of the last cell, cells; coordinates are clamped to it */
  float slack_mm; /* distance outside the envelope minus distance from the surface, at most */
  rs_i32 bricks[3];
} DistanceLattice;
RS_SAME_LAYOUT(DistanceLattice, 44);

typedef struct {
  RS_GLOBAL const DistanceLattice* lattice;
  RS_GLOBAL const rs_u32* slot_of_brick; /* x fastest; 0: far outside, 1: far inside */
  RS_GLOBAL const float* samples;        /* mm, slot by slot, x fastest */
} DistanceView;

/* The sample at the lowest corner of cell (x, y, z). */
RS_INLINE RS_GLOBAL const float* rs_grid_cell(const DistanceView* view, rs_i32 x, rs_i32 y, rs_i32 z) {
  RS_GLOBAL const rs_i32* bricks = view->lattice->bricks;
  const rs_u32 slot = view->slot_of_brick[(x >> 3) + bricks[0] * ((y >> 3) + bricks[1] * (z >> 3))];
  return view->samples + (rs_u64)slot * RS_GRID_SAMPLES + ((x & 7) + RS_GRID_ROW * ((y & 7) + RS_GRID_ROW * (z & 7)));
}

/* Corner `i` of a cell lies at x + (i & 1), y + (i >> 1 & 1), z + (i >> 2). */
RS_INLINE rs_i32 rs_grid_corner(int i) {
  return (i & 1) + RS_GRID_ROW * (i >> 1 & 1) + RS_GRID_ROW * RS_GRID_ROW * (i >> 2);
}

/* The samples at the eight corners of a cell. */
RS_INLINE void rs_grid_corners(const DistanceView* view, const rs_int* cell, rs_real* corners) {
#if defined(RS_LANES)
  int at[3][RS_LANES];
  float samples[8][RS_LANES];
  for (int i = 0; i < 3; ++i) vstore16(cell[i], 0, at[i]);
  for (int l = 0; l < RS_LANES; ++l) {
    RS_GLOBAL const float* lowest = rs_grid_cell(view, at[0][l], at[1][l], at[2][l]);
    for (int i = 0; i < 8; ++i) samples[i][l] = lowest[rs_grid_corner(i)];
  }
  for (int i = 0; i < 8; ++i) corners[i] = vload16(0, samples[i]);
#else
  RS_GLOBAL const float* lowest = rs_grid_cell(view, cell[0], cell[1], cell[2]);
  for (int i = 0; i < 8; ++i) corners[i] = lowest[rs_grid_corner(i)];
#endif
}

/* Signed distance at `q` (tool frame with the spin), mm, and its derivative along each axis, mm per cell. Beyond the
 * band the distance is constant. */
RS_INLINE rs_real rs_grid_distance(const DistanceView* view, const rs_real* q, rs_real* rise) {
  RS_GLOBAL const DistanceLattice* g = view->lattice;
  rs_int cell[3];
  rs_real t[3], c[8];
  for (int i = 0; i < 3; ++i) {
    const rs_real at = (q[i] - g->origin[i]) * g->per_mm;
    const rs_real on = rs_min(rs_max(at, RS_REAL(0.0f)), RS_REAL(g->last[i]));
    cell[i] = RS_TO_INT(on);
    t[i] = on - RS_TO_REAL(cell[i]);
  }
  rs_grid_corners(view, cell, c);
  const rs_real x0 = c[1] - c[0], x1 = c[3] - c[2], x2 = c[5] - c[4], x3 = c[7] - c[6];
  const rs_real e0 = c[0] + t[0] * x0, e1 = c[2] + t[0] * x1, e2 = c[4] + t[0] * x2, e3 = c[6] + t[0] * x3;
  const rs_real y0 = e1 - e0, y1 = e3 - e2;
  const rs_real f0 = e0 + t[1] * y0, f1 = e2 + t[1] * y1;
  const rs_real along_x0 = x0 + t[1] * (x1 - x0), along_x1 = x2 + t[1] * (x3 - x2);
  rise[0] = along_x0 + t[2] * (along_x1 - along_x0);
  rise[1] = y0 + t[2] * (y1 - y0);
  rise[2] = f1 - f0;
  return f0 + t[2] * rise[2];
}

/* From T to the frame that rotates with the cutting edges. */
RS_INLINE void rs_rotate_to_teeth(RS_GLOBAL const SubstepArgs* a, const rs_real* p, rs_real* q) {
  q[0] = p[0] * a->spin_cos - p[1] * a->spin_sin;
  q[1] = p[0] * a->spin_sin + p[1] * a->spin_cos;
  q[2] = p[2];
}

/* Distance of voxel (x, y, z), counted as in rs_clip(), from the surface, mm. */
RS_INLINE rs_real rs_clip_grid_distance(RS_GLOBAL const SubstepArgs* a, const DistanceView* teeth,
                                        const BrickMiddle* brick, rs_real x, rs_real y, rs_real z) {
  rs_real p[3], q[3], rise[3];
  rs_voxel_in_tool(a, brick, x, y, z, p);
  rs_rotate_to_teeth(a, p, q);
  return rs_grid_distance(teeth, q, rise);
}

/* As rs_clip(), by the distance grid: the plane's normal is the gradient of the distance. `n` is the plane's normal,
 * and not yet that of the force. */
RS_INLINE Clip rs_clip_grid(RS_GLOBAL const SubstepArgs* a, const DistanceView* teeth, const BrickMiddle* brick,
                            rs_real x, rs_real y, rs_real z) {
  const rs_real zero = RS_REAL(0.0f), one = RS_REAL(1.0f);
  Clip clip;
  rs_real q[3], g[3];
  rs_voxel_in_tool(a, brick, x, y, z, clip.p);
  rs_rotate_to_teeth(a, clip.p, q);
  clip.distance = rs_grid_distance(teeth, q, g);
  const rs_real length = RS_SQRT(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
  const rs_real per_length = length > 0.0f ? one / length : zero;
  clip.n[0] = (g[0] * a->spin_cos + g[1] * a->spin_sin) * per_length;
  clip.n[1] = (g[1] * a->spin_cos - g[0] * a->spin_sin) * per_length;
  clip.n[2] = length > 0.0f ? g[2] * per_length : one;
  clip.distance += clip.n[0] * brick->rest[0] + clip.n[1] * brick->rest[1] + clip.n[2] * brick->rest[2];
  clip.plane = rs_lattice_plane(a, clip.n, clip.distance * a->per_voxel_mm);
  clip.other = clip.plane;
  clip.corner = zero;
  clip.piece = RS_INT(0);
  return clip;
}

/* Resolved cutting edges exert the force along the normal of their envelope (docs/physics.md, 4). */
RS_INLINE void rs_use_envelope_normal(const OutlineView* outline, PieceList list, Clip* clip) {
  const rs_real r = RS_SQRT(clip->p[0] * clip->p[0] + clip->p[1] * clip->p[1]);
  const rs_real per_r = r > 0.0f ? RS_REAL(1.0f) / r : RS_REAL(0.0f);
  const NearestPiece nearest = rs_outline_nearest(outline, list, r, clip->p[2]);
  rs_real c, s;
  rs_axis_direction(clip->p, r, per_r, &c, &s);
  clip->n[0] = nearest.normal_r * c;
  clip->n[1] = nearest.normal_r * s;
  clip->n[2] = nearest.normal_z;
}

#endif
