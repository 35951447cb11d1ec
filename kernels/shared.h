/* Types and arithmetic that the host and the kernels share. Plain C, compiled by the C++ compiler and by every OpenCL C
 * compiler, so that the serial engine and the devices compute the same bits: positions are fixed-point integers, sums
 * are 64-bit integers, and the floats in between use only operations that are correctly rounded (no contraction). The
 * cutting law is in single precision, which every GPU is fast in; its sums are exact.
 */
#ifndef REAMSIM_KERNELS_SHARED_H
#define REAMSIM_KERNELS_SHARED_H

#ifdef __OPENCL_C_VERSION__
#pragma OPENCL EXTENSION cl_khr_fp64 : enable
#pragma OPENCL FP_CONTRACT OFF
typedef long rs_i64;
typedef int rs_i32;
typedef uint rs_u32;
typedef ulong rs_u64;
typedef ushort rs_u16;
typedef uchar rs_u8;
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
typedef uint64_t rs_u64;
typedef uint16_t rs_u16;
typedef uint8_t rs_u8;
#define RS_GLOBAL
#define RS_INLINE static inline
#define RS_SQRT sqrt
#define RS_FLOOR floor
#endif

/* The cutting law is written once and compiled for one voxel at a time, or for sixteen in the lanes of a vector where a
 * kernel defines RS_LANES 16: the same operations in the same order, so the same bits. */
#if defined(RS_LANES) && RS_LANES == 16
typedef float16 rs_real;
typedef long16 rs_sum;
#define RS_TO_SUM(value) convert_long16(value)
#else
typedef float rs_real;
typedef rs_i64 rs_sum;
#define RS_TO_SUM(value) ((rs_i64)(value))
#endif

/* Fractional bits of a position in voxels. The rounding of the rotation adds up to 2^-15 voxel per shell axis of 1024
 * cells, to 2^-13 per axis of 4096, the largest; over three axes and with the origin's, to less than 2^-11. */
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
 * §3.5). Lengths in mm; velocities and levers in the tool frame T without spin, so that the law needs one rotation. */
typedef struct {
  rs_i64 voxel_from_cell[9];  /* row-major, fixed point: shell cell step to voxels */
  rs_i64 voxel_origin[3];     /* fixed point: centre of shell cell (0,0,0), in voxels from the lattice's corner */
  double tool_from_voxel[9];  /* row-major: voxel step to mm in T */
  double tool_origin[3];      /* centre of voxel (0,0,0), T */
  double shell_origin[3];     /* corner of shell cell (0,0,0), shell frame */
  double cell_mm;             /* of the shell */
  double wear;                /* g/cm3 that a touched voxel loses in this substep */
  float origin_velocity[3];   /* of the tool's origin, mm/s, T */
  float angular_velocity[3];  /* spin and tilt, rad/s, T */
  float speed_floor;          /* mm/s */
  float per_speed_floor;      /* s/mm */
  float per_duration;         /* 1/s */
  float floor_rate;           /* 1/(speed floor * duration), 1/mm */
  float normal_ratio;         /* k_n */
  float force_per_point;      /* N, law per_point */
  rs_i32 dims[3];
  rs_i32 voi_min[3]; /* shell cells, inclusive */
  rs_i32 voi_max[3];
  rs_i32 law;
  rs_i32 erosion;
  rs_i32 frame;
} SubstepArgs;

/* Integer sums over the voxels of one substep. Force and torque act on the tool, torque about its origin; law energy:
 * in T without spin; law per_point: in the shell's frame, which turns with the teeth where they are resolved. */
typedef struct {
  rs_i64 force[3];
  rs_i64 torque[3];
  rs_i64 energy;
  rs_i64 floor_energy;
  rs_i64 removed;  /* fill units: 65535 = one voxel */
  rs_i64 contacts; /* voxels */
} SubstepSums;

/* What the law gives, by lane while it runs. */
typedef struct {
  rs_sum force[3];
  rs_sum torque[3];
  rs_sum floor_energy;
} LaneSums;

