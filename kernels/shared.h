// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Types and arithmetic that host and kernels share, in plain C for C++ and OpenCL C compilers. The serial engine and
 * all devices compute the same bits: positions are fixed-point integers, sums are 64-bit integers, and floating-point
 * expressions use correctly rounded operations only (no contraction). The cutting law is in single precision, which is
 * fast on every GPU; its sums are exact. Nothing optional of OpenCL 1.2 is needed: no double precision, and 64-bit
 * atomics only where a device has them (RS_INT64_ATOMICS). */
#ifndef REAMSIM_KERNELS_SHARED_H
#define REAMSIM_KERNELS_SHARED_H

#ifdef __OPENCL_C_VERSION__
#pragma OPENCL FP_CONTRACT OFF
#define double double_precision_is_optional /* an error where a kernel uses it */
typedef long rs_i64;
typedef int rs_i32;
typedef uint rs_u32;
typedef ulong rs_u64;
typedef ushort rs_u16;
typedef uchar rs_u8;
#define RS_GLOBAL __global
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
#endif
#define RS_INLINE static inline
/* An error of the compiler, of the host's or the device's, where a shared struct has not this size: no struct has
 * padding, so that the size decides the layout. */
#define RS_SAME_LAYOUT(type, bytes) typedef char type##_layout[sizeof(type) == (bytes) ? 1 : -1]
#define RS_SQRT sqrt
#define RS_FLOOR floor

/* Fractional bits of a position in voxels. The rounding error of the rotation is at most 2^-15 voxel per shell axis of
 * 1024 cells and 2^-13 per axis of 4096, the largest; in total, with that of the origin, below 2^-11. */
#define RS_POSITION_BITS 24

#ifdef __OPENCL_C_VERSION__
#define RS_SCALE(power_of_two) power_of_two##f
#else
#define RS_SCALE(power_of_two) power_of_two
#endif
/* Units of the integer sums per N, N·mm, mJ. Ranges per substep: 3·10^10 N, 5·10^11 N·mm, 2·10^9 mJ. */
#define RS_FORCE_SCALE RS_SCALE(268435456.0)   /* 2^28 */
#define RS_TORQUE_SCALE RS_SCALE(16777216.0)   /* 2^24 */
#define RS_ENERGY_SCALE RS_SCALE(4294967296.0) /* 2^32 */
/* Units of fixed-point lengths in the tool's frame per mm: up to 28 m away a brick lies within 10^-11 mm of its place.
 */
#define RS_LENGTH_SCALE RS_SCALE(35184372088832.0) /* 2^45 */
/* Units of density in wear per g/cm3. */
#define RS_DENSITY_SCALE RS_SCALE(16777216.0) /* 2^24 */

#define RS_WHOLE_FILL 65535

#define RS_LAW_ENERGY 0
#define RS_LAW_PER_POINT 1
#define RS_LAW_NONE 2 /* removal without force: bone in which the tool starts */
#define RS_EROSION_REMOVE 0
#define RS_EROSION_WEAR 1
#define RS_EROSION_EXACT 2
#define RS_EROSION_TRIAL 3 /* as exact, but nothing is removed: the sums of a motion that is only tried */

/* The arguments of one substep, written to the device in one piece before detect (paper §3.5). Lengths in mm;
 * velocities and levers in the tool frame T without spin, so that the law needs one rotation. */
typedef struct {
  rs_i64 voxel_from_cell[9];  /* row-major, fixed point: shell cell step to voxels */
  rs_i64 voxel_origin[3];     /* fixed point: centre of shell cell (0,0,0), in voxels from the lattice's corner */
  rs_i64 tool_from_brick[9];  /* row-major, RS_LENGTH_SCALE: step of a brick, T */
  rs_i64 brick_origin[3];     /* RS_LENGTH_SCALE: middle of brick (0,0,0), T */
  rs_i64 shell_origin[3];     /* RS_LENGTH_SCALE: centre of shell cell (0,0,0), shell frame */
  rs_i64 cell;                /* RS_LENGTH_SCALE: of the shell */
  rs_i64 wear;                /* RS_DENSITY_SCALE, times RS_WHOLE_FILL: density that a touched voxel loses */
  float tool_step[9];         /* row-major: step of a voxel, mm, T */
  float lattice_from_tool[9]; /* row-major: a direction in T along the lattice's axes */
  float origin_velocity[3];   /* of the tool's origin, mm/s, T */
  float angular_velocity[3];  /* spin and tilt, rad/s, T */
  float speed_floor;          /* mm/s */
  float per_speed_floor;      /* s/mm */
  float per_duration;         /* 1/s */
  float floor_rate;           /* 1/(speed floor * duration), 1/mm */
  float normal_ratio;         /* k_n */
  float force_per_point;      /* N, law per_point */
  float voxel_mm;
  float per_voxel_mm;   /* 1/mm */
  float size_exponent;  /* m of the size effect; 0 = none */
  float chip_per_speed; /* relative chip thickness per advance of the surface, s/mm */
  float min_chip;       /* limits of the chip thickness relative to its reference */
  float max_chip;
  float edge_tangential; /* cutting edges/2pi times N per mm of edge; 0 = no edge force */
  float edge_normal;
  float duration; /* s */
  float spin_cos; /* rotation of resolved cutting edges about -z of T */
  float spin_sin;
  rs_i32 dims[3];
  rs_i32 voi_min[3]; /* shell cells, inclusive */
  rs_i32 voi_max[3];
  rs_i32 law;
  rs_i32 erosion;
  rs_i32 frame;
  rs_i32 min_loss; /* fill; erosion exact ignores smaller losses */
} SubstepArgs;
RS_SAME_LAYOUT(SubstepArgs, 8 * 29 + 4 * 54);

