// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Exact erosion over bricks (docs/erosion.md, 3): a voxel keeps the part outside the tool. A brick passes through all
 * substeps of a visit at once, because no voxel depends on another; forces are added to the slots of the substeps. The
 * substeps form windows, in which the tool moves so little that one list of candidate voxels serves all of them. Where
 * the motion of a window is smooth, its voxels are cut in all of its frames at once (window.h).
 *
 * Compiled with RS_POOLS and RS_POOL_BITS, and with RS_DISTANCE_GRID where the cutting edges are resolved: the tool's
 * distance then comes from their grid instead of the envelope's outline. */
#include "visit.h"

#if defined(RS_LANES)
#include "cut_lanes.h"
#else
#include "cut_group.h"
#endif

#define PARAMETERS                                                                                                     \
  const uint first, const uint window_count, __global int *page_of_slot, __global uint *slot_of_page,                  \
      __global ushort *pages, __global RemovedBlock *removed, __global const SubstepArgs *args,                        \
      __global const SubstepWindow *windows, __global const MotionWindow *motions, __global const uint *listed,        \
      __global VisitCounts *counts, __global const uint *lattice_of_slot, __global uint *occupancy, const int4 bricks, \
      __global SubstepSums *sums, __global const float *energy_of_grade, __global const OutlinePiece *pieces,          \
      __global const ushort *numbers, __global const PieceList *lists, __global const OutlineGrid *grid,               \
      __global const int *face_brick_of_slot, __global const FaceBrick *face_bricks, __global const int *faces,        \
      RS_POOL_PARAMETERS TEETH_PARAMETERS

#if defined(RS_LANES)

__kernel void cut_exact(PARAMETERS) {
  const OutlineView outline = {pieces, numbers, lists, grid};
  const DistanceView teeth = TEETH_VIEW;
  __global Brick* pools[RS_POOLS] = RS_POOL_ARRAY;
  const uint end = windows[window_count - 1].end, listed_count = counts->listed;
  RemovedReport report;
  begin_report(&report, removed, &counts->removed);
  Workspace work;
  const SubstepSums zero = {{0}, {0}, 0, 0, 0, 0};
  for (uint s = 0; s < end - first; ++s) work.sums[s] = zero;
  uint following;
  for (uint t = atomic_inc(&counts->taken); t < listed_count; t = following) {
    const uint slot = listed[t];
    following = atomic_inc(&counts->taken);
    if (following < listed_count) {
      const uint next = listed[following];
      prefetch_brick(pools[next >> RS_POOL_BITS] + (next & RS_POOL_MASK), page_of_slot[next], pages);
    }
    report.brick = lattice_of_slot[slot];
    Visit v = {.brick = pools[slot >> RS_POOL_BITS] + (slot & RS_POOL_MASK),
               .at = brick_position(report.brick, bricks),
               .face_brick = face_brick_of(slot, face_brick_of_slot, face_bricks),
               .faces = faces,
               .teeth = teeth};
    bool any_cut = false;
    for (uint w = 0; w < window_count; ++w) {
      const SubstepWindow window = windows[w];
      set_window(args + window.first, &outline, &v);
      const int page = page_of_slot[slot];
      find_candidates(args + window.first, &outline, &v, window.shift_mm * args->per_voxel_mm,
                      page < 0 ? 0 : pages + (ulong)page * RS_BRICK_VOXELS, energy_of_grade, &work.blocks,
                      &work.candidates);
      if (work.candidates.count == 0) continue;
      if (!cut_in_window(args, &window, motions, &outline, &v, &work, &report, work.sums + (window.first - first)))
        continue;
      any_cut = true;
      __global ushort* fills = find_or_add_page(slot, page_of_slot, slot_of_page, pages, counts);
      write_fill(&work.candidates, fills);
      write_fill(&work.framed, fills);
    }
    if (any_cut) clear_if_empty(v.brick, occupancy, v.at, bricks);
  }
  flush_report(&report);
  for (uint s = first; s < end; ++s) {
    const SubstepSums* part = work.sums + (s - first);
    if (part->contacts != 0 || rs_has_edge(args + s)) add_substep_sums(&sums[s], part);
  }
}

#else

__kernel void cut_exact(PARAMETERS) {
  __local GroupMemory memory;
  __local int page_here;
  const OutlineView outline = {pieces, numbers, lists, grid};
  const DistanceView teeth = TEETH_VIEW;
  __global Brick* pools[RS_POOLS] = RS_POOL_ARRAY;
  const uint listed_count = counts->listed;
  const uint item = get_local_id(0);
  RemovedReport report;
  begin_report(&report, removed, &counts->removed);
  /* All work-items of a group make the same number of iterations, so that all reach the barriers. */
  for (uint t = get_group_id(0); t < listed_count; t += get_num_groups(0)) {
    const uint slot = listed[t];
    report.brick = lattice_of_slot[slot];
    Visit v = {.brick = pools[slot >> RS_POOL_BITS] + (slot & RS_POOL_MASK),
               .at = brick_position(report.brick, bricks),
               .face_brick = face_brick_of(slot, face_brick_of_slot, face_bricks),
               .faces = faces,
               .teeth = teeth};
    if (item == 0) {
      find_or_add_page(slot, page_of_slot, slot_of_page, pages, counts);
      page_here = page_of_slot[slot];
    }
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    __global ushort* page = pages + (ulong)page_here * RS_BRICK_VOXELS;
    for (uint w = 0; w < window_count; ++w) {
      const SubstepWindow window = windows[w];
      cut_in_window(args, &window, motions, &outline, &v, page, energy_of_grade, &memory, &report, sums);
    }
    if (item == 0) clear_if_empty(v.brick, occupancy, v.at, bricks);
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  }
  flush_report(&report);
}

#endif
