// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Exact erosion of a brick on a CPU (RS_LANES 16): a work-item takes a brick, a vector's lanes sixteen voxels. */
#ifndef REAMSIM_KERNELS_CUT_LANES_H
#define REAMSIM_KERNELS_CUT_LANES_H

#include "cut_window.h"

/* Marks the candidates without fill, of the sixteen from `first` on. */
void mark_removed(const Candidates* c, const int first, const int16 removed, uint* removed_words) {
  for (uint rest = rs_lane_bits(removed); rest != 0; rest &= rest - 1) {
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
    /* The compiler sees that this branch has no corner. */
    clip = rs_clip_smooth(a, outline->pieces + outline->numbers[c->near[first >> 4].first], &v->middle, x, y, z);
    *outside = rs_fill_outside(&clip);
    return clip;
  }
#endif
  clip = clip_voxel(a, outline, v, c->near[first >> 4], x, y, z);
  *outside = rs_fill_outside(&clip);
  return clip;
}

/* Cuts the candidates in a substep, and adds the forces of edges in contact. Returns whether any voxel loses fill. */
bool cut_candidates(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v, const uint substep,
                    Candidates* c, RemovedReport* report, SubstepSums* total) {
  LaneSums law = zero_sums();
  int16 lost_sum = 0, contacts = 0, any_removed = 0;
  uint removed_words[RS_BRICK_WORDS] = {0};
  for (int i = 0; i < c->count; i += 16) {
    int16 outside;
    Clip clip = clip_sixteen(a, outline, v, c, i, &outside);
    const int16 before = vload16(0, c->fill + i), lost = rs_clip_loss(a, before, outside);
    if (rs_has_edge(a)) rs_edge_force(a, &clip, before - lost, outside, &law);
    set_force_normal(outline, v->list, &clip);
    rs_clip_force(a, &clip, vload16(0, c->energy + i), lost, &law);
    lost_sum += lost;
    contacts -= lost > 0;
    if (rs_is_trial(a)) continue;
    vstore16(before - lost, 0, c->fill + i);
    const int16 removed = lost > 0 && before == lost;
    any_removed |= removed;
    if (RS_ANY(removed)) mark_removed(c, i, removed, removed_words);
  }
  const int contact_count = add_int_lanes(contacts);
  if (contact_count == 0 && !rs_has_edge(a)) return false;
  add_law(&law, total);
  total->removed += add_int_lanes(lost_sum);
  total->contacts += contact_count;
  if (RS_ANY(any_removed)) {
    for (int block = 0; block < RS_BRICK_WORDS / 2; ++block)
      remove_voxels(v->brick, substep, block, removed_words[2 * block], removed_words[2 * block + 1], report);
  }
  return contact_count != 0 && !rs_is_trial(a);
}

/* Adds the sums of a brick in a window to those of its substeps. */
void add_window_sums(const int count, const WindowSums* from, SubstepSums* sums) {
  for (int f = 0; f < count; ++f) {
    rs_finish_window_sums((const float*)(from->sums + f), from->times[f], sums + f);
    sums[f].removed += add_int_lanes(from->lost_fill[f] & (CONTACT_UNIT - 1));
    sums[f].contacts += add_int_lanes(from->lost_fill[f] >> 21);
  }
}

/* Cuts the candidates frame by frame. Returns whether any voxel loses fill. */
bool cut_framed(__global const SubstepArgs* args, const SubstepWindow* window, const OutlineView* outline, Visit* v,
                Candidates* c, RemovedReport* report, SubstepSums* sums) {
  bool cut = false;
  for (uint s = window->first; s < window->end; ++s) {
    set_substep(args + s, v);
    cut |= cut_candidates(args + s, outline, v, s, c, report, sums + (s - window->first));
  }
  return cut;
}

/* Memory of a work-item: for a brick in a window, and its sums of the substeps of the visit. */
typedef struct {
  BlockPieces blocks;
  Candidates candidates, framed;
  WindowSums window;
  SubstepSums sums[RS_VISIT_SUBSTEPS];
} Workspace;

void write_fill(const Candidates* c, __global ushort* fills) {
  for (int i = 0; i < c->count; ++i) fills[c->place[i]] = (ushort)c->fill[i];
}

/* Takes a brick through a window. `sums`: of the window's first substep. Returns whether any voxel loses fill. */
bool cut_in_window(__global const SubstepArgs* args, const SubstepWindow* window, __global const MotionWindow* motions,
                   const OutlineView* outline, Visit* v, Workspace* work, RemovedReport* report, SubstepSums* sums) {
#ifndef RS_DISTANCE_GRID
  if (window->motion >= 0) {
    __global const MotionWindow* w = motions + window->motion;
    bool cut = cut_smooth(args, window, w, outline, v, &work->candidates, &work->framed, &work->window, report, sums);
    if (cut) add_window_sums((int)(window->end - window->first), &work->window, sums);
    if (work->framed.count > 0) {
      finish_candidates(args + window->first, outline, v, &work->blocks, window->shift_mm, &work->framed);
      cut |= cut_framed(args, window, outline, v, &work->framed, report, sums);
    }
    return cut;
  }
#endif
  work->framed.count = 0;
  return cut_framed(args, window, outline, v, &work->candidates, report, sums);
}

/* Takes a brick through all windows of a visit. Returns whether any voxel loses fill. */
bool cut_brick(__global const SubstepArgs* args, __global const SubstepWindow* windows, const uint window_count,
               __global const MotionWindow* motions, const OutlineView* outline, const uint slot,
               __global int* page_of_slot, __global uint* slot_of_page, __global ushort* pages,
               __global VisitCounts* counts, __global const float* energy_of_grade, Visit* v, Workspace* work,
               RemovedReport* report) {
  bool any_cut = false;
  for (uint w = 0; w < window_count; ++w) {
    const SubstepWindow window = windows[w];
    set_window(args + window.first, outline, v);
    const int page = page_of_slot[slot];
    find_candidates(args + window.first, outline, v, window.shift_mm * args->per_voxel_mm,
                    page < 0 ? 0 : pages + (ulong)page * RS_BRICK_VOXELS, energy_of_grade, &work->blocks,
                    &work->candidates);
    if (work->candidates.count == 0) continue;
    if (!cut_in_window(args, &window, motions, outline, v, work, report,
                       work->sums + (window.first - windows[0].first)))
      continue;
    any_cut = true;
    __global ushort* fills = find_or_add_page(slot, page_of_slot, slot_of_page, pages, counts);
    write_fill(&work->candidates, fills);
    write_fill(&work->framed, fills);
  }
  return any_cut;
}

/* Requests memory that will be read soon. */
RS_INLINE void prefetch_lines(__global const void* memory, const int bytes) {
#ifdef POCL_DEVICE_ADDRESS_BITS /* PoCL, whose compiler is clang; OpenCL's prefetch() does nothing there */
  for (int i = 0; i < bytes; i += 64) __builtin_prefetch((__global const char*)memory + i);
#endif
}

/* Requests what a brick reads: its bone, grades and page. */
RS_INLINE void prefetch_brick(__global const Brick* brick, const int page, __global const ushort* pages) {
  prefetch_lines(brick->bone, sizeof brick->bone);
  prefetch_lines(brick->grade, sizeof brick->grade);
  if (page >= 0) prefetch_lines(pages + (ulong)page * RS_BRICK_VOXELS, RS_BRICK_VOXELS * sizeof(ushort));
}

#endif
