/* Types and arithmetic that the host and the kernels share. Plain C, compiled by the C++ compiler and by every OpenCL C
 * compiler, so that the serial engine and the devices compute the same bits: positions are fixed-point integers, sums
 * are 64-bit integers, and the doubles in between use only operations that IEEE 754 rounds correctly (no contraction).
 */
#ifndef REAMSIM_KERNELS_SHARED_H
#define REAMSIM_KERNELS_SHARED_H

#ifdef __OPENCL_C_VERSION__
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#pragma OPENCL FP_CONTRACT OFF
typedef long rs_i64;
typedef int rs_i32;
typedef uint rs_u32;
#define RS_GLOBAL __global
#define RS_INLINE static inline
#define RS_SQRT sqrt
#define RS_FLOOR floor
#else
#include <math.h>
#include <stdint.h>
typedef int64_t rs_i64;
typedef int32_t rs_i32;
typedef uint32_t rs_u32;
#define RS_GLOBAL
#define RS_INLINE static inline
#define RS_SQRT sqrt
#define RS_FLOOR floor
#endif

/* Fractional bits of a position in voxels. Over 1024 shell cells the rounding of the rotation adds up to 2^-15 voxel.
 */
#define RS_POSITION_BITS 24

/* Least significant digits of the integer sums: N, N·mm, mJ. Room for 3·10^10 N, 5·10^11 N·mm, 2·10^9 mJ a substep. */
#define RS_FORCE_SCALE 268435456.0   /* 2^28 */
#define RS_TORQUE_SCALE 16777216.0   /* 2^24 */
#define RS_ENERGY_SCALE 4294967296.0 /* 2^32 */

#define RS_WHOLE_FILL 65535

#define RS_LAW_ENERGY 0
#define RS_LAW_PER_POINT 1
#define RS_EROSION_REMOVE 0
#define RS_EROSION_WEAR 1

/* Everything that the stages of one substep need to know; written to the device in one piece before detect (paper
 * §3.5). Lengths in mm, frame B unless said otherwise. */
typedef struct {
  rs_i64 voxel_from_cell[9];  /* row-major, fixed point: shell cell step to voxels */
  rs_i64 voxel_origin[3];     /* fixed point: centre of shell cell (0,0,0), in voxels from the lattice's corner */
  double tool_from_bone[9];   /* row-major rotation */
  double lattice_origin[3];   /* corner of voxel (0,0,0), relative to the tool's origin */
  double origin_velocity[3];  /* of the tool's origin, mm/s */
  double angular_velocity[3]; /* spin and tilt, rad/s */
  double voxel_mm;
  double duration_s;
  double speed_floor;     /* mm/s */
  double normal_ratio;    /* k_n */
  double force_per_point; /* N, law per_point */
  double wear;            /* g/cm3 that a touched voxel loses in this substep */
  double cell_mm;         /* of the shell */
  double shell_origin[3]; /* corner of shell cell (0,0,0), tool frame T turned by the spin angle */
  double shell_turn[2];   /* cosine and sine of the turn that takes shell to T */
  rs_i32 dims[3];
  rs_i32 voi_min[3]; /* shell cells, inclusive */
  rs_i32 voi_max[3];
  rs_i32 law;
  rs_i32 erosion;
  rs_i32 frame;
} SubstepArgs;

/* Integer sums over the voxels of one substep. Force and torque act on the tool, torque about its origin, in B. */
typedef struct {
  rs_i64 force[3];
  rs_i64 torque[3];
  rs_i64 energy;
  rs_i64 floor_energy;
  rs_i64 removed;  /* fill units: 65535 = one voxel */
  rs_i64 contacts; /* voxels */
} SubstepSums;

/* An edge of the tool's profile in (r, z) of T, mm, with its outward unit normal. */
typedef struct {
  double r0, z0, r1, z1;
  double normal_r, normal_z;
} ProfileEdge;

/* ---- Morton codes: 10 bits per axis, x in bit 0 (paper §3.3) -------------------------------------------------------
 */

RS_INLINE rs_i32 rs_compact_bits(rs_u32 code) {
  code &= 0x09249249u;
  code = (code ^ (code >> 2)) & 0x030c30c3u;
  code = (code ^ (code >> 4)) & 0x0300f00fu;
  code = (code ^ (code >> 8)) & 0xff0000ffu;
  code = (code ^ (code >> 16)) & 0x000003ffu;
  return (rs_i32)code;
}

/* ---- Detect: where a shell point lies
 * -------------------------------------------------------------------------------- */

/* Voxel coordinate along `axis` of the centre of shell cell (x, y, z). */
RS_INLINE rs_i32 rs_voxel_coordinate(RS_GLOBAL const SubstepArgs* a, int axis, rs_i32 x, rs_i32 y, rs_i32 z) {
  RS_GLOBAL const rs_i64* row = a->voxel_from_cell + 3 * axis;
  return (rs_i32)((a->voxel_origin[axis] + row[0] * x + row[1] * y + row[2] * z) >> RS_POSITION_BITS);
}

