// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* The force law: the force on the tool of a voxel that loses volume (docs/physics.md, 4). Host and kernels share it. */
#ifndef REAMSIM_KERNELS_CUT_LAW_H
#define REAMSIM_KERNELS_CUT_LAW_H

#include "bricks.h"
#include "outline.h"
#include "shared.h"

/* Powers from correctly rounded operations; the rounding of the built-in pow() depends on the device. */

/* log2(x), x > 0 and not subnormal, error below 10^-7: exponent, and series of artanh for a mantissa of 2^(+-1/2). */
RS_INLINE rs_real rs_log2(rs_real x) {
  const rs_real one = RS_REAL(1.0f);
  const rs_int bits = RS_BITS_OF(x), zero = RS_INT(0), single = RS_INT(1);
  const rs_real whole = RS_REAL_OF((bits & 0x007fffff) | 0x3f800000); /* 1 .. 2 */
  const rs_real mantissa = whole > 1.41421356f ? whole * 0.5f : whole;
  const rs_int exponent = (bits >> 23) - 127 + (whole > 1.41421356f ? single : zero);
  const rs_real t = (mantissa - one) / (mantissa + one), t2 = t * t;
  const rs_real series =
      t * (2.88539008f + t2 * (0.961796694f + t2 * (0.577078016f + t2 * (0.412198583f + t2 * 0.320598898f))));
  return RS_TO_REAL(exponent) + series;
}

/* 2^x, |x| < 126, relative error below 2·10^-7: exponent, and the series of exp for the remainder. */
RS_INLINE rs_real rs_exp2(rs_real x) {
  const rs_real whole = RS_FLOOR(x + 0.5f), rest = (x - whole) * 0.693147181f;
  const rs_real series =
      1.0f +
      rest *
          (1.0f +
           rest * (0.5f + rest * (0.166666667f +
                                  rest * (0.0416666667f + rest * (0.00833333333f +
                                                                  rest * (0.00138888889f + rest * 0.000198412698f))))));
  return series * RS_REAL_OF((RS_TO_INT(whole) + 127) << 23);
}

/* x^y, relative error about 10^-6, for x > 0 and |y·log2(x)| < 126. */
RS_INLINE rs_real rs_power(rs_real x, float y) {
  return rs_exp2(y * rs_log2(x));
}

/* Sums of the law, lane by lane. */
typedef struct {
  rs_sum force[3];
  rs_sum torque[3];
  rs_sum floor_energy;
  rs_sum energy; /* erosion exact: all; else, where integers are summed, the addition by the size effect */
} LaneSums;

/* Fill that a touched voxel loses in this substep. `density`: in RS_DENSITY_SCALE. */
RS_INLINE rs_i32 rs_lost_fill(RS_GLOBAL const SubstepArgs* a, rs_i32 density, rs_i32 fill) {
  if (a->erosion == RS_EROSION_REMOVE) return fill;
  const rs_i64 lost = (2 * a->wear + density) / (2 * (rs_i64)density); /* rounded */
  return lost >= fill ? fill : lost < 1 ? 1 : (rs_i32)lost;
}

/* Cutting energy of a voxel that loses `lost` of its fill, in units of the sum. `whole`: that of a whole voxel. */
RS_INLINE rs_i64 rs_lost_energy(rs_i64 whole, rs_i32 lost) {
  const rs_i64 part = whole / RS_WHOLE_FILL, rest = whole % RS_WHOLE_FILL; /* the product may exceed 64 bits */
  return part * lost + (2 * rest * lost + RS_WHOLE_FILL) / (2 * RS_WHOLE_FILL);
}

/* mJ. */
RS_INLINE float rs_energy_mj(rs_i64 units) {
  return (float)units * (1.0f / (float)RS_ENERGY_SCALE);
}

/* Adds force `f` (N) at lever `p` (mm, from the tool's origin). The scales are powers of two, so that scaling is exact.
 */
