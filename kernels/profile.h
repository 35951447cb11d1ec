/* The tool's profile: the polygon in (r, z) of T of its envelope of revolution. The same code serves the host, a single
 * work-item, and sixteen voxels in the lanes of a vector (RS_LANES 16): the same operations in the same order, and so
 * the same bits. */
#ifndef REAMSIM_KERNELS_PROFILE_H
#define REAMSIM_KERNELS_PROFILE_H

#include "shared.h"
#ifndef __OPENCL_C_VERSION__
#include <string.h>
#endif

#if defined(RS_LANES) && RS_LANES == 16
typedef float16 rs_real;
typedef int16 rs_int;
typedef long16 rs_sum;
#define RS_TO_SUM(value) convert_long16(value)
#define RS_TO_INT(value) convert_int16(value)
#define RS_TO_REAL(value) convert_float16(value)
#define RS_BITS_OF(real) as_int16(real)
#define RS_REAL_OF(bits) as_float16(bits)
#define RS_ANY(condition) any(condition)
#else
typedef float rs_real;
typedef rs_i32 rs_int;
typedef rs_i64 rs_sum;
#define RS_ANY(condition) (condition)
#define RS_TO_SUM(value) ((rs_i64)(value))
#define RS_TO_INT(value) ((rs_i32)(value))
#define RS_TO_REAL(value) ((float)(value))
#ifdef __OPENCL_C_VERSION__
#define RS_BITS_OF(real) as_int(real)
#define RS_REAL_OF(bits) as_float(bits)
#else
RS_INLINE rs_i32 rs_bits_of(float real) {
  rs_i32 bits;
  memcpy(&bits, &real, sizeof bits);
  return bits;
}
RS_INLINE float rs_real_of(rs_i32 bits) {
  float real;
  memcpy(&real, &bits, sizeof real);
  return real;
}
#define RS_BITS_OF(real) rs_bits_of(real)
#define RS_REAL_OF(bits) rs_real_of(bits)
#endif
#endif

/* An edge of the tool's profile in (r, z) of T, mm: from (r0, z0) along (along_r, along_z), with 1/length^2 and its
 * outward unit normal. */
typedef struct {
  float r0, z0, along_r, along_z;
  float r1, z1; /* exactly the next edge's r0 and z0 */
  float inverse_length2;
  float normal_r, normal_z;
} ProfileEdge;

/* A grid of square cells over (r, z), each with an ascending list of the edges that can be nearest to a point within
 * the grid's reach of the cell. Cells far from the profile, and points off the grid, use list 0 of all edges. */
typedef struct {
  float z0; /* mm; r begins at 0 */
  float per_mm;
  rs_i32 count_r, count_z;
} ProfileGrid;

typedef struct {
  rs_u32 first; /* into the array of edge numbers */
  rs_u32 count;
} EdgeList;

/* The tool's profile in device memory. */
typedef struct {
  RS_GLOBAL const ProfileEdge* edges;
  RS_GLOBAL const rs_u16* numbers; /* of edges, list after list */
  RS_GLOBAL const EdgeList* lists; /* [1 + count_r * count_z]; cell (r, z) has list 1 + r + count_r * z */
  RS_GLOBAL const ProfileGrid* grid;
} ProfileView;

/* The list for points within the grid's reach of (r, z). */
RS_INLINE EdgeList rs_list_of_cell(RS_GLOBAL const ProfileGrid* g, RS_GLOBAL const EdgeList* lists, float r, float z) {
  const float cr = r * g->per_mm, cz = (z - g->z0) * g->per_mm;
  if (!(cr < (float)g->count_r && cz >= 0 && cz < (float)g->count_z)) return lists[0];
  return lists[1 + (rs_i32)cr + g->count_r * (rs_i32)cz];
}

RS_INLINE EdgeList rs_edges_near(const ProfileView* profile, float r, float z) {
  return rs_list_of_cell(profile->grid, profile->lists, r, z);
}

/* The nearest surface of a point: signed distance, mm, negative inside, and outward unit normal. */
typedef struct {
  rs_real distance;
  rs_real normal_r, normal_z;
} Nearest;

/* The nearest surface of (r, z), of the edges in `list`. The normal is the gradient of the distance, and exactly the
 * edge's own beside an edge. Of two edges that share the nearest vertex, the more perpendicular one decides the sign.
 */
