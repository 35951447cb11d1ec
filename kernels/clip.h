/* Exact erosion: a voxel keeps the part of it that lies outside the tool, as the tool's local plane cuts it (design
 * §4). */
#ifndef REAMSIM_KERNELS_CLIP_H
#define REAMSIM_KERNELS_CLIP_H

#ifndef REAMSIM_KERNELS_CUT_LAW_H
#include "cut_law.h"
#endif

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
RS_INLINE rs_real rs_outside_share(const rs_real* n, rs_real distance) {
  const rs_real zero = (rs_real)0.0f, middle = (rs_real)0.5f, least = (rs_real)1e-9f;
  const rs_real a = rs_abs(n[0]), b = rs_abs(n[1]), c = rs_abs(n[2]);
  const rs_real per_sum = (rs_real)1.0f / (a + b + c);
  const rs_real low = rs_smaller(a, b), high = rs_larger(a, b), other = rs_larger(low, c);
  /* Components in ascending order, their sum 1; `depth` of the plane in the nearest corner, 1/2 through the centre. */
  const rs_real m1 = rs_larger(rs_smaller(low, c) * per_sum, least);
  const rs_real m2 = rs_larger(rs_smaller(other, high) * per_sum, least);
  const rs_real m3 = rs_larger(other, high) * per_sum;
  const rs_real depth = rs_larger(middle - rs_abs(distance) * per_sum, zero);
  const rs_real per_6m23 = middle / (3.0f * m2 * m3), per_m1 = (rs_real)1.0f / m1;
  const rs_real over2 = rs_larger(depth - m2, zero), over3 = rs_larger(depth - m3, zero);
  const rs_real pyramid = depth * depth * depth * per_m1;
  const rs_real frustum = 3.0f * depth * (depth - m1) + m1 * m1;
  const rs_real corners = (over2 * over2 * over2 + over3 * over3 * over3) * per_m1;
  const rs_real skew = ((depth < m1 ? pyramid : frustum) - corners) * per_6m23;
  const rs_real slab = (depth - middle * (m1 + m2)) / m3;
  const rs_real smaller = m1 + m2 <= rs_smaller(depth, m3) ? slab : skew;
  return distance > 0.0f ? (rs_real)1.0f - smaller : smaller;
}

/* A voxel against the tool: its centre and the tool's outward normal there (T, mm), how far the surface is (mm,
 * negative inside), and its curvature, both directions together (1/mm, positive where it bulges). */
typedef struct {
  rs_real p[3];
  rs_real n[3];
  rs_real distance;
  rs_real curvature;
} Clip;

/* The voxel (x, y, z), counted within its brick, whose lowest voxel's centre is `brick` in T. */
RS_INLINE Clip rs_clip(RS_GLOBAL const SubstepArgs* a, const ProfileView* profile, EdgeList list, const float* brick,
                       rs_real x, rs_real y, rs_real z) {
  Clip clip;
  rs_voxel_in_tool(a, brick, x, y, z, clip.p);
  const Nearest nearest = rs_tool_nearest(profile, list, clip.p, clip.n);
  clip.distance = nearest.distance;
  /* Round the axis a surface turns with its radius, which means nothing where that is smaller than a voxel. */
  const rs_real r = RS_SQRT(clip.p[0] * clip.p[0] + clip.p[1] * clip.p[1]) - nearest.distance * nearest.normal_r;
  const rs_real most = (rs_real)a->per_voxel_mm; /* more is a corner */
  const rs_real curvature = nearest.curvature + nearest.normal_r / rs_larger(r, (rs_real)(0.5f * a->voxel_mm));
  clip.curvature = rs_larger(rs_smaller(curvature, most), -most);
  return clip;
}

/* The tool's plane next to a voxel: its normal `n` along the lattice's axes, and how far the voxel's centre lies
 * outside it, voxels. A bulging surface falls away from its plane: by t^2/2 times the curvature at t from the point of
 * contact, in the mean over a voxel by h^2/24 in each direction. */
RS_INLINE rs_real rs_clip_plane(RS_GLOBAL const SubstepArgs* a, const Clip* clip, rs_real* n) {
  for (int j = 0; j < 3; ++j)
    n[j] = (clip->n[0] * (float)a->tool_from_voxel[j] + clip->n[1] * (float)a->tool_from_voxel[3 + j] +
            clip->n[2] * (float)a->tool_from_voxel[6 + j]) *
           a->per_voxel_mm;
  return clip->distance * a->per_voxel_mm + clip->curvature * (a->voxel_mm * (1.0f / 24.0f));
}