/* An edge of the tool's profile in (r, z) of T, mm: from (r0, z0) along (along_r, along_z), with 1/length^2 and its
 * outward unit normal. */
typedef struct {
  float r0, z0, along_r, along_z;
  float inverse_length2;
  float normal_r, normal_z;
  float z1; /* exactly the next edge's z0 */
} ProfileEdge;

/* Which edges can be nearest: a grid of square cells over (r, z), each with a list of edges in ascending order that
 * holds the nearest edge of every point within `reach` of the cell. Cells far from the profile, and points off the
 * grid, use list 0, which holds all edges. */
typedef struct {
  float z0; /* mm; r begins at 0 */
  float per_mm;
  rs_i32 count_r, count_z;
} ProfileGrid;

typedef struct {
  rs_u32 first; /* into the array of edge numbers */
  rs_u32 count;
} EdgeList;

/* The tool's profile as a kernel sees it. */
typedef struct {
  RS_GLOBAL const ProfileEdge* edges;
  RS_GLOBAL const rs_u16* numbers;  /* of edges, list after list */
  RS_GLOBAL const EdgeList* lists;  /* [1 + count_r * count_z]; cell (r, z) has list 1 + r + count_r * z */
  RS_GLOBAL const ProfileGrid* grid;
} ProfileView;

/* ---- Bricks: 8x8x8 voxels, stored only where there is bone ---- */

#define RS_BRICK_SIDE 8
#define RS_BRICK_VOXELS 512
#define RS_BRICK_WORDS 16 /* of 32 bits, a bit per voxel */

/* A voxel's place in its brick: eight blocks of 4x4x4 voxels, x before y before z in the block and among the blocks, so
 * that a block is 64 consecutive bits and what a surface touches lies close together. */
RS_INLINE rs_i32 rs_brick_offset(rs_i32 x, rs_i32 y, rs_i32 z) {
  return (((x >> 2) & 1) | ((y >> 2) & 1) << 1 | ((z >> 2) & 1) << 2) << 6 | (x & 3) | (y & 3) << 2 | (z & 3) << 4;
}

RS_INLINE rs_i32 rs_offset_x(rs_i32 offset) {
  return (offset >> 6 & 1) << 2 | (offset & 3);
}
RS_INLINE rs_i32 rs_offset_y(rs_i32 offset) {
  return (offset >> 7 & 1) << 2 | (offset >> 2 & 3);
}
RS_INLINE rs_i32 rs_offset_z(rs_i32 offset) {
  return (offset >> 8 & 1) << 2 | (offset >> 4 & 3);
}

/* By rs_brick_offset. RS_BRICK_FILL is defined where voxels can be partly gone. */
typedef struct {
  rs_u32 bone[RS_BRICK_WORDS];    /* bit: something is left of the voxel */
  rs_u32 touched[RS_BRICK_WORDS]; /* bit: the tool touches it in this substep; all 0 between cut and detect */
  rs_u8 grade[RS_BRICK_VOXELS];
#ifdef RS_BRICK_FILL
  rs_u16 fill[RS_BRICK_VOXELS];
#endif
} Brick;

/* The bricks stand in RS_POOLS buffers (1 or 16) of 2^RS_POOL_BITS bricks, because devices limit one allocation. */
#ifdef RS_POOLS
#if RS_POOLS == 1
#define RS_POOL_PARAMETERS __global Brick* pool_0
#define RS_POOL_ARRAY \
  { pool_0 }
#else
#define RS_POOL_PARAMETERS                                                                              \
  __global Brick *pool_0, __global Brick *pool_1, __global Brick *pool_2, __global Brick *pool_3,       \
      __global Brick *pool_4, __global Brick *pool_5, __global Brick *pool_6, __global Brick *pool_7,   \
      __global Brick *pool_8, __global Brick *pool_9, __global Brick *pool_10, __global Brick *pool_11, \
      __global Brick *pool_12, __global Brick *pool_13, __global Brick *pool_14, __global Brick *pool_15