RS_INLINE void rs_add_force(LaneSums* sums, const rs_real* f, const rs_real* p) {
  const float force = (float)RS_FORCE_SCALE, torque = (float)RS_TORQUE_SCALE;
  sums->force[0] += RS_TO_SUM(f[0] * force);
  sums->force[1] += RS_TO_SUM(f[1] * force);
  sums->force[2] += RS_TO_SUM(f[2] * force);
  sums->torque[0] += RS_TO_SUM((p[1] * f[2] - p[2] * f[1]) * torque);
  sums->torque[1] += RS_TO_SUM((p[2] * f[0] - p[0] * f[2]) * torque);
  sums->torque[2] += RS_TO_SUM((p[0] * f[1] - p[1] * f[0]) * torque);
}

/* From the middle of a brick's lowest voxel to that of the brick, voxels. */
#define RS_BRICK_MIDDLE (0.5f * (RS_BRICK_SIDE - 1))

/* Middle of a brick, T, mm: `p`, and what its rounding to single precision leaves out, `rest`. All voxels of the brick
 * have that error in common, so it does not average out in the force of a frame; errors of tool_step do, counted from
 * the middle. */
typedef struct {
  float p[3], rest[3];
} BrickMiddle;

/* Twice the coordinate along `axis` of T of a point in units of half bricks from the middle of brick (0,0,0). */
RS_INLINE rs_i64 rs_twice_in_tool(RS_GLOBAL const SubstepArgs* a, int axis, rs_i32 x2, rs_i32 y2, rs_i32 z2) {
  RS_GLOBAL const rs_i64* row = a->tool_from_brick + 3 * axis;
  return 2 * a->brick_origin[axis] + row[0] * x2 + row[1] * y2 + row[2] * z2;
}

/* The middle of the brick with voxel (x, y, z). */
RS_INLINE void rs_brick_in_tool(RS_GLOBAL const SubstepArgs* a, rs_i32 x, rs_i32 y, rs_i32 z, BrickMiddle* brick) {
  const float unit = 0.5f / (float)RS_LENGTH_SCALE;
  for (int i = 0; i < 3; ++i) {
    const rs_i64 twice = rs_twice_in_tool(a, i, 2 * (x >> 3), 2 * (y >> 3), 2 * (z >> 3));
    const float nearest = (float)twice;
    brick->p[i] = nearest * unit;
    brick->rest[i] = (float)(twice - (rs_i64)nearest) * unit;
  }
}

/* The pieces that can be nearest to any voxel of the brick. */
RS_INLINE PieceList rs_pieces_near_brick(const OutlineView* outline, const BrickMiddle* brick) {
  const float* p = brick->p;
  return rs_pieces_near(outline, RS_SQRT(p[0] * p[0] + p[1] * p[1]), p[2]);
}

/* Centre in T of the voxel (x, y, z), counted within its brick, without the brick's `rest`. Single precision, with an
 * error of at most 10^-5 mm. Returns its distance from the spin axis, mm. */
RS_INLINE rs_real rs_voxel_in_tool(RS_GLOBAL const SubstepArgs* a, const BrickMiddle* brick, rs_real x, rs_real y,
                                   rs_real z, rs_real* p) {
  const rs_real dx = x - RS_BRICK_MIDDLE, dy = y - RS_BRICK_MIDDLE, dz = z - RS_BRICK_MIDDLE;
  p[0] = brick->p[0] + (a->tool_step[0] * dx + a->tool_step[1] * dy + a->tool_step[2] * dz);
  p[1] = brick->p[1] + (a->tool_step[3] * dx + a->tool_step[4] * dy + a->tool_step[5] * dz);
  p[2] = brick->p[2] + (a->tool_step[6] * dx + a->tool_step[7] * dy + a->tool_step[8] * dz);
  return RS_SQRT(p[0] * p[0] + p[1] * p[1]);
}

/* Velocity of the tool at a point, mm/s, T; its magnitude and inverse, which is 0 at rest: the force is then zero. */
typedef struct {
  rs_real v[3];
  rs_real speed;
  rs_real per_speed;
} ToolMotion;

