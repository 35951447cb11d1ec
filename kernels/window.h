// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Exact erosion over a window of frames whose motion is smooth (docs/erosion.md, 3): the distance of a voxel from the
 * tool is a quadratic polynomial of time through three nodes, the fraction outside the tool is a piecewise cubic of
 * that distance, and force and torque are its loss times a vector that is linear in time. The same code serves host,
 * work-item and lanes (lanes.h). */
#ifndef REAMSIM_KERNELS_WINDOW_H
#define REAMSIM_KERNELS_WINDOW_H

#include "clip.h"

/* A window of frames, each of a single substep: the substeps of its nodes, and their times in units of half a window
 * from the middle node. */
typedef struct {
  SubstepArgs first, middle, last;
  float first_time, last_time; /* < 0, > 0 */
  float per_frame;             /* times of consecutive frames differ by this */
  float padding;
} MotionWindow;
RS_SAME_LAYOUT(MotionWindow, 3 * sizeof(SubstepArgs) + 16);

/* Forces, torques (T), energy, speed-floor energy: in the order of SubstepSums. */
#define RS_WINDOW_SUMS 8
#define RS_SUM_OF_TORQUE 3
#define RS_SUM_OF_ENERGY 6
#define RS_SUM_OF_FLOOR 7

/* The polynomial c[0] + c[1] x + ... with x = y - at. */
typedef struct {
  rs_real at;
  rs_real c[4];
} Cubic;

/* The most cubics of a voxel's fraction in a window. */
#define RS_WINDOW_PIECES 3

/* A voxel in a window. */
typedef struct {
  rs_real depth1,
      depth2; /* depth y of the tool's plane against that of the middle node, voxels: coefficients of time */
  rs_real error1, error2;                              /* correction of the fraction, units of fill */
  Cubic piece[RS_WINDOW_PIECES];                       /* fraction outside over y, units of fill; ascending in y */
  rs_real begin[RS_WINDOW_PIECES - 1];                 /* y where the second and third piece begin */
  rs_real base[RS_WINDOW_SUMS], slope[RS_WINDOW_SUMS]; /* per unit of lost fill: coefficients of time */
  rs_real pieces;                                      /* number; 0: the voxel must be cut frame by frame */
} WindowVoxel;

/* The coefficients of time of a quadratic that is zero at the middle node. */
RS_INLINE void rs_quadratic(RS_GLOBAL const MotionWindow* w, rs_real at_first, rs_real at_last, rs_real* c1,
                            rs_real* c2) {
  const rs_real first = at_first / w->first_time, last = at_last / w->last_time;
  *c2 = (last - first) / (w->last_time - w->first_time);
  *c1 = first - *c2 * w->first_time;
}

/* ---- The fraction of a unit cube below a plane at depth g, as cubics between the depths of its corners ---- */

#define RS_CUBE_REGIONS 9

/* A unit cube and a direction: components in ascending order, and the depths where the cubics change; the first region
 * ends at 0, the last begins at `whole`. */
typedef struct {
  rs_real m1, m2, m3, whole, third; /* third: where the middle region begins */
  rs_real per_all, per_pair;        /* 1/(6 m1 m2 m3), 1/(2 m2 m3) */
} CubeDepths;

RS_INLINE CubeDepths rs_cube_depths(const rs_real* n) {
  CubeDepths out;
  rs_sort_components(n, &out.m1, &out.m2, &out.m3);
  out.whole = out.m1 + out.m2 + out.m3;
  out.third = rs_min(out.m1 + out.m2, out.m3);
  out.per_pair = 0.5f / (out.m2 * out.m3);
  out.per_all = out.per_pair / (3.0f * out.m1);
  return out;
}

/* Subtracts scale·(e + y)^3. */
RS_INLINE void rs_subtract_cube(rs_real scale, rs_real e, Cubic* f) {
  f->c[0] -= scale * (e * e * e);
  f->c[1] -= scale * (3.0f * e * e);
  f->c[2] -= scale * (3.0f * e);
  f->c[3] -= scale;
}

