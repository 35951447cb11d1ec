// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Exact erosion of a brick on a GPU: a work-group takes a brick, and its work-items stride over the voxels. */
#ifndef REAMSIM_KERNELS_CUT_GROUP_H
#define REAMSIM_KERNELS_CUT_GROUP_H

#include "visit.h"

/* Voxels that a work-group fits and cuts before it sums their losses. */
#define VOXELS_AT_ONCE 64

/* A work-group in a window: losses and coefficients of some voxels, and sums of frames over all of the brick. */
typedef struct {
  ushort lost[RS_WINDOW_SUBSTEPS * VOXELS_AT_ONCE];
  float basis[VOXELS_AT_ONCE * 2 * RS_WINDOW_SUMS];
  float sums[RS_WINDOW_SUBSTEPS * 2 * RS_WINDOW_SUMS];
  int lost_fill[RS_WINDOW_SUBSTEPS], contacts[RS_WINDOW_SUBSTEPS];
} WindowSums;

/* Fits a voxel, and lowers its fill through the frames. `lost`, `basis`: of the voxel; the losses of consecutive frames
 * are VOXELS_AT_ONCE apart. Returns false where it must be cut frame by frame. */
RS_INLINE bool cut_smooth_voxel(__global const SubstepArgs* args, const SubstepWindow* window,
                                __global const MotionWindow* w, const OutlineView* outline, Visit* v,
                                const NodeMiddles* middles, const int place, const float whole, __global ushort* page,
                                __local ushort* lost, __local float* basis, __global SubstepSums* sums) {
  const float x = (float)rs_offset_x(place), y = (float)rs_offset_y(place), z = (float)rs_offset_z(place);
  const Clip c0 = rs_clip(&w->first, outline, v->list, &middles->first, x, y, z);
  const Clip c1 = rs_clip(&w->middle, outline, v->list, &middles->middle, x, y, z);
  const Clip c2 = rs_clip(&w->last, outline, v->list, &middles->last, x, y, z);
  WindowVoxel fit;
  rs_fit_voxel(w, &c0, &c1, &c2, whole, &fit);
  if (fit.pieces == 0.0f) return false;
  const int face = rs_face_at(v->face_brick, v->faces, place);
  const FaceCut cut = rs_face_cut(face, &c1.plane);
  int fill = page[place];
  for (uint s = window->first; s < window->end; ++s) {
    __global const SubstepArgs* a = args + s;
    const int outside = rs_window_outside(&fit, rs_window_time(w, a->frame), RS_WINDOW_PIECES);
    const int kept = rs_kept_fill(&cut, outside), loss = rs_clip_loss(a, fill, kept);
    fill -= loss;
    lost[VOXELS_AT_ONCE * (s - window->first)] = (ushort)loss;
    if (!rs_has_edge(a)) continue;
    set_substep(a, v);
    const Clip clip = rs_clip(a, outline, v->list, &v->middle, x, y, z);
    LaneSums edge = zero_sums();
    rs_edge_force(a, &clip, face, fill, kept, &edge);
    add_brick_sums(sums + s, &edge, 0, 0, 0);
  }
  page[place] = (ushort)fill;
  for (int i = 0; i < RS_WINDOW_SUMS; ++i) {
    basis[i] = fit.base[i];
    basis[RS_WINDOW_SUMS + i] = fit.slope[i];
  }
  return true;
}

/* Adds the losses of the voxels in frame `f`. */
RS_INLINE void add_losses(const uint f, __local WindowSums* sums) {
  float total[2 * RS_WINDOW_SUMS];
  __local float* to = sums->sums + 2 * RS_WINDOW_SUMS * f;
  for (int i = 0; i < 2 * RS_WINDOW_SUMS; ++i) total[i] = to[i];
  for (int voxel = 0; voxel < VOXELS_AT_ONCE; ++voxel) {
    const int lost = sums->lost[VOXELS_AT_ONCE * f + voxel];
    if (lost == 0) continue;
    const __local float* basis = sums->basis + 2 * RS_WINDOW_SUMS * voxel;
    for (int i = 0; i < 2 * RS_WINDOW_SUMS; ++i) total[i] = fma((float)lost, basis[i], total[i]);
    sums->lost_fill[f] += lost;
    sums->contacts[f] += 1;
  }
  for (int i = 0; i < 2 * RS_WINDOW_SUMS; ++i) to[i] = total[i];
}

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
    const int before = page[place], face = rs_face_at(v->face_brick, v->faces, at);
    const int kept = rs_clip_kept(&clip, face), lost = rs_clip_loss(a, before, kept);
    if (rs_has_edge(a)) rs_edge_force(a, &clip, face, before - lost, kept, &law);
    if (lost == 0) continue;
    set_force_normal(outline, v->list, &clip);
    rs_clip_force(a, &clip, energy_of_grade[v->brick->grade[place]], lost, &law);
    removed += lost;
    contacts += 1;
    if (rs_is_trial(a)) continue;
    page[place] = (ushort)(before - lost);
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
                       const OutlineView* outline, Visit* v, const NodeMiddles* middles, const uint first,
                       __global ushort* page, __global const float* energy_of_grade, __local GroupMemory* m,
                       __global SubstepSums* sums) {
  const uint item = get_local_id(0), items = get_local_size(0), count = window->end - window->first;
  for (uint i = item; i < VOXELS_AT_ONCE; i += items) {
    const uint place = first + i;
    __local ushort* lost = m->sums.lost + i;
    const bool bone = (v->brick->bone[place >> 5] >> (place & 31u) & 1u) != 0;
    const float whole = energy_of_grade[v->brick->grade[place]];
    if (bone && cut_smooth_voxel(args, window, w, outline, v, middles, (int)place, whole, page, lost,
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
    SubstepSums total = {{0}, {0}, 0, 0, from->lost_fill[f], from->contacts[f]};
    rs_finish_window_sums(parts, rs_window_time(w, args[window->first + f].frame), &total);
    add_substep_sums(&sums[window->first + f], &total);
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
    const NodeMiddles middles = node_middles(w, v);
    for (uint f = item; f < RS_WINDOW_SUBSTEPS; f += items) {
      m->sums.lost_fill[f] = m->sums.contacts[f] = 0;
      for (int i = 0; i < 2 * RS_WINDOW_SUMS; ++i) m->sums.sums[2 * RS_WINDOW_SUMS * f + i] = 0.0f;
    }
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    set_window(&w->middle, outline, v);
    for (uint first = 0; first < RS_BRICK_VOXELS; first += VOXELS_AT_ONCE) {
      cut_smooth_voxels(args, window, w, outline, v, &middles, first, page, energy_of_grade, m, sums);
      remove_smooth(window, v, first, m, page, report);
    }
    add_window_sums(args, window, w, &m->sums, sums);
  }
#endif
  barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  cut_framed(args, window, outline, v, page, energy_of_grade, m, report, sums);
}

#endif