#define RS_POOL_ARRAY                                                                                               \
  {                                                                                                                 \
    pool_0, pool_1, pool_2, pool_3, pool_4, pool_5, pool_6, pool_7, pool_8, pool_9, pool_10, pool_11, pool_12,      \
        pool_13, pool_14, pool_15                                                                                   \
  }
#endif
#define RS_POOL_MASK ((1u << RS_POOL_BITS) - 1u)
#endif

/* A block of the shell's grid with its points: their lowest cell, and how far the highest lies from it. Points are 16-bit
 * offsets from the lowest cell, 5 bits an axis, x in bit 0. */
#define RS_CELL_BITS 5
typedef struct {
  rs_i32 first[3];
  rs_i32 span[3];
  rs_u32 begin; /* of the offsets; a multiple of 16 */
  rs_u32 count;
} ShellCell;

/* The voxels of a block that went in a substep, as the kernels report them. */
typedef struct {
  rs_u32 brick;  /* in the lattice of bricks */
  rs_u32 detail; /* substep's slot << 3 | block in the brick */
  rs_u64 gone;   /* a bit per voxel of the block */
} RemovedBlock;

/* ---- Morton codes: 10 bits per axis, x in bit 0 (paper §3.3) ---- */

RS_INLINE rs_i32 rs_compact_bits(rs_u32 code) {
  code &= 0x09249249u;
  code = (code ^ (code >> 2)) & 0x030c30c3u;
  code = (code ^ (code >> 4)) & 0x0300f00fu;
  code = (code ^ (code >> 8)) & 0xff0000ffu;
  code = (code ^ (code >> 16)) & 0x000003ffu;
  return (rs_i32)code;
}

/* The same of a code of 21 bits per axis, for shells of more than 1024 cells per axis. */
RS_INLINE rs_i32 rs_compact_wide_bits(rs_u64 code) {
  code &= 0x1249249249249249ul;
  code = (code ^ (code >> 2)) & 0x10c30c30c30c30c3ul;
  code = (code ^ (code >> 4)) & 0x100f00f00f00f00ful;
  code = (code ^ (code >> 8)) & 0x001f0000ff0000fful;
  code = (code ^ (code >> 16)) & 0x001f00000000fffful;
  code = (code ^ (code >> 32)) & 0x00000000001ffffful;
  return (rs_i32)code;
}

/* ---- Detect: where a shell point lies ---- */

/* Voxel coordinate along `axis` of the centre of shell cell (x, y, z). */
RS_INLINE rs_i32 rs_voxel_coordinate(RS_GLOBAL const SubstepArgs* a, int axis, rs_i32 x, rs_i32 y, rs_i32 z) {
  RS_GLOBAL const rs_i64* row = a->voxel_from_cell + 3 * axis;
  return (rs_i32)((a->voxel_origin[axis] + row[0] * x + row[1] * y + row[2] * z) >> RS_POSITION_BITS);
}

RS_INLINE int rs_in_voi(RS_GLOBAL const SubstepArgs* a, rs_i32 x, rs_i32 y, rs_i32 z) {
  return x >= a->voi_min[0] && x <= a->voi_max[0] && y >= a->voi_min[1] && y <= a->voi_max[1] && z >= a->voi_min[2] &&
         z <= a->voi_max[2];
}

/* ---- The profile's outward normal ---- */

/* The list of edges for points within the grid's reach of (r, z). */
RS_INLINE EdgeList rs_edges_near(const ProfileView* profile, float r, float z) {
  RS_GLOBAL const ProfileGrid* g = profile->grid;
  const float cr = r * g->per_mm, cz = (z - g->z0) * g->per_mm;
  if (!(cr < (float)g->count_r && cz >= 0 && cz < (float)g->count_z)) return profile->lists[0];
  return profile->lists[1 + (rs_i32)cr + g->count_r * (rs_i32)cz];
}

/* Outward unit normal (n_r, n_z) at the profile's point nearest to (r, z), of the edges in `list`: the gradient of the
 * signed distance there, or the edge's normal on the surface itself. Of two edges that share the nearest vertex the one
 * seen more squarely decides the sign. */
