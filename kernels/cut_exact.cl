/* Exact erosion over bricks (docs/physics.md, 3): a voxel keeps the part outside the tool. A brick passes through all
 * substeps of a visit at once, because no voxel depends on another; forces are added to the slots of the substeps. The
 * substeps form windows, in which the tool moves so little that one list of candidate voxels serves all of them. Where
 * the motion of a window is smooth, its voxels are cut in all of its frames at once (cut_window.h). On a CPU
 * (RS_LANES 16) a work-item takes a brick, with sixteen voxels in the lanes of a vector. On a GPU a work-group takes a
 * brick, and its work-items stride over the voxels.
 *
 * Compiled with RS_POOLS and RS_POOL_BITS, and with RS_DISTANCE_GRID where the cutting edges are resolved: the tool's
 * distance then comes from their grid instead of the envelope's outline. */
#include "cut_window.h"

#if !defined(RS_LANES)
typedef long SubstepLanes; /* no work-item has sums of its own */
#endif

#define PARAMETERS                                                                                                     \
  const uint first, const uint window_count, __global int *page_of_slot, __global uint *slot_of_page,                  \
      __global ushort *pages, __global RemovedBlock *removed, __global const SubstepArgs *args,                        \
      __global const SubstepWindow *windows, __global const MotionWindow *motions, __global const uint *listed,        \
      __global VisitCounts *counts, __global const uint *lattice_of_slot, __global uint *occupancy, const int4 bricks, \
      __global SubstepSums *sums, __global const float *energy_of_grade, __global const OutlinePiece *pieces,          \
      __global const ushort *numbers, __global const PieceList *lists, __global const OutlineGrid *grid,               \
      __global SubstepLanes *lanes_of_item, RS_POOL_PARAMETERS TEETH_PARAMETERS

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

__kernel void cut_exact(PARAMETERS) {
  const OutlineView outline = {pieces, numbers, lists, grid};
  const DistanceView teeth = TEETH_VIEW;
  __global Brick* pools[RS_POOLS] = RS_POOL_ARRAY;
  const uint end = windows[window_count - 1].end;
  __global SubstepLanes* lanes = lanes_of_item + get_global_id(0) * RS_VISIT_SUBSTEPS;
  const SubstepLanes zero = {zero_sums(), (long16)0, (long16)0, {0}};
  for (uint s = 0; s < end - first; ++s) lanes[s] = zero;
  RemovedReport report;
  begin_report(&report, removed, &counts->removed);
  Workspace work;
  for (uint t = get_global_id(0); t < counts->listed; t += get_global_size(0)) {
    const uint slot = listed[t], following = t + (uint)get_global_size(0);
    if (following < counts->listed) {
      const uint next = listed[following];
      prefetch_brick(pools[next >> RS_POOL_BITS] + (next & RS_POOL_MASK), page_of_slot[next], pages);
    }
    report.brick = lattice_of_slot[slot];
    Visit v;
    v.brick = pools[slot >> RS_POOL_BITS] + (slot & RS_POOL_MASK);
    v.at = brick_position(report.brick, bricks);
    v.teeth = teeth;
    if (cut_brick(args, windows, window_count, motions, &outline, slot, page_of_slot, slot_of_page, pages, counts,
                  energy_of_grade, &v, &work, &report, lanes))
      clear_if_empty(v.brick, occupancy, v.at, bricks);
  }
  flush_report(&report);
  for (uint s = first; s < end; ++s) {
    SubstepLanes total = lanes[s - first];
    add_window_lanes(total.window, &total.sums);
    const long contacts = add_lanes(total.contacts);
    if (contacts != 0 || rs_has_edge(args + s))
      add_brick_sums(&sums[s], &total.sums, 0, add_lanes(total.removed), contacts);
  }
}

#else

