/* Exact erosion over bricks (docs/physics.md, 3): a voxel keeps the part outside the tool. A brick passes through all
 * substeps of a visit at once, because no voxel depends on another; forces are added to the slots of the substeps. The
 * substeps form windows, in which the tool moves so little that one list of candidate voxels serves all of them. On a
 * CPU (RS_LANES 16) a work-item takes a brick and clips sixteen voxels in the lanes of a vector. On a GPU a work-group
 * takes a brick, and its work-items stride over the voxels.
 *
 * Compiled with RS_POOLS and RS_POOL_BITS, and with RS_DISTANCE_GRID where the cutting edges are resolved: the tool's
 * distance then comes from their grid instead of the envelope's outline. */
#include "candidates.h"

/* Sums of a substep in a work-item, lane by lane. */
typedef struct {
#if defined(RS_LANES)
  LaneSums sums;
  long16 removed, contacts;
#else
  long unused;
#endif
} SubstepLanes;

#define PARAMETERS                                                                                                   \
  const uint first, const uint window_count, __global int *page_of_slot, __global uint *slot_of_page,                \
      __global ushort *pages, __global RemovedBlock *removed, __global const SubstepArgs *args,                      \
      __global const SubstepWindow *windows, __global const uint *listed, __global VisitCounts *counts,              \
      __global const uint *lattice_of_slot, __global uint *occupancy, const int4 bricks, __global SubstepSums *sums, \
      __global const float *energy_of_grade, __global const OutlinePiece *pieces, __global const ushort *numbers,    \
      __global const PieceList *lists, __global const OutlineGrid *grid, __global SubstepLanes *lanes_of_item,       \
      RS_POOL_PARAMETERS TEETH_PARAMETERS

#if defined(RS_LANES)

/* Marks the candidates without fill, of the sixteen from `first` on. */
void mark_removed(const Candidates* c, const int first, const int16 removed, uint* removed_words) {
  for (uint rest = bits_of(removed); rest != 0; rest &= rest - 1) {
    const int at = c->place[first + (int)popcount((rest & -rest) - 1)];
    removed_words[at >> 5] |= 1u << (at & 31);
  }
}

/* The tool next to the sixteen candidates from `first` on, and the fill of a whole voxel outside it. */
Clip clip_sixteen(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v, const Candidates* c,
                  const int first, int16* outside) {
  const int16 place = convert_int16(vload16(0, c->place + first));
  const float16 x = offset_x(place), y = offset_y(place), z = offset_z(place);
  Clip clip;
#ifndef RS_DISTANCE_GRID
  if (c->smooth[first >> 4]) {
    /* Here the compiler knows that there is no corner. */
    clip = rs_clip_smooth(a, outline->pieces + outline->numbers[c->near[first >> 4].first], v->corner, x, y, z);
    *outside = rs_fill_outside(&clip);
    return clip;
  }
#endif
  clip = clip_voxel(a, outline, v, c->near[first >> 4], x, y, z);
  *outside = rs_fill_outside(&clip);
  return clip;
}

/* Cuts the candidates in one substep, and adds the forces of cutting edges in contact. Returns whether any voxel loses
 * fill. */
bool cut_candidates(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v, const uint substep,
                    Candidates* c, RemovedReport* report, __global SubstepLanes* total) {
  SubstepLanes lanes = *total;
  int16 lost_sum = 0, contacts = 0, any_removed = 0;
  uint removed_words[RS_BRICK_WORDS] = {0};
  for (int i = 0; i < c->count; i += 16) {
    int16 outside;
    Clip clip = clip_sixteen(a, outline, v, c, i, &outside);
    const int16 before = vload16(0, c->fill + i), lost = rs_clip_loss(a, before, outside);
    if (rs_has_edge(a)) rs_edge_force(a, &clip, before - lost, outside, &lanes.sums);
    set_force_normal(outline, v->list, &clip);
    rs_clip_force(a, &clip, vload16(0, c->energy + i), lost, &lanes.sums);
    lost_sum += lost;
    contacts -= lost > 0;
    vstore16(before - lost, 0, c->fill + i);
    const int16 removed = lost > 0 && before == lost;
    any_removed |= removed;
    if (any(removed)) mark_removed(c, i, removed, removed_words);
  }
  lanes.removed += convert_long16(lost_sum);
  lanes.contacts += convert_long16(contacts);
  *total = lanes;
  if (any(any_removed)) {
    for (int block = 0; block < RS_BRICK_WORDS / 2; ++block)
      remove_voxels(v->brick, substep, block, removed_words[2 * block], removed_words[2 * block + 1], report);
  }
  return any(contacts > 0);
}

/* Takes a brick through all windows of a visit. Returns whether any voxel loses fill. */
bool cut_brick(__global const SubstepArgs* args, __global const SubstepWindow* windows, const uint window_count,
               const OutlineView* outline, const uint slot, __global int* page_of_slot, __global uint* slot_of_page,
               __global ushort* pages, __global VisitCounts* counts, __global const float* energy_of_grade, Visit* v,
               Candidates* candidates, RemovedReport* report, __global SubstepLanes* lanes) {
  bool any_cut = false;
  for (uint w = 0; w < window_count; ++w) {
    const SubstepWindow window = windows[w];
    set_window(args + window.first, outline, v);
    const int page = page_of_slot[slot];
    find_candidates(args + window.first, outline, v, window.shift_mm * args->per_voxel_mm,
                    page < 0 ? 0 : pages + (ulong)page * RS_BRICK_VOXELS, energy_of_grade, candidates);
    if (candidates->count == 0) continue;
    bool cut = false;
    for (uint s = window.first; s < window.end; ++s) {
      set_substep(args + s, v);
      cut |= cut_candidates(args + s, outline, v, s, candidates, report, lanes + (s - windows[0].first));
    }
    if (!cut) continue;
    any_cut = true;
    __global ushort* fills = find_or_add_page(slot, page_of_slot, slot_of_page, pages, counts);
    for (int i = 0; i < candidates->count; ++i) fills[candidates->place[i]] = (ushort)candidates->fill[i];
  }
  return any_cut;
}

