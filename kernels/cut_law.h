/* What a voxel that loses volume does to the tool (docs/physics.md, 4), once for the host and for every kernel. */
#ifndef REAMSIM_KERNELS_CUT_LAW_H
#define REAMSIM_KERNELS_CUT_LAW_H

#include "bricks.h"
#include "power.h"
#include "profile.h"
#include "shared.h"

/* What the law gives, by lane while it runs. */
typedef struct {
  rs_sum force[3];
  rs_sum torque[3];
  rs_sum floor_energy;
  rs_sum energy; /* of erosion exact all; of the others, which add up whole numbers, what the size effect adds */
} LaneSums;

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

/* Lowest voxel of the brick that holds voxel (x, y, z): its centre in T, mm. */
RS_INLINE void rs_brick_in_tool(RS_GLOBAL const SubstepArgs* a, rs_i32 x, rs_i32 y, rs_i32 z, float* p) {
  const rs_i32 bx = x & ~(RS_BRICK_SIDE - 1), by = y & ~(RS_BRICK_SIDE - 1), bz = z & ~(RS_BRICK_SIDE - 1);
  for (int i = 0; i < 3; ++i)
    p[i] = (float)(a->tool_origin[i] + a->tool_from_voxel[3 * i] * bx + a->tool_from_voxel[3 * i + 1] * by +
                   a->tool_from_voxel[3 * i + 2] * bz);
}

/* Middle of the brick whose lowest voxel's centre is `corner` (T, mm). */
RS_INLINE void rs_brick_middle(RS_GLOBAL const SubstepArgs* a, const float* corner, float* p) {
  for (int i = 0; i < 3; ++i) {
    RS_GLOBAL const double* row = a->tool_from_voxel + 3 * i;
    p[i] = corner[i] + (float)(3.5 * (row[0] + row[1] + row[2]));
  }
}

/* Centre in T of the voxel (x, y, z), counted within its brick, whose lowest voxel's centre is `brick`. From there in
 * single precision: a lever is off by 10^-5 mm at most. */
RS_INLINE void rs_voxel_in_tool(RS_GLOBAL const SubstepArgs* a, const float* brick, rs_real x, rs_real y, rs_real z,
                                rs_real* p) {
  p[0] = brick[0] + (a->tool_step[0] * x + a->tool_step[1] * y + a->tool_step[2] * z);
  p[1] = brick[1] + (a->tool_step[3] * x + a->tool_step[4] * y + a->tool_step[5] * z);
  p[2] = brick[2] + (a->tool_step[6] * x + a->tool_step[7] * y + a->tool_step[8] * z);
}

/* How the tool moves at `p` (T, mm): its velocity there, mm/s, and the size of that with its inverse, which is zero
 * where nothing moves, so that the force is zero and not undefined. */
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
  m.per_speed = m.speed > 0.0f ? (rs_real)1.0f / m.speed : (rs_real)0.0f;
  return m;
}

/* Adds -tangential·v/|v| - normal·n_perp at `p`; only the first does work. `n`: the tool's outward normal there. */
RS_INLINE void rs_add_resistance(const ToolMotion* m, const rs_real* n, const rs_real* p, rs_real tangential,
                                 rs_real normal, LaneSums* sums) {
  const rs_real along = (n[0] * m->v[0] + n[1] * m->v[1] + n[2] * m->v[2]) * m->per_speed;
  const rs_real against = (tangential - normal * along) * m->per_speed;
  const rs_real f[3] = {-(against * m->v[0]) - normal * n[0], -(against * m->v[1]) - normal * n[1],
                        -(against * m->v[2]) - normal * n[2]};
  rs_add_force(sums, f, p);
}

/* How fast a surface of revolution with normal `n` at `p` advances along it, mm/s. The spin moves none along its
 * normal, and is left out, because it would drown a slow feed in rounding. */
RS_INLINE rs_real rs_advance(RS_GLOBAL const SubstepArgs* a, const rs_real* n, const rs_real* p) {
  RS_GLOBAL const float *w = a->angular_velocity, *v0 = a->origin_velocity;
  return n[0] * (v0[0] + w[1] * p[2]) + n[1] * (v0[1] - w[0] * p[2]) + n[2] * (v0[2] + (w[0] * p[1] - w[1] * p[0]));
}