RS_INLINE ToolMotion rs_tool_motion(RS_GLOBAL const SubstepArgs* a, const rs_real* p) {
  RS_GLOBAL const float *w = a->angular_velocity, *v0 = a->origin_velocity;
  ToolMotion m;
  m.v[0] = v0[0] + (w[1] * p[2] - w[2] * p[1]);
  m.v[1] = v0[1] + (w[2] * p[0] - w[0] * p[2]);
  m.v[2] = v0[2] + (w[0] * p[1] - w[1] * p[0]);
  m.speed = RS_SQRT(m.v[0] * m.v[0] + m.v[1] * m.v[1] + m.v[2] * m.v[2]);
  m.per_speed = m.speed > 0.0f ? RS_REAL(1.0f) / m.speed : RS_REAL(0.0f);
  return m;
}

/* The force -tangential·v/|v| - normal·n_perp; only the first term does work. `n`: the tool's outward normal. */
RS_INLINE void rs_resistance(const ToolMotion* m, const rs_real* n, rs_real tangential, rs_real normal, rs_real* f) {
  const rs_real along = (n[0] * m->v[0] + n[1] * m->v[1] + n[2] * m->v[2]) * m->per_speed;
  const rs_real against = (tangential - normal * along) * m->per_speed;
  for (int i = 0; i < 3; ++i) f[i] = -(against * m->v[i]) - normal * n[i];
}

/* Speed of a surface of revolution with normal `n` at `p` along n, mm/s. The spin has no component along n, and is
 * omitted, because its rounding error would exceed a slow feed. */
RS_INLINE rs_real rs_advance(RS_GLOBAL const SubstepArgs* a, const rs_real* n, const rs_real* p) {
  RS_GLOBAL const float *w = a->angular_velocity, *v0 = a->origin_velocity;
  return n[0] * (v0[0] + w[1] * p[2]) + n[1] * (v0[1] - w[0] * p[2]) + n[2] * (v0[2] + (w[0] * p[1] - w[1] * p[0]));
}

/* Factor of the size effect: (h0/h)^m with the chip thickness h, the advance of the surface along its normal between
 * two cutting edges. */
RS_INLINE rs_real rs_size_factor(RS_GLOBAL const SubstepArgs* a, const rs_real* n, const rs_real* p) {
  const rs_real least = RS_REAL(a->min_chip), most = RS_REAL(a->max_chip);
  const rs_real advance = rs_advance(a, n, p);
  const rs_real chip = (advance < 0.0f ? -advance : advance) * a->chip_per_speed;
  const rs_real at_least = chip > least ? chip : least;
  return rs_power(at_least < most ? at_least : most, -a->size_exponent);
}

/* What the loss of a voxel exerts on the tool: force (N, T), the part of its energy below the speed floor, and the
 * energy that the size effect adds (mJ). */
typedef struct {
  rs_real force[3];
  rs_real floor_energy;
  rs_real added_energy;
} CutResponse;

/* The response of a voxel with centre `p` (T, mm) whose loss took `energy` mJ, the size effect excluded:
 * -F_t·v/|v| - k_n·F_t·n_perp with F_t = E/(max(|v|, v_floor)·dt). Where the tool is at rest the force is zero, and all
 * energy is speed-floor energy. `n`: the tool's outward normal. */
RS_INLINE CutResponse rs_cut_response(RS_GLOBAL const SubstepArgs* a, const rs_real* n, const rs_real* p,
                                      rs_real energy) {
  const rs_real zero = RS_REAL(0.0f), one = RS_REAL(1.0f);
  CutResponse out;
  out.added_energy = zero;
  if (a->size_exponent > 0.0f) {
    const rs_real sized = energy * rs_size_factor(a, n, p);
    out.added_energy = sized - energy;
    energy = sized;
  }
  const ToolMotion m = rs_tool_motion(a, p);
  const rs_real tangential =
      energy * (m.speed > a->speed_floor ? m.per_speed * a->per_duration : RS_REAL(a->floor_rate));
  out.floor_energy = m.speed > a->speed_floor ? zero : energy * (one - m.speed * a->per_speed_floor);
  rs_resistance(&m, n, tangential, m.speed > 0.0f ? a->normal_ratio * tangential : zero, out.force);
  return out;
}