__kernel void cut_exact(PARAMETERS) {
  const OutlineView outline = {pieces, numbers, lists, grid};
  const DistanceView teeth = TEETH_VIEW;
  __global Brick* pools[RS_POOLS] = RS_POOL_ARRAY;
  const uint end = windows[window_count - 1].end;
  __global SubstepLanes* lanes = lanes_of_item + get_global_id(0) * RS_VISIT_SUBSTEPS;
  const SubstepLanes zero = {zero_sums(), (long16)0, (long16)0};
  for (uint s = 0; s < end - first; ++s) lanes[s] = zero;
  RemovedReport report;
  begin_report(&report, removed, &counts->removed);
  Candidates candidates;
  for (uint t = get_global_id(0); t < counts->listed; t += get_global_size(0)) {
    const uint slot = listed[t];
    report.brick = lattice_of_slot[slot];
    Visit v;
    v.brick = pools[slot >> RS_POOL_BITS] + (slot & RS_POOL_MASK);
    v.at = brick_position(report.brick, bricks);
    v.teeth = teeth;
    if (cut_brick(args, windows, window_count, &outline, slot, page_of_slot, slot_of_page, pages, counts,
                  energy_of_grade, &v, &candidates, &report, lanes))
      clear_if_empty(v.brick, occupancy, v.at, bricks);
  }
  flush_report(&report);
  for (uint s = first; s < end; ++s) {
    const SubstepLanes total = lanes[s - first];
    const long contacts = add_lanes(total.contacts);
    if (contacts != 0 || rs_has_edge(args + s))
      add_brick_sums(&sums[s], &total.sums, 0, add_lanes(total.removed), contacts);
  }
}

#else

/* Cuts the work-item's voxels of the brick in one substep. */
void cut_voxels(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v, __global ushort* page,
                __global const float* energy_of_grade, __local uint* removed_words, __global SubstepSums* total) {
  LaneSums law = zero_sums();
  long removed = 0, contacts = 0;
  for (uint place = get_local_id(0); place < RS_BRICK_VOXELS; place += get_local_size(0)) {
    if ((v->brick->bone[place >> 5] >> (place & 31u) & 1u) == 0) continue;
    const int at = (int)place;
    Clip clip =
        clip_voxel(a, outline, v, v->list, (float)rs_offset_x(at), (float)rs_offset_y(at), (float)rs_offset_z(at));
    const int before = page[place];
    const int outside = rs_fill_outside(&clip), lost = rs_clip_loss(a, before, outside);
    if (rs_has_edge(a)) rs_edge_force(a, &clip, before - lost, outside, &law);
    if (lost == 0) continue;
    set_force_normal(outline, v->list, &clip);
    rs_clip_force(a, &clip, energy_of_grade[v->brick->grade[place]], lost, &law);
    page[place] = (ushort)(before - lost);
    removed += lost;
    contacts += 1;
    if (lost == before) atomic_or(&removed_words[place >> 5], 1u << (place & 31u));
  }
  if (contacts != 0 || rs_has_edge(a)) add_brick_sums(total, &law, 0, removed, contacts);
}

__kernel void cut_exact(PARAMETERS) {
  __local uint removed_words[RS_BRICK_WORDS];
  __local int page_here;
  const OutlineView outline = {pieces, numbers, lists, grid};
  const DistanceView teeth = TEETH_VIEW;
  __global Brick* pools[RS_POOLS] = RS_POOL_ARRAY;
  const uint end = windows[window_count - 1].end, listed_count = counts->listed;
  const uint item = get_local_id(0), items = get_local_size(0);
  RemovedReport report;
  begin_report(&report, removed, &counts->removed);
  /* All work-items of a group make the same number of iterations, so that all reach the barriers. */
  for (uint t = get_group_id(0); t < listed_count; t += get_num_groups(0)) {
    const uint slot = listed[t];
    report.brick = lattice_of_slot[slot];
    Visit v;
    v.brick = pools[slot >> RS_POOL_BITS] + (slot & RS_POOL_MASK);
    v.at = brick_position(report.brick, bricks);
    v.teeth = teeth;
    if (item == 0) {
      find_or_add_page(slot, page_of_slot, slot_of_page, pages, counts);
      page_here = page_of_slot[slot];
    }
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    __global ushort* page = pages + (ulong)page_here * RS_BRICK_VOXELS;
    for (uint s = first; s < end; ++s) {
      for (uint w = item; w < RS_BRICK_WORDS; w += items) removed_words[w] = 0;
      barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
      set_window(args + s, &outline, &v);
      cut_voxels(args + s, &outline, &v, page, energy_of_grade, removed_words, &sums[s]);
      barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
      for (uint block = item; block < 8; block += items)
        remove_voxels(v.brick, s, (int)block, removed_words[2 * block], removed_words[2 * block + 1], &report);
      barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    }
    if (item == 0) clear_if_empty(v.brick, occupancy, v.at, bricks);
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  }
  flush_report(&report);
}

#endif
