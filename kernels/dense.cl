// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* The engines over a dense array of voxels (docs/engines.md): each has its own narrow phase, which lists the touched
 * voxels, and all have the same cut. Compiled with the options of the plan (VoxelLayout of sim/engine/dense), which the
 * kernels that restore voxels do not need. */
#include "cut_law.h"

/* ---- direct ---- */

/* Narrow phase of the paper (§3.5): one work-item per shell point. Decode, cull against the VOI, transform, look up. A
 * touched voxel is claimed once, by a bit, and listed. Results do not depend on the order of the list. */

#ifdef RS_WIDE_CODES /* shells of more than 1024 cells per axis: 8 bytes per point */
typedef rs_u64 ShellCode;
#define CELL_COORDINATE rs_compact_wide_bits
#else /* the paper's layout: 4 bytes per point */
typedef rs_u32 ShellCode;
#define CELL_COORDINATE rs_compact_bits
#endif

/* codes[point_count]; bone: dense grades, 0 = air or removed; claims: a bit per voxel, all 0 on entry; contacts: room
 * for min(points, voxels); contact_count[substep]: 0 on entry; sums[substep]. */
__kernel void detect_direct(const uint substep, __global const SubstepArgs* args, __global const ShellCode* codes,
                            const uint point_count, __global const uchar* bone, __global uint* claims,
                            __global uint* contacts, __global uint* contact_count, __global SubstepSums* sums,
                            __global const OutlinePiece* pieces, __global const ushort* numbers,
                            __global const PieceList* lists, __global const OutlineGrid* grid) {
  const uint point = get_global_id(0);
  if (point >= point_count) return;
  __global const SubstepArgs* a = args + substep;

  const ShellCode code = codes[point];
  const int x = CELL_COORDINATE(code), y = CELL_COORDINATE(code >> 1), z = CELL_COORDINATE(code >> 2);
  if (!rs_in_voi(a, x, y, z)) return;

  const int i = rs_voxel_coordinate(a, 0, x, y, z);
  const int j = rs_voxel_coordinate(a, 1, x, y, z);
  const int k = rs_voxel_coordinate(a, 2, x, y, z);
  if (i < 0 || j < 0 || k < 0 || i >= a->dims[0] || j >= a->dims[1] || k >= a->dims[2]) return;
  const uint e = i + a->dims[0] * (j + (uint)a->dims[1] * k);
  if (bone[e] == 0) return;

  if (a->law == RS_LAW_PER_POINT) {
    LaneSums point_sums = {{0, 0, 0}, {0, 0, 0}, 0};
    const OutlineView outline = {pieces, numbers, lists, grid};
    rs_point_force(a, &outline, x, y, z, &point_sums);
    rs_add_point_sums(&sums[substep], &point_sums);
  }
  const uint bit = 1u << (e & 31u);
  if ((atomic_or(&claims[e >> 5], bit) & bit) == 0) contacts[atomic_inc(&contact_count[substep])] = e;
}

/* ---- implicit ---- */

/* Narrow phase of Yau et al. as Faieghi et al. rebuilt it (2020, §4.3.2): no shell; one work-item per voxel of the VOI,
 * a box of voxels, against the surface of revolution that the cutting edges sweep. A voxel is touched when its centre
 * lies in the solid or on its surface. No voxel is tested twice, so claims are not needed. */

/* voi_min, voi_size: lowest voxel of the VOI and number of voxels along x, y, z; the fourth is padding. bone: dense
 * grades, 0 = air or removed; contacts: room for all voxels that the tool can contain; contact_count[substep]: 0 on
 * entry. */
__kernel void detect_implicit(const uint substep, const int4 voi_min, const uint4 voi_size,
                              __global const SubstepArgs* args, __global const uchar* bone, __global uint* contacts,
                              __global uint* contact_count, __global const OutlinePiece* pieces,
                              __global const ushort* numbers, __global const PieceList* lists,
                              __global const OutlineGrid* grid) {
  const size_t item = get_global_id(0);
  if (item >= (size_t)voi_size.x * voi_size.y * voi_size.z) return;
  __global const SubstepArgs* a = args + substep;
  const size_t row = item / voi_size.x;
  const int i = voi_min.x + (int)(item % voi_size.x);
  const int j = voi_min.y + (int)(row % voi_size.y);
  const int k = voi_min.z + (int)(row / voi_size.y);
  const uint e = i + a->dims[0] * (j + (uint)a->dims[1] * k);
  if (bone[e] == 0) return;
  const OutlineView outline = {pieces, numbers, lists, grid};
  if (rs_contains_voxel(a, &outline, i, j, k)) contacts[atomic_inc(&contact_count[substep])] = e;
}

/* ---- octree ---- */