/* Adds the response of a voxel. `energy` itself is summed by the caller. */
RS_INLINE void rs_cut_force(RS_GLOBAL const SubstepArgs* a, const rs_real* n, const rs_real* p, rs_real energy,
                            LaneSums* sums) {
  const CutResponse found = rs_cut_response(a, n, p, energy);
  if (a->size_exponent > 0.0f) sums->energy += RS_TO_SUM(found.added_energy * (float)RS_ENERGY_SCALE);
  sums->floor_energy += RS_TO_SUM(found.floor_energy * (float)RS_ENERGY_SCALE);
  rs_add_force(sums, found.force, p);
}

#ifdef __OPENCL_C_VERSION__
/* Adds the sums of a work-item to those of its substep. */
RS_INLINE void add_substep_sums(__global SubstepSums* total, const SubstepSums* part) {
  for (int c = 0; c < 3; ++c) {
    add_to_sum(&total->force[c], part->force[c]);
    add_to_sum(&total->torque[c], part->torque[c]);
  }
  add_to_sum(&total->energy, part->energy);
  add_to_sum(&total->floor_energy, part->floor_energy);
  add_to_sum(&total->removed, part->removed);
  add_to_sum(&total->contacts, part->contacts);
}
#endif

/* Adds the lanes of the law's sums. */
RS_INLINE void rs_add_lanes(SubstepSums* sums, const LaneSums* lanes) {
  for (int i = 0; i < 3; ++i) {
    sums->force[i] += rs_lane_sum(lanes->force[i]);
    sums->torque[i] += rs_lane_sum(lanes->torque[i]);
  }
  sums->energy += rs_lane_sum(lanes->energy);
  sums->floor_energy += rs_lane_sum(lanes->floor_energy);
}

#if !defined(RS_LANES)
/* rs_cut_force() for voxel (x, y, z) of the lattice. */
RS_INLINE void rs_voxel_force(RS_GLOBAL const SubstepArgs* a, const OutlineView* outline, rs_i32 x, rs_i32 y, rs_i32 z,
                              float energy, LaneSums* sums) {
  BrickMiddle brick;
  float p[3];
  rs_brick_in_tool(a, x, y, z, &brick);
  const float r = rs_voxel_in_tool(a, &brick, (float)(x & 7), (float)(y & 7), (float)(z & 7), p);
  float n[3];
  rs_outline_normal(outline, rs_pieces_near(outline, r, p[2]), p, n);
  rs_cut_force(a, n, p, energy, sums);
}

/* Whether the centre of voxel (x, y, z) lies in the tool's solid of revolution. */
RS_INLINE int rs_contains_voxel(RS_GLOBAL const SubstepArgs* a, const OutlineView* outline, rs_i32 x, rs_i32 y,
                                rs_i32 z) {
  BrickMiddle brick;
  float p[3];
  rs_brick_in_tool(a, x, y, z, &brick);
  const float r = rs_voxel_in_tool(a, &brick, (float)(x & 7), (float)(y & 7), (float)(z & 7), p);
  return rs_inside_outline(outline, r, p[2]);
}

/* The paper's force law: each touching point exerts a given elemental force along its inward normal. In the shell's
 * frame; the profile does not depend on the spin angle. */
RS_INLINE void rs_point_force(RS_GLOBAL const SubstepArgs* a, const OutlineView* outline, rs_i32 x, rs_i32 y, rs_i32 z,
                              LaneSums* sums) {
  const float unit = 1.0f / (float)RS_LENGTH_SCALE;
  const float p[3] = {(float)(a->shell_origin[0] + x * a->cell) * unit,
                      (float)(a->shell_origin[1] + y * a->cell) * unit,
                      (float)(a->shell_origin[2] + z * a->cell) * unit};
  float n[3];
  rs_outline_normal(outline, rs_pieces_near(outline, RS_SQRT(p[0] * p[0] + p[1] * p[1]), p[2]), p, n);
  const float f[3] = {-a->force_per_point * n[0], -a->force_per_point * n[1], -a->force_per_point * n[2]};
  rs_add_force(sums, f, p);
}

#ifdef __OPENCL_C_VERSION__
/* Adds the forces of points to the sums of their substep. */
RS_INLINE void rs_add_point_sums(__global SubstepSums* total, const LaneSums* points) {
  for (int c = 0; c < 3; ++c) {
    add_to_sum(&total->force[c], points->force[c]);
    add_to_sum(&total->torque[c], points->torque[c]);
  }
}
#endif
#endif

#endif