RS_INLINE int rs_in_voi(RS_GLOBAL const SubstepArgs* a, rs_i32 x, rs_i32 y, rs_i32 z) {
  return x >= a->voi_min[0] && x <= a->voi_max[0] && y >= a->voi_min[1] && y <= a->voi_max[1] && z >= a->voi_min[2] &&
         z <= a->voi_max[2];
}

/* ---- The profile's outward normal
 * ------------------------------------------------------------------------------------ */

typedef struct {
  double r, z;
} RsNormal;

/* Outward unit normal (n_r, n_z) at the profile's point nearest to (r, z): the gradient of the signed distance there,
 * or the edge's normal on the surface itself. Of two edges that share the nearest vertex the one seen more squarely
 * decides the sign. */
RS_INLINE RsNormal rs_profile_normal(RS_GLOBAL const ProfileEdge* edges, rs_i32 count, double r, double z) {
  double best = 1e300, best_side = 0, dr = 0, dz = 0;
  RsNormal normal;
  normal.r = 0;
  normal.z = -1;
  for (rs_i32 i = 0; i < count; ++i) {
    const double er = edges[i].r1 - edges[i].r0, ez = edges[i].z1 - edges[i].z0;
    const double t = ((r - edges[i].r0) * er + (z - edges[i].z0) * ez) / (er * er + ez * ez);
    const double qr = t <= 0 ? edges[i].r0 : t >= 1 ? edges[i].r1 : edges[i].r0 + t * er;
    const double qz = t <= 0 ? edges[i].z0 : t >= 1 ? edges[i].z1 : edges[i].z0 + t * ez;
    const double pr = r - qr, pz = z - qz;
    const double d2 = pr * pr + pz * pz;
    const double side = pr * edges[i].normal_r + pz * edges[i].normal_z;
    const double abs_side = side < 0 ? -side : side, abs_best = best_side < 0 ? -best_side : best_side;
    if (d2 < best || (d2 == best && abs_side > abs_best)) {
      best = d2;
      best_side = side;
      dr = pr;
      dz = pz;
      normal.r = edges[i].normal_r;
      normal.z = edges[i].normal_z;
    }
  }
  if (best > 1e-18) {
    const double d = RS_SQRT(best);
    normal.r = (best_side < 0 ? -dr : dr) / d;
    normal.z = (best_side < 0 ? -dz : dz) / d;
  }
  return normal;
}

/* ---- Cut: what a voxel that loses volume does to the tool (design §5)
 * -------------------------------------------------- */

RS_INLINE rs_i64 rs_quantise(double value, double scale) {
  return (rs_i64)RS_FLOOR(value * scale + 0.5);
}

/* Fill that a touched voxel of density `density` loses: all of it, or what wears off in this substep. */
RS_INLINE rs_i32 rs_lost_fill(RS_GLOBAL const SubstepArgs* a, double density, rs_i32 fill) {
  if (a->erosion == RS_EROSION_REMOVE) return fill;
  const double lost = RS_FLOOR(RS_WHOLE_FILL * a->wear / density + 0.5);
  return lost >= fill ? fill : lost < 1 ? 1 : (rs_i32)lost;
}

/* Adds force `f` (N) at lever `p` (mm, from the tool's origin) to the sums. */
RS_INLINE void rs_add_force(SubstepSums* sums, const double* f, const double* p) {
  for (int i = 0; i < 3; ++i) sums->force[i] += rs_quantise(f[i], RS_FORCE_SCALE);
  sums->torque[0] += rs_quantise(p[1] * f[2] - p[2] * f[1], RS_TORQUE_SCALE);
  sums->torque[1] += rs_quantise(p[2] * f[0] - p[0] * f[2], RS_TORQUE_SCALE);
  sums->torque[2] += rs_quantise(p[0] * f[1] - p[1] * f[0], RS_TORQUE_SCALE);
}

/* The tool's outward normal, in B, at `p` (mm from the tool's origin, B). Zero radial part on the spin axis. */
RS_INLINE void rs_normal_at(RS_GLOBAL const SubstepArgs* a, RS_GLOBAL const ProfileEdge* edges, rs_i32 edge_count,
                            const double* p, double* normal) {
  double t[3];
  for (int i = 0; i < 3; ++i)
    t[i] = a->tool_from_bone[3 * i] * p[0] + a->tool_from_bone[3 * i + 1] * p[1] + a->tool_from_bone[3 * i + 2] * p[2];
  const double r = RS_SQRT(t[0] * t[0] + t[1] * t[1]);
  const RsNormal rz = rs_profile_normal(edges, edge_count, r, t[2]);
  const double x = r > 0 ? rz.r * t[0] / r : 0, y = r > 0 ? rz.r * t[1] / r : 0;
  for (int i = 0; i < 3; ++i)
    normal[i] = a->tool_from_bone[i] * x + a->tool_from_bone[3 + i] * y + a->tool_from_bone[6 + i] * rz.z;
}