/* Narrow phase of Zheng et al. as Faieghi et al. rebuilt it (2020, §4.3.1): one work-item per shell point, an
 * octree-like descent of the 3D grid through look-up tables, voxels of a float HU and a collision flag, points of three
 * floats, and a parallel reduction over the forces of all points, including those outside the bone. There is no VOI.
 *
 * The descent: the lattice lies in the corner of a cube of 2^levels voxels. A cell of level l is a cube of 2^(levels -
 * l) voxels; children[8·l + o] is the corner of its octant o (x in bit 0, y in bit 1, z in bit 2) relative to the
 * cell's corner: x, y, z in voxels, w as a step in the dense array. A point starts at the root; on each level it is
 * compared with the cell's three middle planes and moves to the child that contains it. After `levels` steps the corner
 * is the point's voxel, and the steps add up to the voxel's index.
 *
 * Floats represent the cell numbers exactly, so that positions are the same integers as in all engines. */

/* Index of voxel (i, j, k), found from the root downwards. The voxel lies in the lattice. */
uint descend(__global const uint4* children, const int levels, const uint i, const uint j, const uint k) {
  uint4 corner = (uint4)(0, 0, 0, 0);
  for (int level = 0; level < levels; ++level) {
    const uint half_side = 1u << (levels - 1 - level);
    const uint octant = (i >= corner.x + half_side ? 1u : 0u) | (j >= corner.y + half_side ? 2u : 0u) |
                        (k >= corner.z + half_side ? 4u : 0u);
    corner += children[8 * level + octant];
  }
  return corner.w;
}

#ifdef REAMSIM_GROUP_SIZE
/* Reduces the forces of a group's points pairwise, and adds them to the substep's sums. All work-items call it. */
void reduce_forces(__local rs_i64* partial, __global SubstepSums* total, const LaneSums* own) {
  const uint item = get_local_id(0);
  for (int c = 0; c < 3; ++c) {
    partial[c * REAMSIM_GROUP_SIZE + item] = own->force[c];
    partial[(3 + c) * REAMSIM_GROUP_SIZE + item] = own->torque[c];
  }
  for (uint live = (uint)get_local_size(0); live > 1;) {
    const uint kept = (live + 1) / 2;
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item + kept < live) {
      for (int c = 0; c < 6; ++c)
        partial[c * REAMSIM_GROUP_SIZE + item] += partial[c * REAMSIM_GROUP_SIZE + item + kept];
    }
    live = kept;
  }
  if (item != 0) return;
  for (int c = 0; c < 3; ++c) {
    add_to_sum(&total->force[c], partial[c * REAMSIM_GROUP_SIZE]);
    add_to_sum(&total->torque[c], partial[(3 + c) * REAMSIM_GROUP_SIZE]);
  }
}
#endif

/* points[3 · point_count]: cell numbers; hu: dense, hu_of_air = air or removed; flags: a byte per voxel, four per word
 * (atomics need 32 bits), all 0 on entry; contacts, contact_count, sums: as in detect_direct. Built with
 * REAMSIM_GROUP_SIZE for law per_point. */
__kernel void detect_octree(const uint substep, __global const SubstepArgs* args, __global const float* points,
                            const uint point_count, __global const float* hu, const float hu_of_air,
                            __global uint* flags, __global uint* contacts, __global uint* contact_count,
                            __global SubstepSums* sums, __global const OutlinePiece* pieces,
                            __global const ushort* numbers, __global const PieceList* lists,
                            __global const OutlineGrid* grid, __global const uint4* children, const int levels) {
  const uint point = get_global_id(0);
  __global const SubstepArgs* a = args + substep;
  int touches = 0, x = 0, y = 0, z = 0;
  if (point < point_count) {
    const float3 cell = vload3(point, points);
    x = (int)cell.x;
    y = (int)cell.y;
    z = (int)cell.z;
    const int i = rs_voxel_coordinate(a, 0, x, y, z);
    const int j = rs_voxel_coordinate(a, 1, x, y, z);
    const int k = rs_voxel_coordinate(a, 2, x, y, z);
    if (i >= 0 && j >= 0 && k >= 0 && i < a->dims[0] && j < a->dims[1] && k < a->dims[2]) {
      const uint e = descend(children, levels, i, j, k);
      touches = hu[e] > hu_of_air;
      const uint flag = 1u << (8 * (e & 3u));
      if (touches && (atomic_or(&flags[e >> 2], flag) & flag) == 0) contacts[atomic_inc(&contact_count[substep])] = e;
    }
  }
#ifdef REAMSIM_GROUP_SIZE
  __local rs_i64 partial[6 * REAMSIM_GROUP_SIZE];
  const OutlineView outline = {pieces, numbers, lists, grid};
  LaneSums own = {{0, 0, 0}, {0, 0, 0}, 0};
  rs_point_force(a, &outline, x, y, z, &own);
  for (int c = 0; c < 3; ++c) {
    own.force[c] *= touches;
    own.torque[c] *= touches;
  }
  reduce_forces(partial, &sums[substep], &own);
#endif
}

