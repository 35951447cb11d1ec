// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* The fraction of a unit cube that lies outside one plane, and outside two. */
#ifndef REAMSIM_KERNELS_CUBE_FRACTION_H
#define REAMSIM_KERNELS_CUBE_FRACTION_H

#include "outline.h"

/* A surface farther than this from a voxel's centre does not intersect the voxel, voxels: half its diagonal and an
 * allowance for curvature. */
#define RS_CLIP_REACH (0.8660254f + 1.0f / 24.0f)

/* The magnitudes of three components in ascending order, the first two at least 1e-9. */
RS_INLINE void rs_sort_components(const rs_real* n, rs_real* m1, rs_real* m2, rs_real* m3) {
  const rs_real least = RS_REAL(1e-9f);
  const rs_real a = rs_abs(n[0]), b = rs_abs(n[1]), c = rs_abs(n[2]);
  const rs_real low = rs_min(a, b), high = rs_max(a, b), other = rs_max(low, c);
  *m1 = rs_max(rs_min(low, c), least);
  *m2 = rs_max(rs_min(other, high), least);
  *m3 = rs_max(other, high);
}

/* Fraction of a unit cube on the outer side of a plane with outward unit normal `n`, when the cube's centre lies
 * `distance` outside. The smaller part is a sum of pyramids (Scardovelli and Zaleski 2000, J. Comput. Phys. 164:228,
 * eq. 16-19), in a form without cancellation where the plane is nearly perpendicular to an axis. */
RS_INLINE rs_real rs_outside_fraction(const rs_real* n, rs_real distance) {
  const rs_real zero = RS_REAL(0.0f), middle = RS_REAL(0.5f);
  rs_real m1, m2, m3;
  rs_sort_components(n, &m1, &m2, &m3);
  /* Of the plane from the nearest corner, half the sum of the components at the centre. */
  const rs_real depth = rs_max(middle * (m1 + m2 + m3) - rs_abs(distance), zero);
  /* One division instead of three. */
  const rs_real m23 = m2 * m3, per_all = RS_REAL(1.0f) / (m1 * m23);
  const rs_real per_m1 = per_all * m23, per_6m23 = per_all * m1 * RS_REAL(1.0f / 6.0f);
  const rs_real over2 = rs_max(depth - m2, zero), over3 = rs_max(depth - m3, zero);
  const rs_real pyramid = depth * depth * depth * per_m1;
  const rs_real frustum = 3.0f * depth * (depth - m1) + m1 * m1;
  const rs_real corners = (over2 * over2 * over2 + over3 * over3 * over3) * per_m1;
  const rs_real skew = ((depth < m1 ? pyramid : frustum) - corners) * per_6m23;
  const rs_real slab = (depth - middle * (m1 + m2)) * (per_all * (m1 * m2));
  const rs_real smaller = m1 + m2 <= rs_min(depth, m3) ? slab : skew;
  return distance > 0.0f ? RS_REAL(1.0f) - smaller : smaller;
}

/* A plane next to a voxel: unit normal in lattice axes, distance of the voxel's centre outside it (`away`, voxels), and
 * component of the normal along the spin axis (`nz`). */
typedef struct {
  rs_real n[3];
  rs_real away;
  rs_real nz;
} ClipPlane;

/* Sample points along each side of a cube. */
#define RS_CLIP_POINTS 4
RS_INLINE float rs_clip_point(rs_i32 i) {
  return ((float)i + 0.5f) * (1.0f / RS_CLIP_POINTS) - 0.5f;
}

/* Fraction of a unit cube outside both of two planes, sampled at RS_CLIP_POINTS^3 points. A point within half a spacing
 * of a plane counts in part. The joint fraction of a point is the product for perpendicular planes, the smaller one for
 * parallel planes, and the excess of the sum over 1 for opposite ones; other angles interpolate by the cosine. */
RS_INLINE rs_real rs_outside_both(const ClipPlane* a, const ClipPlane* b) {
  const float spacing = 1.0f / RS_CLIP_POINTS;
  const rs_real zero = RS_REAL(0.0f), one = RS_REAL(1.0f), middle = RS_REAL(0.5f);
  const rs_real per_a = (float)RS_CLIP_POINTS / (rs_abs(a->n[0]) + rs_abs(a->n[1]) + rs_abs(a->n[2]));
  const rs_real per_b = (float)RS_CLIP_POINTS / (rs_abs(b->n[0]) + rs_abs(b->n[1]) + rs_abs(b->n[2]));
  const rs_real cosine = a->n[0] * b->n[0] + a->n[1] * b->n[1] + a->n[2] * b->n[2];
  const rs_real parallel = rs_max(cosine, zero), opposed = rs_max(-cosine, zero);
  rs_real sum = zero;
  for (int i = 0; i < RS_CLIP_POINTS * RS_CLIP_POINTS; ++i) {
    const float y = rs_clip_point(i / RS_CLIP_POINTS), z = rs_clip_point(i % RS_CLIP_POINTS);
    const rs_real row_a = a->away + a->n[1] * y + a->n[2] * z, row_b = b->away + b->n[1] * y + b->n[2] * z;
    for (int k = 0; k < RS_CLIP_POINTS; ++k) {
      const float x = rs_clip_point(k);
      const rs_real beyond_a = rs_max(rs_min((row_a + a->n[0] * x) * per_a + middle, one), zero);
      const rs_real beyond_b = rs_max(rs_min((row_b + b->n[0] * x) * per_b + middle, one), zero);
      const rs_real product = beyond_a * beyond_b;
      const rs_real more = rs_min(beyond_a, beyond_b) - product;
      const rs_real less = product - rs_max(beyond_a + beyond_b - one, zero);
      sum += product + (parallel * more - opposed * less);
    }
  }
  return sum * (spacing * spacing * spacing);
}

#endif