RS_INLINE void rs_profile_normal(const ProfileView* profile, EdgeList list, rs_real r, rs_real z, rs_real* normal_r,
                                 rs_real* normal_z) {
  const rs_real zero = (rs_real)0.0f, one = (rs_real)1.0f;
  rs_real best = (rs_real)1e30f, best_side = zero, dr = zero, dz = zero, nr = zero, nz = -one;
  for (rs_u32 i = 0; i < list.count; ++i) {
    RS_GLOBAL const ProfileEdge* e = profile->edges + profile->numbers[list.first + i];
    const rs_real vr = r - e->r0, vz = z - e->z0;
    rs_real t = (vr * e->along_r + vz * e->along_z) * e->inverse_length2;
    t = t > 0.0f ? t : zero;
    t = t < 1.0f ? t : one;
    const rs_real pr = vr - t * e->along_r, pz = vz - t * e->along_z;
    const rs_real d2 = pr * pr + pz * pz;
    const rs_real side = pr * e->normal_r + pz * e->normal_z;
    const rs_real abs_side = side < 0.0f ? -side : side, abs_best = best_side < 0.0f ? -best_side : best_side;
    /* One comparison more than `&&` needs, but the same for scalars and lanes. */
    const rs_real tie = d2 == best ? abs_side - abs_best : -one;
    const rs_real gain = d2 < best ? one : tie;
    best = gain > 0.0f ? d2 : best;
    best_side = gain > 0.0f ? side : best_side;
    dr = gain > 0.0f ? pr : dr;
    dz = gain > 0.0f ? pz : dz;
    nr = gain > 0.0f ? (rs_real)e->normal_r : nr;
    nz = gain > 0.0f ? (rs_real)e->normal_z : nz;
  }
  /* On the surface itself the direction is undefined: the edge's own normal. */
  const rs_real signed_inverse = (best_side < 0.0f ? -one : one) / RS_SQRT(best);
  *normal_r = best > 1e-12f ? dr * signed_inverse : nr;
  *normal_z = best > 1e-12f ? dz * signed_inverse : nz;
}

/* ---- Cut: what a voxel that loses volume does to the tool (design §5) ---- */

RS_INLINE rs_i64 rs_energy_units(double energy) {
  return (rs_i64)RS_FLOOR(energy * RS_ENERGY_SCALE + 0.5);
}

/* Fill that a touched voxel of density `density` loses: all of it, or what wears off in this substep. */
RS_INLINE rs_i32 rs_lost_fill(RS_GLOBAL const SubstepArgs* a, double density, rs_i32 fill) {
  if (a->erosion == RS_EROSION_REMOVE) return fill;
  const double lost = RS_FLOOR(RS_WHOLE_FILL * a->wear / density + 0.5);
  return lost >= fill ? fill : lost < 1 ? 1 : (rs_i32)lost;
}

/* mJ that a voxel takes which loses `lost` of its fill, when the whole of it would take `whole`. */
RS_INLINE double rs_lost_energy(double whole, rs_i32 lost) {
  return lost == RS_WHOLE_FILL ? whole : whole * lost / RS_WHOLE_FILL;
}

/* Adds force `f` (N) at lever `p` (mm, from the tool's origin) to the sums. The scales are powers of two, so that only
 * what lies below the sums' last digit is dropped. */
RS_INLINE void rs_add_force(LaneSums* sums, const rs_real* f, const rs_real* p) {
  const float force = (float)RS_FORCE_SCALE, torque = (float)RS_TORQUE_SCALE;
  sums->force[0] += RS_TO_SUM(f[0] * force);
  sums->force[1] += RS_TO_SUM(f[1] * force);
  sums->force[2] += RS_TO_SUM(f[2] * force);
  sums->torque[0] += RS_TO_SUM((p[1] * f[2] - p[2] * f[1]) * torque);
  sums->torque[1] += RS_TO_SUM((p[2] * f[0] - p[0] * f[2]) * torque);
  sums->torque[2] += RS_TO_SUM((p[0] * f[1] - p[1] * f[0]) * torque);
}