/* ---- The cut of all ---- */

/* Cut: every listed voxel loses fill, takes energy and exerts a force (docs/physics.md, 4). Work-items stride over the
 * list, whose length only the device knows. */

/* The layout of a voxel (VoxelLayout). By default an 8-bit grade, 0 = air or removed,
 * and a claim bit; REAMSIM_FLAGGED_HU: a float HU, which converts back to the grade exactly, and a collision flag of a
 * byte; REAMSIM_BARE_GRADE: an 8-bit grade and no claim. A voxel is listed once, so that one work-item writes its flag;
 * bits share a word. */
#ifdef REAMSIM_FLAGGED_HU
typedef float Voxel;
typedef uchar Claim;
#define GRADE_OF(voxel) ((uchar)(int)floor(((voxel)-hu_of_air) / hu_per_grade + 0.5f))
#define AIR hu_of_air
#define RELEASE_CLAIM(e) claims[e] = 0
#else
typedef uchar Voxel;
typedef uint Claim;
#define GRADE_OF(voxel) (voxel)
#define AIR 0
#ifdef REAMSIM_BARE_GRADE
#define RELEASE_CLAIM(e)
#else
#define RELEASE_CLAIM(e) atomic_and(&claims[(e) >> 5], ~(1u << ((e)&31u)))
#endif
#endif

/* units_of_grade[256]: energy of a whole voxel; density_of_grade[256]: RS_DENSITY_SCALE; fill: 16 bits per voxel, or
 * one dummy entry when every voxel is whole (has_fill = 0); removed: (voxel, frame); hu_of_air, hu_per_grade: for
 * REAMSIM_FLAGGED_HU. */
__kernel void cut_voxels(const uint substep, __global const SubstepArgs* args, __global Voxel* bone,
                         __global ushort* fill, const int has_fill, __global Claim* claims,
                         __global const uint* contacts, __global const uint* contact_count, __global SubstepSums* sums,
                         __global uint2* removed, __global uint* removed_count, __global const long* units_of_grade,
                         __global const int* density_of_grade, __global const OutlinePiece* pieces,
                         __global const ushort* numbers, __global const PieceList* lists,
                         __global const OutlineGrid* grid, const float hu_of_air, const float hu_per_grade) {
  __global const SubstepArgs* a = args + substep;
  const uint count = contact_count[substep];
  const OutlineView outline = {pieces, numbers, lists, grid};
  SubstepSums part = {{0, 0, 0}, {0, 0, 0}, 0, 0, 0, 0};
  LaneSums law = {{0, 0, 0}, {0, 0, 0}, 0, 0};
  for (uint c = get_global_id(0); c < count; c += get_global_size(0)) {
    const uint e = contacts[c];
    const uchar grade = GRADE_OF(bone[e]);
    const int before = has_fill ? fill[e] : RS_WHOLE_FILL;
    const int lost = rs_lost_fill(a, density_of_grade[grade], before);
    part.contacts += 1;
    part.removed += lost;
    const long energy = rs_lost_energy(units_of_grade[grade], lost);
    part.energy += energy;
    if (a->law == RS_LAW_ENERGY) {
      const uint row = e / (uint)a->dims[0];
      rs_voxel_force(a, &outline, (int)(e % (uint)a->dims[0]), (int)(row % (uint)a->dims[1]),
                     (int)(row / (uint)a->dims[1]), rs_energy_mj(energy), &law);
    }
    if (has_fill) fill[e] = (ushort)(before - lost);
    if (lost == before) {
      bone[e] = AIR;
      removed[atomic_inc(removed_count)] = (uint2)(e, (uint)a->frame);
    }
    RELEASE_CLAIM(e);
  }
  rs_add_lanes(&part, &law);
  if (part.contacts != 0) add_substep_sums(&sums[substep], &part);
}

/* ---- Restoring ---- */

/* Restore removed voxels from a list of (voxel, value), for benchmarks that repeat a frame on the same bone. */

#define RESTORE(name, type)                                                                   \
  __kernel void name(__global const uint2* voxels, const uint count, __global type* values) { \
    const uint i = get_global_id(0);                                                          \
    if (i < count) values[voxels[i].x] = (type)voxels[i].y;                                   \
  }

RESTORE(restore_bytes, uchar)
RESTORE(restore_halves, ushort)
RESTORE(restore_words, uint) /* of any type, floats by their bits */
