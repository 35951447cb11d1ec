// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Cut: every listed voxel loses fill, takes energy and exerts a force (docs/physics.md, 4). Work-items stride over the
 * list, whose length only the device knows. */
#include "cut_law.h"

/* The layout of a voxel (VoxelLayout of sim/engine/dense/dense_state.h). By default an 8-bit grade, 0 = air or removed,
 * and a claim bit; REAMSIM_FLAGGED_HU: a float HU, which converts back to the grade exactly, and a collision flag of a
 * byte; REAMSIM_BARE_GRADE: an 8-bit grade and no claim. A voxel is listed once, so that one work-item writes its flag;
 * bits share a word. */
#ifdef REAMSIM_FLAGGED_HU
typedef float Voxel;
typedef uchar Claim;
#define GRADE_OF(voxel) ((uchar)(int)floor(((double)(voxel)-hu_of_air) / hu_per_grade + 0.5))
#define AIR ((float)hu_of_air)
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

/* energy_of_grade[256]: mJ for a whole voxel; density_of_grade[256]: g/cm3; fill: 16 bits per voxel, or one dummy entry
 * when every voxel is whole (has_fill = 0); removed: (voxel, frame); hu_of_air, hu_per_grade: for
 * REAMSIM_FLAGGED_HU. */
__kernel void cut_voxels(const uint substep, __global const SubstepArgs* args, __global Voxel* bone,
                         __global ushort* fill, const int has_fill, __global Claim* claims,
                         __global const uint* contacts, __global const uint* contact_count, __global SubstepSums* sums,
                         __global uint2* removed, __global uint* removed_count, __global const double* energy_of_grade,
                         __global const double* density_of_grade, __global const OutlinePiece* pieces,
                         __global const ushort* numbers, __global const PieceList* lists,
                         __global const OutlineGrid* grid, const double hu_of_air, const double hu_per_grade) {
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
    const double energy = rs_lost_energy(energy_of_grade[grade], lost);
    part.energy += rs_energy_units(energy);
    if (a->law == RS_LAW_ENERGY) {
      const uint row = e / (uint)a->dims[0];
      rs_voxel_force(a, &outline, (int)(e % (uint)a->dims[0]), (int)(row % (uint)a->dims[1]),
                     (int)(row / (uint)a->dims[1]), (float)energy, &law);
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