/* The cubic of a region about depth `at`. */
RS_INLINE Cubic rs_region_cubic(const CubeDepths* d, int region, rs_real at) {
  const rs_real zero = RS_REAL(0.0f), one = RS_REAL(1.0f);
  const int mirrored = region > 4, lower = mirrored ? 8 - region : region;
  const rs_real g = mirrored ? d->whole - at : at;
  Cubic f = {at, {zero, zero, zero, zero}};
  if (lower == 1) rs_subtract_cube(-d->per_all, g, &f);
  if (lower >= 2) {
    f.c[0] = (g * (g - d->m1) + d->m1 * d->m1 * (1.0f / 3.0f)) * d->per_pair;
    f.c[1] = (g + g - d->m1) * d->per_pair;
    f.c[2] = d->per_pair;
  }
  if (lower >= 3) rs_subtract_cube(d->per_all, g - d->m2, &f);
  if (lower == 4) {
    const rs_real slab = d->m1 + d->m2 - d->m3;
    Cubic skew = f;
    rs_subtract_cube(d->per_all, g - d->m3, &skew);
    const rs_real per = one / d->m3;
    f.c[0] = slab <= 0.0f ? (g - 0.5f * (d->m1 + d->m2)) * per : skew.c[0];
    f.c[1] = slab <= 0.0f ? per : skew.c[1];
    f.c[2] = slab <= 0.0f ? zero : skew.c[2];
    f.c[3] = slab <= 0.0f ? zero : skew.c[3];
  }
  if (mirrored) {
    f.c[0] = one - f.c[0];
    f.c[2] = -f.c[2];
  }
  return f;
}

/* A region narrower than this, voxels, and than a quarter of the plane's way, is left to its neighbours. */
#define RS_NARROW_REGION 1e-4f

/* Sets the pieces for depths `low` to `high` about `at`. */
RS_INLINE void rs_set_pieces(const CubeDepths* d, rs_real low, rs_real high, rs_real at, WindowVoxel* v) {
  const rs_real zero = RS_REAL(0.0f), one = RS_REAL(1.0f), far = RS_REAL(1e30f), unit = RS_REAL((float)RS_WHOLE_FILL);
  const rs_real from = low - 1e-6f, to = high + 1e-6f;
  const rs_real narrow = rs_min(RS_REAL(RS_NARROW_REGION), (to - from) * 0.25f);
  v->pieces = zero;
  for (int i = 0; i < RS_WINDOW_PIECES; ++i) {
    v->piece[i].at = zero;
    for (int k = 0; k < 4; ++k) v->piece[i].c[k] = zero;
    if (i > 0) v->begin[i - 1] = far;
  }
  const rs_real begins[RS_CUBE_REGIONS + 1] = {
      -far, zero, d->m1, d->m2, d->third, d->whole - d->third, d->whole - d->m2, d->whole - d->m1, d->whole, far};
  for (int region = 0; region < RS_CUBE_REGIONS; ++region) {
    const rs_real begin = begins[region], lower = rs_max(from, begin), upper = rs_min(to, begins[region + 1]);
    const rs_real there = upper - lower > narrow ? one : zero;
    if (!RS_ANY(there > 0.0f)) continue;
    const Cubic f = rs_region_cubic(d, region, 0.5f * (lower + upper));
    for (int i = 0; i < RS_WINDOW_PIECES; ++i) {
      const rs_real here = v->pieces == (float)i ? there : zero;
      v->piece[i].at = here > 0.0f ? f.at - at : v->piece[i].at;
      for (int k = 0; k < 4; ++k) v->piece[i].c[k] = here > 0.0f ? f.c[k] * unit : v->piece[i].c[k];
      if (i > 0) v->begin[i - 1] = here > 0.0f ? begin - at : v->begin[i - 1];
    }
    v->pieces += there;
  }
  v->pieces = v->pieces <= (float)RS_WINDOW_PIECES ? v->pieces : zero;
}

RS_INLINE rs_real rs_cubic(const Cubic* f, rs_real y) {
  const rs_real x = y - f->at;
  return RS_FMA(RS_FMA(RS_FMA(f->c[3], x, f->c[2]), x, f->c[1]), x, f->c[0]);
}