/* The tool's outward normal at `p` (T, mm), of the edges in `list`. Zero radial part on the spin axis. */
RS_INLINE void rs_normal_at(const ProfileView* profile, EdgeList list, const rs_real* p, rs_real* normal) {
  const rs_real r = RS_SQRT(p[0] * p[0] + p[1] * p[1]);
  rs_real radial;
  rs_profile_normal(profile, list, r, p[2], &radial, &normal[2]);
  const rs_real share = r > 0.0f ? radial / r : (rs_real)0.0f;
  normal[0] = share * p[0];
  normal[1] = share * p[1];
}

/* Lowest voxel of the brick that holds voxel (x, y, z): its centre in T, mm. */
RS_INLINE void rs_brick_in_tool(RS_GLOBAL const SubstepArgs* a, rs_i32 x, rs_i32 y, rs_i32 z, float* p) {
  const rs_i32 bx = x & ~(RS_BRICK_SIDE - 1), by = y & ~(RS_BRICK_SIDE - 1), bz = z & ~(RS_BRICK_SIDE - 1);
  for (int i = 0; i < 3; ++i)
    p[i] = (float)(a->tool_origin[i] + a->tool_from_voxel[3 * i] * bx + a->tool_from_voxel[3 * i + 1] * by +
                   a->tool_from_voxel[3 * i + 2] * bz);
}

/* Centre in T of the voxel (x, y, z), counted within its brick, whose lowest voxel's centre is `brick`. From there in
 * single precision: a lever is off by 10^-5 mm at most. */
RS_INLINE void rs_voxel_in_tool(RS_GLOBAL const SubstepArgs* a, const float* brick, rs_real x, rs_real y, rs_real z,
                                rs_real* p) {
  p[0] = brick[0] + ((float)a->tool_from_voxel[0] * x + (float)a->tool_from_voxel[1] * y +
                     (float)a->tool_from_voxel[2] * z);
  p[1] = brick[1] + ((float)a->tool_from_voxel[3] * x + (float)a->tool_from_voxel[4] * y +
                     (float)a->tool_from_voxel[5] * z);
  p[2] = brick[2] + ((float)a->tool_from_voxel[6] * x + (float)a->tool_from_voxel[7] * y +
                     (float)a->tool_from_voxel[8] * z);
}

/* Force of the energetic law on the tool for a voxel with centre at `p` (T, mm) whose loss took `energy` mJ:
 * -F_t·v/|v| - k_n·F_t·n_perp with F_t = E/(max(|v|, v_floor)·dt). A voxel on which the tool does not move takes energy
 * but gives no force; all of it is floor energy. `list` holds the profile's edges that can be nearest. */
RS_INLINE void rs_cut_force(RS_GLOBAL const SubstepArgs* a, const ProfileView* profile, EdgeList list, const rs_real* p,
                            rs_real energy, LaneSums* sums) {
  const rs_real zero = (rs_real)0.0f, one = (rs_real)1.0f;
  RS_GLOBAL const float *w = a->angular_velocity, *v0 = a->origin_velocity;
  const rs_real vx = v0[0] + (w[1] * p[2] - w[2] * p[1]);
  const rs_real vy = v0[1] + (w[2] * p[0] - w[0] * p[2]);
  const rs_real vz = v0[2] + (w[0] * p[1] - w[1] * p[0]);
  const rs_real speed = RS_SQRT(vx * vx + vy * vy + vz * vz);
  /* Zero where nothing moves, so that the force is zero and not undefined. */
  const rs_real per_speed = speed > 0.0f ? one / speed : zero;
  const rs_real tangential = energy * (speed > a->speed_floor ? per_speed * a->per_duration : (rs_real)a->floor_rate);
  const rs_real over_floor = speed > a->speed_floor ? zero : energy * (one - speed * a->per_speed_floor);
  sums->floor_energy += RS_TO_SUM(over_floor * (float)RS_ENERGY_SCALE);
  rs_real n[3];
  rs_normal_at(profile, list, p, n);
  const rs_real along = (n[0] * vx + n[1] * vy + n[2] * vz) * per_speed;
  const rs_real normal = speed > 0.0f ? a->normal_ratio * tangential : zero;
  const rs_real against = (tangential - normal * along) * per_speed;
  const rs_real f[3] = {-(against * vx) - normal * n[0], -(against * vy) - normal * n[1],
                        -(against * vz) - normal * n[2]};
  rs_add_force(sums, f, p);
}