RS_INLINE Nearest rs_profile_nearest(const ProfileView* profile, EdgeList list, rs_real r, rs_real z) {
  const rs_real zero = (rs_real)0.0f, one = (rs_real)1.0f;
  rs_real best = (rs_real)1e30f, best_side = zero, beside = zero, dr = zero, dz = zero, nr = zero, nz = -one;
  for (rs_u32 i = 0; i < list.count; ++i) {
    RS_GLOBAL const ProfileEdge* e = profile->edges + profile->numbers[list.first + i];
    const rs_real vr = r - e->r0, vz = z - e->z0;
    const rs_real along = (vr * e->along_r + vz * e->along_z) * e->inverse_length2;
    rs_real t = along > 0.0f ? along : zero;
    t = t < 1.0f ? t : one;
    /* Measured from the shared vertex, so that two edges tie. */
    const rs_real pr = t < 1.0f ? vr - t * e->along_r : r - e->r1, pz = t < 1.0f ? vz - t * e->along_z : z - e->z1;
    const rs_real d2 = pr * pr + pz * pz;
    const rs_real side = pr * e->normal_r + pz * e->normal_z;
    const rs_real abs_side = side < 0.0f ? -side : side, abs_best = best_side < 0.0f ? -best_side : best_side;
    /* Edges equally near up to rounding tie. Without `&&`, which differs between scalars and lanes. */
    const rs_real rounding = best * 2e-6f + 1e-10f;
    const rs_real tie = d2 <= best + rounding ? abs_side - abs_best : -one;
    const rs_real gain = d2 < best - rounding ? one : tie;
    best = gain > 0.0f ? d2 : best;
    best_side = gain > 0.0f ? side : best_side;
    beside = gain > 0.0f ? (t == along ? one : zero) : beside;
    dr = gain > 0.0f ? pr : dr;
    dz = gain > 0.0f ? pz : dz;
    nr = gain > 0.0f ? (rs_real)e->normal_r : nr;
    nz = gain > 0.0f ? (rs_real)e->normal_z : nz;
  }
  /* At a vertex the direction is undefined; the edge's normal replaces it. */
  beside = best > 1e-12f ? beside : one;
  const rs_real sign = best_side < 0.0f ? -one : one, root = RS_SQRT(best);
  const rs_real signed_inverse = sign / root;
  Nearest out;
  out.distance = beside > 0.0f ? best_side : sign * root;
  out.normal_r = beside > 0.0f ? nr : dr * signed_inverse;
  out.normal_z = beside > 0.0f ? nz : dz * signed_inverse;
  return out;
}

/* The nearest surface of `p` (T, mm), of the edges in `list`, and its outward unit normal in T, which has no radial
 * part on the spin axis. */
RS_INLINE Nearest rs_tool_nearest(const ProfileView* profile, EdgeList list, const rs_real* p, rs_real* normal) {
  const rs_real r = RS_SQRT(p[0] * p[0] + p[1] * p[1]);
  const Nearest nearest = rs_profile_nearest(profile, list, r, p[2]);
  const rs_real radial = r > 0.0f ? nearest.normal_r / r : (rs_real)0.0f;
  normal[0] = radial * p[0];
  normal[1] = radial * p[1];
  normal[2] = nearest.normal_z;
  return nearest;
}

#if !defined(RS_LANES)
/* Whether (r, z), r >= 0, lies in the profile's polygon or on it: counts the edges that a ray towards larger r crosses.
 * Edges on the axis are not in the list; the ray never crosses them. */
RS_INLINE int rs_inside_profile(const ProfileView* profile, float r, float z) {
  int inside = 0;
  const rs_i32 count = (rs_i32)profile->lists[0].count;
  for (rs_i32 i = 0; i < count; ++i) {
    RS_GLOBAL const ProfileEdge* e = profile->edges + i;
    const float r0 = e->r0, r1 = e->r1, z0 = e->z0, z1 = e->z1;
    if ((z < z0 && z < z1) || (z > z0 && z > z1)) continue;
    const float side = (r - r0) * e->normal_r + (z - z0) * e->normal_z;
    const int beside = (r < r0 && r < r1) || (r > r0 && r > r1);
    if (side == 0 && !beside) return 1;
    /* Half-open in z, so that a ray through a vertex counts one of its two edges. An ascending edge has its outward
     * normal towards larger r. */
    if ((z0 <= z) != (z1 <= z) && (z1 > z0 ? side < 0 : side > 0)) inside = !inside;
  }
  return inside;
}

#endif

#endif