/* The fraction outside at depth y, units of fill, without correction. `pieces`: at least the number of the voxel, at
 * most RS_WINDOW_PIECES. */
RS_INLINE rs_real rs_pieces_at(const WindowVoxel* v, rs_real y, int pieces) {
  rs_real out = rs_cubic(&v->piece[0], y);
  if (pieces > 1) {
    const rs_real second = rs_cubic(&v->piece[1], y);
    out = y >= v->begin[0] ? second : out;
  }
  if (pieces > 2) {
    const rs_real third = rs_cubic(&v->piece[2], y);
    out = y >= v->begin[1] ? third : out;
  }
  return out;
}

/* Fill of a whole voxel outside the tool at a time. `pieces`: at least the number of the voxel. */
RS_INLINE rs_int rs_window_outside(const WindowVoxel* v, rs_real time, int pieces) {
  const rs_real y = time * RS_FMA(time, v->depth2, v->depth1), more = time * RS_FMA(time, v->error2, v->error1);
  const rs_real fill = rs_pieces_at(v, y, pieces) + more;
  return RS_TO_INT(rs_max(rs_min(fill, RS_REAL((float)RS_WHOLE_FILL)), RS_REAL(0.0f)) + 0.5f);
}

/* A voxel whose normal turns so much that the fraction misses that of a node by more, units of fill, is cut frame by
 * frame; so is one whose force bends by more of itself. */
#define RS_MOST_ERROR 64.0f
#define RS_MOST_BEND 1e-3f

/* Sets the polynomials from the tool next to the voxel at the three nodes. */
RS_INLINE void rs_fit_fraction(RS_GLOBAL const MotionWindow* w, const Clip* first, const Clip* middle, const Clip* last,
                               WindowVoxel* v) {
  const rs_real zero = RS_REAL(0.0f), unit = RS_REAL((float)RS_WHOLE_FILL);
  const CubeDepths d = rs_cube_depths(middle->plane.n);
  const rs_real y0 = first->plane.away - middle->plane.away, y2 = last->plane.away - middle->plane.away;
  const rs_real at = 0.5f * d.whole + middle->plane.away;
  rs_quadratic(w, y0, y2, &v->depth1, &v->depth2);
  /* The quadratic passes its ends by at most an eighth of its bend. */
  const rs_real beyond = rs_abs(v->depth2) * 0.125f;
  rs_set_pieces(&d, at + rs_min(rs_min(y0, y2), zero) - beyond, at + rs_max(rs_max(y0, y2), zero) + beyond, at, v);
  const rs_real e0 =
      rs_outside_fraction(first->plane.n, first->plane.away) * unit - rs_pieces_at(v, y0, RS_WINDOW_PIECES);
  const rs_real e1 =
      rs_outside_fraction(middle->plane.n, middle->plane.away) * unit - rs_pieces_at(v, zero, RS_WINDOW_PIECES);
  const rs_real e2 =
      rs_outside_fraction(last->plane.n, last->plane.away) * unit - rs_pieces_at(v, y2, RS_WINDOW_PIECES);
  rs_quadratic(w, e0 - e1, e2 - e1, &v->error1, &v->error2);
  for (int i = 0; i < RS_WINDOW_PIECES; ++i) v->piece[i].c[0] += e1;
  const rs_real most = rs_max(rs_max(rs_abs(e0), rs_abs(e1)), rs_abs(e2));
  v->pieces = most <= RS_MOST_ERROR ? v->pieces : zero;
}