#if !defined(RS_LANES)
RS_INLINE void rs_add_lanes(SubstepSums* sums, const LaneSums* lanes) {
  for (int i = 0; i < 3; ++i) {
    sums->force[i] += lanes->force[i];
    sums->torque[i] += lanes->torque[i];
  }
  sums->floor_energy += lanes->floor_energy;
}

/* Force of the energetic law for one voxel of the lattice. */
RS_INLINE void rs_voxel_force(RS_GLOBAL const SubstepArgs* a, const ProfileView* profile, rs_i32 x, rs_i32 y, rs_i32 z,
                              float energy, LaneSums* sums) {
  float brick[3], p[3];
  rs_brick_in_tool(a, x, y, z, brick);
  rs_voxel_in_tool(a, brick, (float)(x & 7), (float)(y & 7), (float)(z & 7), p);
  rs_cut_force(a, profile, rs_edges_near(profile, RS_SQRT(p[0] * p[0] + p[1] * p[1]), p[2]), p, energy, sums);
}

/* Whether (r, z), r >= 0, lies in the profile's polygon or on it, by the edges that a ray towards larger r crosses.
 * Edges on the axis are not in the list; such a ray never crosses them. */
RS_INLINE int rs_inside_profile(const ProfileView* profile, float r, float z) {
  int inside = 0;
  const rs_i32 count = (rs_i32)profile->lists[0].count;
  for (rs_i32 i = 0; i < count; ++i) {
    RS_GLOBAL const ProfileEdge* e = profile->edges + i;
    const float r0 = e->r0, r1 = e->r0 + e->along_r, z0 = e->z0, z1 = e->z1;
    if ((z < z0 && z < z1) || (z > z0 && z > z1)) continue;
    const float side = (r - r0) * e->normal_r + (z - z0) * e->normal_z;
    const int beside = (r < r0 && r < r1) || (r > r0 && r > r1);
    if (side == 0 && !beside) return 1;
    /* Half-open in z, so that a ray through a vertex counts one of its two edges. The outward normal of an edge that
     * goes up points to larger r. */
    if ((z0 <= z) != (z1 <= z) && (z1 > z0 ? side < 0 : side > 0)) inside = !inside;
  }
  return inside;
}

/* Whether the tool's solid of revolution holds the centre of voxel (x, y, z). */
RS_INLINE int rs_holds_voxel(RS_GLOBAL const SubstepArgs* a, const ProfileView* profile, rs_i32 x, rs_i32 y, rs_i32 z) {
  float brick[3], p[3];
  rs_brick_in_tool(a, x, y, z, brick);
  rs_voxel_in_tool(a, brick, (float)(x & 7), (float)(y & 7), (float)(z & 7), p);
  return rs_inside_profile(profile, RS_SQRT(p[0] * p[0] + p[1] * p[1]), p[2]);
}

/* The paper's way: each touching point pushes the tool back along its inward normal with a given elemental force. Shell
 * frame: the profile is the same at every turn of the spin. */
RS_INLINE void rs_point_force(RS_GLOBAL const SubstepArgs* a, const ProfileView* profile, rs_i32 x, rs_i32 y, rs_i32 z,
                              LaneSums* sums) {
  const float p[3] = {(float)(a->shell_origin[0] + (x + 0.5) * a->cell_mm),
                      (float)(a->shell_origin[1] + (y + 0.5) * a->cell_mm),
                      (float)(a->shell_origin[2] + (z + 0.5) * a->cell_mm)};
  float n[3];
  rs_normal_at(profile, rs_edges_near(profile, RS_SQRT(p[0] * p[0] + p[1] * p[1]), p[2]), p, n);
  const float f[3] = {-a->force_per_point * n[0], -a->force_per_point * n[1], -a->force_per_point * n[2]};
  rs_add_force(sums, f, p);
}
#endif

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