/* Integer sums over the voxels of one substep. Force and torque act on the tool, the torque about its origin. Frame: T
 * without spin for law energy; the shell's for law per_point, which rotates with resolved cutting edges. */
typedef struct {
  rs_i64 force[3];
  rs_i64 torque[3];
  rs_i64 energy;
  rs_i64 floor_energy;
  rs_i64 removed;  /* fill units: 65535 = one voxel */
  rs_i64 contacts; /* voxels */
} SubstepSums;
RS_SAME_LAYOUT(SubstepSums, 8 * 10);

/* ---- Morton codes: 10 bits per axis, x in bit 0 (paper §3.3) ---- */

RS_INLINE rs_i32 rs_compact_bits(rs_u32 code) {
  code &= 0x09249249u;
  code = (code ^ (code >> 2)) & 0x030c30c3u;
  code = (code ^ (code >> 4)) & 0x0300f00fu;
  code = (code ^ (code >> 8)) & 0xff0000ffu;
  code = (code ^ (code >> 16)) & 0x000003ffu;
  return (rs_i32)code;
}

/* The same for codes of 21 bits per axis: shells of more than 1024 cells per axis. */
RS_INLINE rs_i32 rs_compact_wide_bits(rs_u64 code) {
  code &= 0x1249249249249249ul;
  code = (code ^ (code >> 2)) & 0x10c30c30c30c30c3ul;
  code = (code ^ (code >> 4)) & 0x100f00f00f00f00ful;
  code = (code ^ (code >> 8)) & 0x001f0000ff0000fful;
  code = (code ^ (code >> 16)) & 0x001f00000000fffful;
  code = (code ^ (code >> 32)) & 0x00000000001ffffful;
  return (rs_i32)code;
}

/* Voxel coordinate along `axis` of the centre of shell cell (x, y, z). */
RS_INLINE rs_i32 rs_voxel_coordinate(RS_GLOBAL const SubstepArgs* a, int axis, rs_i32 x, rs_i32 y, rs_i32 z) {
  RS_GLOBAL const rs_i64* row = a->voxel_from_cell + 3 * axis;
  return (rs_i32)((a->voxel_origin[axis] + row[0] * x + row[1] * y + row[2] * z) >> RS_POSITION_BITS);
}

RS_INLINE int rs_in_voi(RS_GLOBAL const SubstepArgs* a, rs_i32 x, rs_i32 y, rs_i32 z) {
  return x >= a->voi_min[0] && x <= a->voi_max[0] && y >= a->voi_min[1] && y <= a->voi_max[1] && z >= a->voi_min[2] &&
         z <= a->voi_max[2];
}

#ifdef __OPENCL_C_VERSION__
#ifdef RS_INT64_ATOMICS
#pragma OPENCL EXTENSION cl_khr_int64_base_atomics : enable
#endif

/* Adds to a sum that other work-items add to. Without 64-bit atomics both halves are added, the upper one with the
 * carry: each addition to the lower half carries by itself, whatever their order. */
RS_INLINE void add_to_sum(__global rs_i64* sum, const rs_i64 value) {
  if (value == 0) return;
#ifdef RS_INT64_ATOMICS
  atom_add(sum, value);
#else
  volatile __global uint* halves = (volatile __global uint*)sum; /* little-endian */
  const uint low = (uint)value, before = atomic_add(halves, low);
  const uint high = (uint)((rs_u64)value >> 32) + (before + low < low ? 1u : 0u);
  if (high != 0) atomic_add(halves + 1, high);
#endif
}
#endif

#endif