/* Sets the line through the responses at the three nodes that deviates least on average. */
RS_INLINE void rs_fit_force(RS_GLOBAL const MotionWindow* w, const rs_real* first, const rs_real* middle,
                            const rs_real* last, WindowVoxel* v) {
  const rs_real zero = RS_REAL(0.0f);
  rs_real bend = zero, size = zero;
  for (int i = 0; i < RS_WINDOW_SUMS; ++i) {
    rs_real c1, c2;
    rs_quadratic(w, first[i] - middle[i], last[i] - middle[i], &c1, &c2);
    v->base[i] = middle[i] + c2 * (1.0f / 3.0f);
    v->slope[i] = c1;
    if (i >= RS_SUM_OF_TORQUE) continue;
    bend = rs_max(bend, rs_abs(c2));
    size = rs_max(size, rs_abs(middle[i]));
  }
  v->pieces = bend <= size * RS_MOST_BEND ? v->pieces : zero;
}

/* Time of a substep in its window. */
RS_INLINE float rs_window_time(RS_GLOBAL const MotionWindow* w, rs_i32 frame) {
  return (float)(frame - w->middle.frame) * w->per_frame;
}

/* Force, torque and energies of a voxel that loses a unit of fill. `whole`: energy of a whole voxel, mJ. */
RS_INLINE void rs_window_response(RS_GLOBAL const SubstepArgs* a, const Clip* clip, rs_real whole, rs_real* out) {
  const rs_real *p = clip->p, energy = whole * (1.0f / (float)RS_WHOLE_FILL);
  const CutResponse found = rs_cut_response(a, clip->n, p, energy);
  for (int i = 0; i < 3; ++i) out[i] = found.force[i];
  rs_real* torque = out + RS_SUM_OF_TORQUE;
  torque[0] = p[1] * found.force[2] - p[2] * found.force[1];
  torque[1] = p[2] * found.force[0] - p[0] * found.force[2];
  torque[2] = p[0] * found.force[1] - p[1] * found.force[0];
  out[RS_SUM_OF_ENERGY] = energy + found.added_energy;
  out[RS_SUM_OF_FLOOR] = found.floor_energy;
}

/* The voxel in a window, from the tool next to it at the three nodes. `whole`: energy of a whole voxel, mJ. */
RS_INLINE void rs_fit_voxel(RS_GLOBAL const MotionWindow* w, const Clip* first, const Clip* middle, const Clip* last,
                            rs_real whole, WindowVoxel* v) {
  const rs_real zero = RS_REAL(0.0f), one = RS_REAL(1.0f);
  rs_fit_fraction(w, first, middle, last, v);
  rs_real at_first[RS_WINDOW_SUMS], at_middle[RS_WINDOW_SUMS], at_last[RS_WINDOW_SUMS];
  rs_window_response(&w->first, first, whole, at_first);
  rs_window_response(&w->middle, middle, whole, at_middle);
  rs_window_response(&w->last, last, whole, at_last);
  rs_fit_force(w, at_first, at_middle, at_last, v);
  /* Across corners and between pieces of the outline the distance is no polynomial. */
  const rs_real corners = rs_abs(first->corner) + rs_abs(middle->corner) + rs_abs(last->corner);
  const rs_real moved = first->piece == middle->piece ? (middle->piece == last->piece ? zero : one) : one;
  v->pieces = corners + moved > 0.0f ? zero : v->pieces;
}

/* Sums over the voxels of a brick in one frame, in ascending order of their places: constants, then linear parts. Adds
 * them at `time` to `total`. */
RS_INLINE void rs_finish_window_sums(const float* sums, float time, SubstepSums* total) {
  rs_i64 part[RS_WINDOW_SUMS];
  for (int i = 0; i < RS_WINDOW_SUMS; ++i) {
    const float scale = i < RS_SUM_OF_TORQUE   ? (float)RS_FORCE_SCALE
                        : i < RS_SUM_OF_ENERGY ? (float)RS_TORQUE_SCALE
                                               : (float)RS_ENERGY_SCALE;
    part[i] = (rs_i64)(RS_FMA(time, sums[RS_WINDOW_SUMS + i], sums[i]) * scale);
  }
  for (int i = 0; i < 3; ++i) {
    total->force[i] += part[i];
    total->torque[i] += part[RS_SUM_OF_TORQUE + i];
  }
  total->energy += part[RS_SUM_OF_ENERGY];
  total->floor_energy += part[RS_SUM_OF_FLOOR];
}

#endif
