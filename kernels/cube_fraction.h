/* How much of a unit cube lies beyond a plane, and beyond two. */
#ifndef REAMSIM_KERNELS_CUBE_FRACTION_H
#define REAMSIM_KERNELS_CUBE_FRACTION_H

#include "profile.h"

/* A surface farther from a voxel's centre does not meet it, voxels: half a diagonal, and what its curvature counts for.
 */
#define RS_CLIP_REACH (0.8660254f + 1.0f / 24.0f)

RS_INLINE rs_real rs_abs(rs_real x) {
  return x < 0.0f ? -x : x;
}
RS_INLINE rs_real rs_smaller(rs_real a, rs_real b) {
  return a < b ? a : b;
}
RS_INLINE rs_real rs_larger(rs_real a, rs_real b) {
  return a < b ? b : a;
}

/* Part of a unit cube that a plane with unit normal `n` leaves on the side to which n points, when the cube's centre
 * lies `distance` beyond it on that side. The smaller part is a sum of pyramids (Scardovelli and Zaleski 2000, J.
 * Comput. Phys. 164:228, eq. 16-19), written so that no term cancels another where the plane is all but square to an
 * axis. */
RS_INLINE rs_real rs_outside_fraction(const rs_real* n, rs_real distance) {
  const rs_real zero = (rs_real)0.0f, middle = (rs_real)0.5f, least = (rs_real)1e-9f;
  const rs_real a = rs_abs(n[0]), b = rs_abs(n[1]), c = rs_abs(n[2]);
  const rs_real low = rs_smaller(a, b), high = rs_larger(a, b), other = rs_larger(low, c);
  /* Components in ascending order; `depth` of the plane in the nearest corner, half their sum through the centre. */
  const rs_real m1 = rs_larger(rs_smaller(low, c), least);
  const rs_real m2 = rs_larger(rs_smaller(other, high), least);
  const rs_real m3 = rs_larger(other, high);
  const rs_real depth = rs_larger(middle * (m1 + m2 + m3) - rs_abs(distance), zero);
  /* One division for three. */
  const rs_real m23 = m2 * m3, per_all = (rs_real)1.0f / (m1 * m23);
  const rs_real per_m1 = per_all * m23, per_6m23 = per_all * m1 * (rs_real)(1.0f / 6.0f);
  const rs_real over2 = rs_larger(depth - m2, zero), over3 = rs_larger(depth - m3, zero);
  const rs_real pyramid = depth * depth * depth * per_m1;
  const rs_real frustum = 3.0f * depth * (depth - m1) + m1 * m1;
  const rs_real corners = (over2 * over2 * over2 + over3 * over3 * over3) * per_m1;
  const rs_real skew = ((depth < m1 ? pyramid : frustum) - corners) * per_6m23;
  const rs_real slab = (depth - middle * (m1 + m2)) * (per_all * (m1 * m2));
  const rs_real smaller = m1 + m2 <= rs_smaller(depth, m3) ? slab : skew;
  return distance > 0.0f ? (rs_real)1.0f - smaller : smaller;
}

/* A plane next to a voxel: its unit normal along the lattice's axes, and how far the voxel's centre lies beyond it,
 * voxels; `nz` its normal's part along the spin axis. */
typedef struct {
  rs_real n[3];
  rs_real away;
  rs_real nz;
} ClipPlane;

/* Points along each side of a cube. */
#define RS_CLIP_POINTS 4
RS_INLINE float rs_clip_point(rs_i32 i) {
  return ((float)i + 0.5f) * (1.0f / RS_CLIP_POINTS) - 0.5f;
}

/* Part of a unit cube that lies beyond both of two planes, by counting RS_CLIP_POINTS^3 points, a point that has a
 * plane within half a spacing in part. Of such parts to two planes at right angles the product lies beyond both, to
 * parallel ones the smaller, to opposite ones what exceeds the whole; at other angles something between by their
 * cosine. */
RS_INLINE rs_real rs_outside_both(const ClipPlane* a, const ClipPlane* b) {
  const float spacing = 1.0f / RS_CLIP_POINTS;
  const rs_real zero = (rs_real)0.0f, one = (rs_real)1.0f, middle = (rs_real)0.5f;
  const rs_real per_a = (float)RS_CLIP_POINTS / (rs_abs(a->n[0]) + rs_abs(a->n[1]) + rs_abs(a->n[2]));
  const rs_real per_b = (float)RS_CLIP_POINTS / (rs_abs(b->n[0]) + rs_abs(b->n[1]) + rs_abs(b->n[2]));
  const rs_real cosine = a->n[0] * b->n[0] + a->n[1] * b->n[1] + a->n[2] * b->n[2];
  const rs_real alike = rs_larger(cosine, zero), opposed = rs_larger(-cosine, zero);
  rs_real sum = zero;
  for (int i = 0; i < RS_CLIP_POINTS * RS_CLIP_POINTS; ++i) {
    const float y = rs_clip_point(i / RS_CLIP_POINTS), z = rs_clip_point(i % RS_CLIP_POINTS);
    const rs_real row_a = a->away + a->n[1] * y + a->n[2] * z, row_b = b->away + b->n[1] * y + b->n[2] * z;
    for (int k = 0; k < RS_CLIP_POINTS; ++k) {
      const float x = rs_clip_point(k);
      const rs_real beyond_a = rs_larger(rs_smaller((row_a + a->n[0] * x) * per_a + middle, one), zero);
      const rs_real beyond_b = rs_larger(rs_smaller((row_b + b->n[0] * x) * per_b + middle, one), zero);
      const rs_real product = beyond_a * beyond_b;
      const rs_real more = rs_smaller(beyond_a, beyond_b) - product;
      const rs_real less = product - rs_larger(beyond_a + beyond_b - one, zero);
      sum += product + (alike * more - opposed * less);
    }
  }
  return sum * (spacing * spacing * spacing);
}

#endif