/* Cuts the work-item's voxels of the brick in one substep, of those in `places` (a bit each). */
void cut_voxels(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v, __global ushort* page,
                __global const float* energy_of_grade, __local const uint* places, __local uint* removed_words,
                __global SubstepSums* total) {
  LaneSums law = zero_sums();
  long removed = 0, contacts = 0;
  for (uint place = get_local_id(0); place < RS_BRICK_VOXELS; place += get_local_size(0)) {
    if ((places[place >> 5] & v->brick->bone[place >> 5] & 1u << (place & 31u)) == 0) continue;
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

/* Memory of a work-group. */
typedef struct {
  uint framed[RS_BRICK_WORDS];  /* voxels that are cut frame by frame, a bit each */
  uint removed[RS_BRICK_WORDS]; /* voxels removed in the current substep */
  WindowSums sums;
} GroupMemory;

/* Clears and reports the removed voxels of a substep. All work-items of the group call it. */
void remove_in_substep(const uint s, const Visit* v, __local GroupMemory* m, RemovedReport* report) {
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  for (uint block = get_local_id(0); block < 8; block += get_local_size(0))
    remove_voxels(v->brick, s, (int)block, m->removed[2 * block], m->removed[2 * block + 1], report);
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
}

/* Cuts the voxels of `framed` frame by frame. */
void cut_framed(__global const SubstepArgs* args, const SubstepWindow* window, const OutlineView* outline, Visit* v,
                __global ushort* page, __global const float* energy_of_grade, __local GroupMemory* m,
                RemovedReport* report, __global SubstepSums* sums) {
  uint any = 0;
  for (int word = 0; word < RS_BRICK_WORDS; ++word) any |= m->framed[word];
  barrier(CLK_LOCAL_MEM_FENCE); /* all have read it before the next window clears it */
  const uint end = any == 0 ? window->first : window->end;
  for (uint s = window->first; s < end; ++s) {
    for (uint w = get_local_id(0); w < RS_BRICK_WORDS; w += get_local_size(0)) m->removed[w] = 0;
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    set_window(args + s, outline, v);
    cut_voxels(args + s, outline, v, page, energy_of_grade, m->framed, m->removed, &sums[s]);
    remove_in_substep(s, v, m, report);
  }
}

/* Fits and cuts 64 voxels from `first` on, and notes those that must be cut frame by frame. */
void cut_smooth_voxels(__global const SubstepArgs* args, const SubstepWindow* window, __global const MotionWindow* w,
                       const OutlineView* outline, Visit* v, const NodeCorners* corners, const uint first,
                       __global ushort* page, __global const float* energy_of_grade, __local GroupMemory* m,
                       __global SubstepSums* sums) {
  const uint item = get_local_id(0), items = get_local_size(0), count = window->end - window->first;
  for (uint i = item; i < VOXELS_AT_ONCE; i += items) {
    const uint place = first + i;
    __local ushort* lost = m->sums.lost + i;
    const bool bone = (v->brick->bone[place >> 5] >> (place & 31u) & 1u) != 0;
    const float whole = energy_of_grade[v->brick->grade[place]];
    if (bone && cut_smooth_voxel(args, window, w, outline, v, corners, (int)place, whole, page, lost,
                                 m->sums.basis + 2 * RS_WINDOW_SUMS * i, sums))
      continue;
    if (bone) atomic_or(&m->framed[place >> 5], 1u << (place & 31u));
    for (uint f = 0; f < count; ++f) lost[VOXELS_AT_ONCE * f] = 0;
  }
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  for (uint f = item; f < count; f += items) add_losses(f, &m->sums);
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
}

/* Clears and reports the voxels of the brick that the window has emptied: those of 64 from `first` on. */
void remove_smooth(const SubstepWindow* window, const Visit* v, const uint first, __local GroupMemory* m,
                   __global const ushort* page, RemovedReport* report) {
  for (uint f = get_local_id(0); f < window->end - window->first; f += get_local_size(0)) {
    uint words[2] = {0, 0};
    for (uint i = 0; i < VOXELS_AT_ONCE; ++i) {
      if (page[first + i] != 0 || m->sums.lost[VOXELS_AT_ONCE * f + i] == 0) continue;
      bool last = true;
      for (uint later = f + 1; later < window->end - window->first; ++later)
        last = last && m->sums.lost[VOXELS_AT_ONCE * later + i] == 0;
      if (last) words[i >> 5] |= 1u << (i & 31u);
    }
    if ((words[0] | words[1]) == 0) continue;
    atomic_and((volatile __global uint*)&v->brick->bone[first >> 5], ~words[0]);
    atomic_and((volatile __global uint*)&v->brick->bone[(first >> 5) + 1], ~words[1]);
    report_removed(window->first + f, (int)(first >> 6), words[0], words[1], report);
  }
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
}

/* Adds the sums of a brick in a window to those of its substeps. */
void add_window_sums(__global const SubstepArgs* args, const SubstepWindow* window, __global const MotionWindow* w,
                     const __local WindowSums* from, __global SubstepSums* sums) {
  for (uint f = get_local_id(0); f < window->end - window->first; f += get_local_size(0)) {
    if (from->contacts[f] == 0) continue;
    float parts[2 * RS_WINDOW_SUMS];
    for (int i = 0; i < 2 * RS_WINDOW_SUMS; ++i) parts[i] = from->sums[2 * RS_WINDOW_SUMS * f + i];
    long total[RS_WINDOW_SUMS] = {0};
    rs_finish_window_sums(parts, rs_window_time(w, args[window->first + f].frame), total);
    LaneSums law = zero_sums();
    for (int i = 0; i < 3; ++i) {
      law.force[i] = total[i];
      law.torque[i] = total[3 + i];
    }
    law.floor_energy = total[6];
    law.energy = total[7];
    add_brick_sums(&sums[window->first + f], &law, 0, from->lost_fill[f], from->contacts[f]);
  }
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
}

/* Takes a brick through a window. All work-items of the group call it. */
void cut_in_window(__global const SubstepArgs* args, const SubstepWindow* window, __global const MotionWindow* motions,
                   const OutlineView* outline, Visit* v, __global ushort* page, __global const float* energy_of_grade,
                   __local GroupMemory* m, RemovedReport* report, __global SubstepSums* sums) {
  const uint item = get_local_id(0), items = get_local_size(0);
  const bool smooth = window->motion >= 0;
  for (uint w = item; w < RS_BRICK_WORDS; w += items) m->framed[w] = smooth ? 0u : 0xffffffffu;
#ifndef RS_DISTANCE_GRID
  if (smooth) {
    __global const MotionWindow* w = motions + window->motion;
    const NodeCorners corners = node_corners(w, v);
    for (uint f = item; f < RS_VISIT_SUBSTEPS; f += items) {
      m->sums.lost_fill[f] = m->sums.contacts[f] = 0;
      for (int i = 0; i < 2 * RS_WINDOW_SUMS; ++i) m->sums.sums[2 * RS_WINDOW_SUMS * f + i] = 0.0f;
    }
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    set_window(&w->middle, outline, v);
    for (uint first = 0; first < RS_BRICK_VOXELS; first += VOXELS_AT_ONCE) {
      cut_smooth_voxels(args, window, w, outline, v, &corners, first, page, energy_of_grade, m, sums);
      remove_smooth(window, v, first, m, page, report);
    }
    add_window_sums(args, window, w, &m->sums, sums);
  }
#endif
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  cut_framed(args, window, outline, v, page, energy_of_grade, m, report, sums);
}

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
