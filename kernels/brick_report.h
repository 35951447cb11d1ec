// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Sums and removed voxels of the kernels that cut bricks. For kernels only. */
#ifndef REAMSIM_KERNELS_BRICK_REPORT_H
#define REAMSIM_KERNELS_BRICK_REPORT_H

#include "cut_law.h"

/* Work-items collect this many records before they append them, because all share the counter of the list. */
#define RS_COLLECTED 32

/* The records of one work-item. */
typedef struct {
  __global RemovedBlock* removed;
  __global uint* removed_count;
  RemovedBlock collected[RS_COLLECTED];
  uint count;
  uint brick; /* index in the lattice of bricks */
} RemovedReport;

void begin_report(RemovedReport* report, __global RemovedBlock* removed, __global uint* removed_count) {
  report->removed = removed;
  report->removed_count = removed_count;
  report->count = 0;
}

/* Appends the collected records to the list. */
void flush_report(RemovedReport* report) {
  if (report->count == 0) return;
  __global RemovedBlock* to = report->removed + atomic_add(report->removed_count, report->count);
  for (uint i = 0; i < report->count; ++i) to[i] = report->collected[i];
  report->count = 0;
}

/* Reports the removed voxels `low`, `high` (a bit each) of a block of the brick. */
void report_removed(const uint substep, const int block, const uint low, const uint high, RemovedReport* report) {
  if (report->count == RS_COLLECTED) flush_report(report);
  RemovedBlock* record = report->collected + report->count++;
  record->brick = report->brick;
  record->detail = substep << 3 | (uint)block;
  record->removed = low | (ulong)high << 32;
}

/* Removes voxels of a block, and reports them. */
void remove_voxels(__global Brick* brick, const uint substep, const int block, const uint low, const uint high,
                   RemovedReport* report) {
  if ((low | high) == 0) return;
  brick->bone[2 * block] &= ~low;
  brick->bone[2 * block + 1] &= ~high;
  report_removed(substep, block, low, high, report);
}

LaneSums zero_sums(void) {
  LaneSums sums;
  for (int i = 0; i < 3; ++i) sums.force[i] = sums.torque[i] = RS_SUM(0);
  sums.floor_energy = sums.energy = RS_SUM(0);
  return sums;
}

#if defined(RS_LANES)
int add_int_lanes(const int16 v) {
  const int8 a = v.lo + v.hi;
  const int4 b = a.lo + a.hi;
  const int2 c = b.lo + b.hi;
  return c.x + c.y;
}
#endif

void add_brick_sums(__global SubstepSums* total, const LaneSums* law, const long energy, const long removed,
                    const long contacts) {
  SubstepSums part = {{0}, {0}, energy, 0, removed, contacts};
  rs_add_lanes(&part, law);
  add_substep_sums(total, &part);
}

/* Position of a brick in the lattice of bricks. */
int3 brick_position(const uint index, const int4 bricks) {
  const uint row = index / (uint)bricks.x;
  return (int3)((int)(index % (uint)bricks.x), (int)(row % (uint)bricks.y), (int)(row / (uint)bricks.y));
}

/* Clears the occupancy bit of an empty brick, so that later substeps skip it. */
void clear_occupied(__global uint* occupancy, const int3 at, const int4 bricks) {
  const int superbrick = (at.x >> 2) + ((bricks.x + 3) >> 2) * ((at.y >> 2) + ((bricks.y + 3) >> 2) * (at.z >> 2));
  const uint bit = (uint)((at.x & 3) | (at.y & 3) << 2 | (at.z & 3) << 4);
  atomic_and(&occupancy[2 * superbrick + (bit >> 5)], ~(1u << (bit & 31u)));
}

void clear_if_empty(__global const Brick* brick, __global uint* occupancy, const int3 at, const int4 bricks) {
  uint remaining = 0;
  for (int w = 0; w < RS_BRICK_WORDS; ++w) remaining |= brick->bone[w];
  if (remaining == 0) clear_occupied(occupancy, at, bricks);
}

#endif