/* What the size effect makes of the specific energy: (h0/h)^m with h the chip's thickness, how far the surface goes
 * along its normal from one lip's passing to the next. */
RS_INLINE rs_real rs_size_factor(RS_GLOBAL const SubstepArgs* a, const rs_real* n, const rs_real* p) {
  const rs_real least = (rs_real)a->least_chip, most = (rs_real)a->most_chip;
  const rs_real advance = rs_advance(a, n, p);
  const rs_real chip = (advance < 0.0f ? -advance : advance) * a->chip_per_speed;
  const rs_real at_least = chip > least ? chip : least;
  return rs_power(at_least < most ? at_least : most, -a->size_exponent);
}

/* Force of the energetic law on the tool for a voxel with centre at `p` (T, mm) whose loss took `energy` mJ:
 * -F_t·v/|v| - k_n·F_t·n_perp with F_t = E/(max(|v|, v_floor)·dt). A voxel on which the tool does not move takes energy
 * but gives no force; all of it is floor energy. `n`: the tool's outward normal there. `energy` is without the size
 * effect; what that adds goes to the energy's sum here. */
RS_INLINE void rs_cut_force(RS_GLOBAL const SubstepArgs* a, const rs_real* n, const rs_real* p, rs_real energy,
                            LaneSums* sums) {
  const rs_real zero = (rs_real)0.0f, one = (rs_real)1.0f;
  if (a->size_exponent > 0.0f) {
    const rs_real sized = energy * rs_size_factor(a, n, p);
    sums->energy += RS_TO_SUM((sized - energy) * (float)RS_ENERGY_SCALE);
    energy = sized;
  }
  const ToolMotion m = rs_tool_motion(a, p);
  const rs_real tangential =
      energy * (m.speed > a->speed_floor ? m.per_speed * a->per_duration : (rs_real)a->floor_rate);
  const rs_real over_floor = m.speed > a->speed_floor ? zero : energy * (one - m.speed * a->per_speed_floor);
  sums->floor_energy += RS_TO_SUM(over_floor * (float)RS_ENERGY_SCALE);
  rs_add_resistance(&m, n, p, tangential, m.speed > 0.0f ? a->normal_ratio * tangential : zero, sums);
}

#if !defined(RS_LANES)
RS_INLINE void rs_add_lanes(SubstepSums* sums, const LaneSums* lanes) {
  for (int i = 0; i < 3; ++i) {
    sums->force[i] += lanes->force[i];
    sums->torque[i] += lanes->torque[i];
  }
  sums->energy += lanes->energy;
  sums->floor_energy += lanes->floor_energy;
}

/* Force of the energetic law for one voxel of the lattice. */
RS_INLINE void rs_voxel_force(RS_GLOBAL const SubstepArgs* a, const ProfileView* profile, rs_i32 x, rs_i32 y, rs_i32 z,
                              float energy, LaneSums* sums) {
  float brick[3], p[3];
  rs_brick_in_tool(a, x, y, z, brick);
  rs_voxel_in_tool(a, brick, (float)(x & 7), (float)(y & 7), (float)(z & 7), p);
  float n[3];
  rs_tool_nearest(profile, rs_edges_near(profile, RS_SQRT(p[0] * p[0] + p[1] * p[1]), p[2]), p, n);
  rs_cut_force(a, n, p, energy, sums);
}

/* Whether the tool's solid of revolution holds the centre of voxel (x, y, z). */
RS_INLINE int rs_contains_voxel(RS_GLOBAL const SubstepArgs* a, const ProfileView* profile, rs_i32 x, rs_i32 y, rs_i32 z) {
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
  rs_tool_nearest(profile, rs_edges_near(profile, RS_SQRT(p[0] * p[0] + p[1] * p[1]), p[2]), p, n);
  const float f[3] = {-a->force_per_point * n[0], -a->force_per_point * n[1], -a->force_per_point * n[2]};
  rs_add_force(sums, f, p);
}
#endif

#endif
