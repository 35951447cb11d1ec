/* Exact erosion of a brick on a CPU (RS_LANES 16): a work-item takes a brick, with sixteen voxels in the lanes of a
 * vector. */
#ifndef REAMSIM_KERNELS_CUT_LANES_H
#define REAMSIM_KERNELS_CUT_LANES_H

#include "cut_window.h"

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
    if (rs_is_trial(a)) continue;
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
  return any(contacts > 0) && !rs_is_trial(a);
}

/* Adds the sums of a brick in a window to those of its substeps. */
void add_window_sums(__global const SubstepArgs* args, const SubstepWindow* window, __global const MotionWindow* w,
                     const WindowSums* sums, __global SubstepLanes* lanes) {
  for (uint f = 0; f < window->end - window->first; ++f) {
    long total[RS_WINDOW_SUMS] = {0};
    rs_finish_window_sums((const float*)(sums->sums + f), rs_window_time(w, args[window->first + f].frame), total);
    for (int i = 0; i < RS_WINDOW_SUMS; ++i) lanes[f].window[i] += total[i];
    lanes[f].removed += convert_long16(sums->lost_fill[f]);
    lanes[f].contacts += convert_long16(sums->contacts[f]);
  }
}

/* Cuts the candidates frame by frame. Returns whether any voxel loses fill. */
bool cut_framed(__global const SubstepArgs* args, const SubstepWindow* window, const OutlineView* outline, Visit* v,
                Candidates* c, RemovedReport* report, __global SubstepLanes* lanes) {
  bool cut = false;
  for (uint s = window->first; s < window->end; ++s) {
    set_substep(args + s, v);
    cut |= cut_candidates(args + s, outline, v, s, c, report, lanes + (s - window->first));
  }
  return cut;
}

/* Room for a brick in a visit. */
typedef struct {
  Candidates candidates, framed;
  WindowSums sums;
} Workspace;

void write_fill(const Candidates* c, __global ushort* fills) {
  for (int i = 0; i < c->count; ++i) fills[c->place[i]] = (ushort)c->fill[i];
}

/* Takes a brick through a window. `lanes`: of the window's first substep. Returns whether any voxel loses fill. */
bool cut_in_window(__global const SubstepArgs* args, const SubstepWindow* window, __global const MotionWindow* motions,
                   const OutlineView* outline, Visit* v, Workspace* work, RemovedReport* report,
                   __global SubstepLanes* lanes) {
#ifndef RS_DISTANCE_GRID
  if (window->motion >= 0) {
    __global const MotionWindow* w = motions + window->motion;
    bool cut = cut_smooth(args, window, w, outline, v, &work->candidates, &work->framed, &work->sums, report, lanes);
    if (cut) add_window_sums(args, window, w, &work->sums, lanes);
    if (work->framed.count > 0) {
      const bool smooth = brick_is_smooth(args + window->first, outline, v, window->shift_mm);
      finish_candidates(args + window->first, outline, v, smooth, window->shift_mm, &work->framed);
      cut |= cut_framed(args, window, outline, v, &work->framed, report, lanes);
    }
    return cut;
  }
#endif
  work->framed.count = 0;
  return cut_framed(args, window, outline, v, &work->candidates, report, lanes);
}

/* Takes a brick through all windows of a visit. Returns whether any voxel loses fill. */
bool cut_brick(__global const SubstepArgs* args, __global const SubstepWindow* windows, const uint window_count,
               __global const MotionWindow* motions, const OutlineView* outline, const uint slot,
               __global int* page_of_slot, __global uint* slot_of_page, __global ushort* pages,
               __global VisitCounts* counts, __global const float* energy_of_grade, Visit* v, Workspace* work,
               RemovedReport* report, __global SubstepLanes* lanes) {
  bool any_cut = false;
  for (uint w = 0; w < window_count; ++w) {
    const SubstepWindow window = windows[w];
    set_window(args + window.first, outline, v);
    const int page = page_of_slot[slot];
    find_candidates(args + window.first, outline, v, window.shift_mm * args->per_voxel_mm,
                    page < 0 ? 0 : pages + (ulong)page * RS_BRICK_VOXELS, energy_of_grade, &work->candidates);
    if (work->candidates.count == 0) continue;
    if (!cut_in_window(args, &window, motions, outline, v, work, report, lanes + (window.first - windows[0].first)))
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

/* Adds the sums of windows to lane 0. */
void add_window_lanes(const long* window, LaneSums* sums) {
  for (int i = 0; i < 3; ++i) {
    sums->force[i].s0 += window[i];
    sums->torque[i].s0 += window[3 + i];
  }
  sums->floor_energy.s0 += window[6];
  sums->energy.s0 += window[7];
}

#endif
