/* What the cuts over bricks report: removed voxels and sums. For kernels only. */
#ifndef REAMSIM_KERNELS_BRICK_REPORT_H
#define REAMSIM_KERNELS_BRICK_REPORT_H

#include "cut_law.h"
#pragma OPENCL EXTENSION cl_khr_int64_base_atomics : enable

/* Records of removed voxels wait until there are some, because all work-items take their places from one counter. */
#define WAITING 32

typedef struct {
  __global RemovedBlock* removed;
  __global uint* removed_count;
  RemovedBlock waiting[WAITING];
  uint waiting_count;
  uint brick; /* in the lattice */
} RemovedReport;

void begin_report(RemovedReport* report, __global RemovedBlock* removed, __global uint* removed_count) {
  report->removed = removed;
  report->removed_count = removed_count;
  report->waiting_count = 0;
}

void hand_over_removed(RemovedReport* report) {
  if (report->waiting_count == 0) return;
  __global RemovedBlock* to = report->removed + atomic_add(report->removed_count, report->waiting_count);
  for (uint i = 0; i < report->waiting_count; ++i) to[i] = report->waiting[i];
  report->waiting_count = 0;
}

void report_removed(RemovedReport* report, const uint substep, const int block, const uint low, const uint high) {
  if ((low | high) == 0) return;
  if (report->waiting_count == WAITING) hand_over_removed(report);
  RemovedBlock* record = report->waiting + report->waiting_count++;
  record->brick = report->brick;
  record->detail = substep << 3 | (uint)block;
  record->gone = low | (ulong)high << 32;
}

/* Adds force, torque (3 each), energy, floor energy, fill and contacts. */
void add_brick_sums(__global SubstepSums* total, const long* part) {
  for (int c = 0; c < 3; ++c) {
    if (part[c] != 0) atom_add(&total->force[c], part[c]);
    if (part[3 + c] != 0) atom_add(&total->torque[c], part[3 + c]);
  }
  atom_add(&total->energy, part[6]);
  if (part[7] != 0) atom_add(&total->floor_energy, part[7]);
  atom_add(&total->removed, part[8]);
  atom_add(&total->contacts, part[9]);
}

/* Clears the bit of a brick in which nothing is left, so that cells over it are passed over from now on. */
void clear_if_empty(__global const Brick* brick, __global uint* occupancy, const int x, const int y, const int z,
                    const int4 bricks) {
  uint left = 0;
  for (int w = 0; w < RS_BRICK_WORDS; ++w) left |= brick->bone[w];
  if (left != 0) return;
  const int superbrick = (x >> 2) + ((bricks.x + 3) >> 2) * ((y >> 2) + ((bricks.y + 3) >> 2) * (z >> 2));
  const uint bit = (uint)((x & 3) | (y & 3) << 2 | (z & 3) << 4);
  atomic_and(&occupancy[2 * superbrick + (bit >> 5)], ~(1u << (bit & 31u)));
}

#endif