/* Fill that is left of a whole voxel. */
RS_INLINE rs_int rs_fill_outside(RS_GLOBAL const SubstepArgs* a, const Clip* clip) {
  rs_real n[3];
  const rs_real away = rs_clip_plane(a, clip, n);
  return RS_TO_INT(rs_outside_share(n, away) * (float)RS_WHOLE_FILL + 0.5f);
}

/* Fill that a voxel with `fill` left loses when the tool leaves `outside` of it: what little the rounding of positions
 * could make stays, unless nothing is left. */
RS_INLINE rs_int rs_clip_loss(RS_GLOBAL const SubstepArgs* a, rs_int fill, rs_int outside) {
  const rs_int lost = fill - outside;
  const rs_int enough = outside == 0 ? (rs_int)1 : (rs_int)a->least_loss;
  return lost >= enough ? lost : (rs_int)0;
}

/* What a voxel that loses `lost` of its fill does to the tool, when the whole of it takes `whole` mJ. */
RS_INLINE void rs_clip_force(RS_GLOBAL const SubstepArgs* a, const Clip* clip, rs_real whole, rs_int lost,
                             LaneSums* sums) {
  if (a->law == RS_LAW_NONE) return;
  const rs_real energy = whole * (RS_TO_REAL(lost) * (1.0f / (float)RS_WHOLE_FILL));
  sums->energy += RS_TO_SUM(energy * (float)RS_ENERGY_SCALE);
  rs_cut_force(a, clip->n, clip->p, energy, sums);
}

/* How far the tool is advanced to see what bone it rests against, voxels. */
#define RS_EDGE_PROBE (1.0f / 64.0f)

/* Where the tool's normal points less than this towards the bone (-z of T), the surface is its side or its back, and
 * has no lips. */
#define RS_LEAST_FACING 0.01f

/* Area, mm2, of the tool's face that rests against what is left of a voxel: what the face would take if it went a
 * little further, over how far that is. Over the voxels round a face it adds up to the face, because their outside
 * shares do. `left`: the voxel's fill, `outside`: what the tool leaves of a whole voxel. */
RS_INLINE rs_real rs_resting_area(RS_GLOBAL const SubstepArgs* a, const Clip* clip, rs_int left, rs_int outside) {
  const rs_real zero = (rs_real)0.0f;
  rs_real n[3];
  const rs_real away = rs_clip_plane(a, clip, n);
  const rs_real share = rs_outside_share(n, away) - rs_outside_share(n, away - RS_EDGE_PROBE);
  const rs_real area = share * (a->voxel_mm * a->voxel_mm / RS_EDGE_PROBE);
  const rs_real met = clip->distance <= RS_CLIP_REACH * a->voxel_mm ? area : zero;
  const rs_real faced = -clip->n[2] > RS_LEAST_FACING ? met : zero;
  const rs_real touched = left + a->least_loss >= outside ? faced : zero;
  return left > 0 ? touched : zero;
}

RS_INLINE int rs_has_edge(RS_GLOBAL const SubstepArgs* a) {
  return a->edge_tangential > 0.0f && a->law == RS_LAW_ENERGY;
}

/* Force of the lips' edges on the tool where it rests against a voxel. A surface of revolution that `lips` lips sweep
 * carries lips/(2·pi·r) mm of lip per mm2. It takes no speed floor, because it does not grow where the tool is slow. */
RS_INLINE void rs_edge_force(RS_GLOBAL const SubstepArgs* a, const Clip* clip, rs_int left, rs_int outside,
                             LaneSums* sums) {
  const rs_real zero = (rs_real)0.0f;
  const rs_real r = RS_SQRT(clip->p[0] * clip->p[0] + clip->p[1] * clip->p[1]);
  const rs_real lip = rs_resting_area(a, clip, left, outside) / rs_larger(r, (rs_real)(0.5f * a->voxel_mm));
  const ToolMotion m = rs_tool_motion(a, clip->p);
  const rs_real engaged = m.speed > 0.0f ? lip : zero;
  const rs_real tangential = engaged * a->edge_tangential;
  sums->energy += RS_TO_SUM(tangential * (m.speed * a->duration) * (float)RS_ENERGY_SCALE);
  rs_add_resistance(&m, clip->n, clip->p, tangential, engaged * a->edge_normal, sums);
}

#endif