/* Force of the energetic law on the tool for a voxel with centre at `p` (mm from the tool's origin, B) whose loss took
 * `energy` mJ: -F_t·v/|v| - k_n·F_t·n_perp with F_t = E/(max(|v|, v_floor)·dt). A voxel on which the tool does not move
 * takes energy but gives no force; all of it is floor energy. */
RS_INLINE void rs_cut_force(RS_GLOBAL const SubstepArgs* a, RS_GLOBAL const ProfileEdge* edges, rs_i32 edge_count,
                            const double* p, double energy, SubstepSums* sums) {
  RS_GLOBAL const double* w = a->angular_velocity;
  const double v[3] = {a->origin_velocity[0] + w[1] * p[2] - w[2] * p[1],
                       a->origin_velocity[1] + w[2] * p[0] - w[0] * p[2],
                       a->origin_velocity[2] + w[0] * p[1] - w[1] * p[0]};
  const double speed = RS_SQRT(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
  const double floored = speed > a->speed_floor ? speed : a->speed_floor;
  sums->energy += rs_quantise(energy, RS_ENERGY_SCALE);
  sums->floor_energy += rs_quantise(energy * (1 - speed / floored), RS_ENERGY_SCALE);
  if (!(speed > 0)) return;
  double n[3], f[3];
  rs_normal_at(a, edges, edge_count, p, n);
  const double tangential = energy / (floored * a->duration_s);
  const double along = (n[0] * v[0] + n[1] * v[1] + n[2] * v[2]) / (speed * speed);
  for (int i = 0; i < 3; ++i)
    f[i] = -tangential * (v[i] / speed) - a->normal_ratio * tangential * (n[i] - along * v[i]);
  rs_add_force(sums, f, p);
}

/* Centre of voxel (x, y, z), mm from the tool's origin, B. */
RS_INLINE void rs_voxel_lever(RS_GLOBAL const SubstepArgs* a, rs_i32 x, rs_i32 y, rs_i32 z, double* p) {
  p[0] = a->lattice_origin[0] + (x + 0.5) * a->voxel_mm;
  p[1] = a->lattice_origin[1] + (y + 0.5) * a->voxel_mm;
  p[2] = a->lattice_origin[2] + (z + 0.5) * a->voxel_mm;
}

/* The paper's way: each touching point pushes the tool back along its inward normal with a given elemental force. */
RS_INLINE void rs_point_force(RS_GLOBAL const SubstepArgs* a, RS_GLOBAL const ProfileEdge* edges, rs_i32 edge_count,
                              rs_i32 x, rs_i32 y, rs_i32 z, SubstepSums* sums) {
  const double sx = a->shell_origin[0] + (x + 0.5) * a->cell_mm, sy = a->shell_origin[1] + (y + 0.5) * a->cell_mm;
  const double t[3] = {a->shell_turn[0] * sx - a->shell_turn[1] * sy, a->shell_turn[1] * sx + a->shell_turn[0] * sy,
                       a->shell_origin[2] + (z + 0.5) * a->cell_mm};
  double p[3], n[3], f[3];
  for (int i = 0; i < 3; ++i)
    p[i] = a->tool_from_bone[i] * t[0] + a->tool_from_bone[3 + i] * t[1] + a->tool_from_bone[6 + i] * t[2];
  rs_normal_at(a, edges, edge_count, p, n);
  for (int i = 0; i < 3; ++i) f[i] = -a->force_per_point * n[i];
  rs_add_force(sums, f, p);
}

/* ---- The published methods of `reamsim bench` (kernels/published_*.cl), which the engines do not use ----------------
 */

/* Least significant digit of the published atomic sums: the paper's large N. Forces there are in units of the elemental
 * force. */
#define RS_PUBLISHED_SCALE 1048576.0f /* 2^20 */

/* Sums and arguments of one published frame, which travel in one buffer (paper §3.5). Lengths in shell cells, voxel
 * coordinates in voxels; bone is a cube. */
typedef struct {
  rs_i64 force[3]; /* on the tool, in B */
  rs_i64 contacts; /* points; counted where count_contacts is set */
  float voxel_from_cell[9];
  float voxel_origin[3]; /* centre of shell cell (0,0,0) */
  float cap_center[3];   /* of the tool's sphere; elemental forces point towards it */
  float unused;          /* keeps the size a multiple of 8 */
  rs_i32 voi_min[3];
  rs_i32 voi_max[3];
  rs_i32 side;
  rs_i32 count_contacts;
} PublishedFrame;

#endif
