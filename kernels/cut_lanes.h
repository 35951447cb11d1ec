// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Exact erosion of a brick on a CPU (RS_LANES 16): a work-item takes a brick. Sixteen voxels lie in the lanes of a
 * vector while their losses are found frame by frame, and the sixteen coefficients of a voxel's force while these are
 * summed in a window of smooth motion (window.h): the sums of all frames are one product of matrices. */
#ifndef REAMSIM_KERNELS_CUT_LANES_H
#define REAMSIM_KERNELS_CUT_LANES_H

#include "candidates.h"

#define FRAMES_AT_ONCE 8

/* A lane counts its voxels that lose fill in a substep in units of this, and adds what they lose: at most 32 voxels of
 * a brick, which lose less than a unit. */
#define CONTACT_UNIT (1 << 21)

/* A brick in a window: losses of sixteen voxels by frame; their coefficients by voxel; sums of frames. */
typedef struct {
  float times[RS_WINDOW_SUBSTEPS];  /* of the substeps in the window */
  float16 lost[RS_WINDOW_SUBSTEPS]; /* vectors: PoCL divides vstore16 into four */
  float16 basis[16];
  float16 sums[RS_WINDOW_SUBSTEPS];
  int16 lost_fill[RS_WINDOW_SUBSTEPS]; /* and contacts, in units of CONTACT_UNIT */
  ulong removing;                      /* a bit per frame in which a voxel is removed */
  int removed_count;
  ushort removed_place[RS_BRICK_VOXELS];
  uchar removed_frame[RS_BRICK_VOXELS];
} WindowSums;

/* Fits sixteen voxels of the candidates from `first` on. Returns their faces against the tool. */
RS_INLINE FaceCut fit_sixteen(__global const MotionWindow* w, const OutlineView* outline, const NodeMiddles* middles,
                              const Candidates* c, const int first, WindowVoxel* out) {
  const int16 place = convert_int16(vload16(0, c->place + first));
  const float16 x = offset_x(place), y = offset_y(place), z = offset_z(place), whole = vload16(0, c->energy + first);
  const int16 face = vload16(0, c->face + first);
  const PieceList near = c->near[first >> 4];
  if (c->smooth[first >> 4]) {
    __global const OutlinePiece* piece = outline->pieces + outline->numbers[near.first];
    const Clip c0 = rs_clip_smooth(&w->first, piece, &middles->first, x, y, z);
    const Clip c1 = rs_clip_smooth(&w->middle, piece, &middles->middle, x, y, z);
    const Clip c2 = rs_clip_smooth(&w->last, piece, &middles->last, x, y, z);
    rs_fit_voxel(w, &c0, &c1, &c2, whole, out);
    return rs_face_cut(face, &c1.plane);
  }
  const Clip c0 = rs_clip(&w->first, outline, near, &middles->first, x, y, z);
  const Clip c1 = rs_clip(&w->middle, outline, near, &middles->middle, x, y, z);
  const Clip c2 = rs_clip(&w->last, outline, near, &middles->last, x, y, z);
  rs_fit_voxel(w, &c0, &c1, &c2, whole, out);
  return rs_face_cut(face, &c1.plane);
}

/* Lowers the fill of sixteen voxels through the frames. `pieces`: the most of any of them, and `faces`, whether any has
 * a face: constants where it is called, so that the fit stays in registers. */
__attribute__((always_inline)) RS_INLINE int16 lower_fill(__global const SubstepArgs* a, const int count,
                                                          const WindowVoxel* voxels, const int pieces, const bool faces,
                                                          const FaceCut* cuts, int16 fill, WindowSums* sums) {
  const WindowVoxel v = *voxels;
  const FaceCut cut = *cuts;
  const int16 more = a->min_loss - 1;
  for (int f = 0; f < count; ++f) {
    const int16 outside = rs_window_outside(&v, (float16)sums->times[f], pieces);
    const int16 kept = faces ? rs_kept_fill(&cut, outside) : outside;
    /* As rs_clip_loss(), written so that only a comparison and a choice wait for the frame before. */
    const int16 most_kept = kept + (more & (kept != 0)), before = fill;
    fill = fill > most_kept ? kept : fill;
    const int16 lost = before - fill;
    sums->lost_fill[f] += lost + (lost > 0 ? (int16)CONTACT_UNIT : (int16)0);
    sums->lost[f] = convert_float16(lost);
  }
  return fill;
}

/* Adds the forces of cutting edges in contact with sixteen voxels that had `fill` before the window. */
RS_INLINE void add_edge_forces(__global const SubstepArgs* args, const SubstepWindow* window,
                               const OutlineView* outline, Visit* v, const Candidates* c, const int first,
                               const WindowVoxel* fit, const FaceCut* face_cut, int16 fill, const WindowSums* from,
                               SubstepSums* sums) {
  const int16 place = convert_int16(vload16(0, c->place + first)), face = vload16(0, c->face + first);
  for (uint f = 0; f < window->end - window->first; ++f) {
    __global const SubstepArgs* a = args + window->first + f;
    set_substep(a, v);
    const Clip clip =
        rs_clip(a, outline, c->near[first >> 4], &v->middle, offset_x(place), offset_y(place), offset_z(place));
    fill -= convert_int16(from->lost[f]);
    const int16 outside = rs_window_outside(fit, (float16)from->times[f], RS_WINDOW_PIECES);
    LaneSums edge = zero_sums();
    rs_edge_force(a, &clip, face, fill, rs_kept_fill(face_cut, outside), &edge);
    rs_add_lanes(sums + f, &edge);
  }
  set_substep(args + window->first, v);
}

/* Adds the losses times the coefficients, voxel by voxel, so that the order does not depend on anything else. */
RS_INLINE void add_products(const int count, WindowSums* sums) {
  for (int f = 0; f < count; f += FRAMES_AT_ONCE) {
    const float* lost = (const float*)(sums->lost + f);
    float16* s = sums->sums + f;
    float16 s0 = s[0], s1 = s[1], s2 = s[2], s3 = s[3], s4 = s[4], s5 = s[5], s6 = s[6], s7 = s[7];
    for (int v = 0; v < 16; ++v) {
      const float16 basis = sums->basis[v];
      s0 = fma((float16)lost[v], basis, s0);
      s1 = fma((float16)lost[v + 16], basis, s1);
      s2 = fma((float16)lost[v + 32], basis, s2);
      s3 = fma((float16)lost[v + 48], basis, s3);
      s4 = fma((float16)lost[v + 64], basis, s4);
      s5 = fma((float16)lost[v + 80], basis, s5);
      s6 = fma((float16)lost[v + 96], basis, s6);
      s7 = fma((float16)lost[v + 112], basis, s7);
    }
    s[0] = s0, s[1] = s1, s[2] = s2, s[3] = s3, s[4] = s4, s[5] = s5, s[6] = s6, s[7] = s7;
  }
}

/* Notes the voxels that have lost all of their fill, and the frames in which they did. */
RS_INLINE void note_removed(const Candidates* c, const int first, const int16 removed, const int count,
                            WindowSums* sums) {
  for (uint rest = rs_lane_bits(removed); rest != 0; rest &= rest - 1) {
    const int lane = (int)popcount((rest & -rest) - 1);
    int f = count - 1;
    while (((const float*)(sums->lost + f))[lane] == 0.0f) --f;
    sums->removing |= 1ul << f;
    sums->removed_place[sums->removed_count] = c->place[first + lane];
    sums->removed_frame[sums->removed_count++] = (uchar)f;
  }
}

/* Clears the noted voxels, and reports them. */
RS_INLINE void remove_noted(const SubstepWindow* window, const Visit* v, const WindowSums* sums,
                            RemovedReport* report) {
  for (ulong rest = sums->removing; rest != 0; rest &= rest - 1) {
    const uint f = (uint)popcount((rest & -rest) - 1);
    uint words[RS_BRICK_WORDS] = {0};
    for (int i = 0; i < sums->removed_count; ++i) {
      const uint at = sums->removed_place[i];
      if (sums->removed_frame[i] == f) words[at >> 5] |= 1u << (at & 31);
    }
    for (int block = 0; block < RS_BRICK_WORDS / 2; ++block)
      remove_voxels(v->brick, window->first + f, block, words[2 * block], words[2 * block + 1], report);
  }
}

/* Appends the voxels in the lanes of `which` to `to`. */
RS_INLINE void append_candidates(const Candidates* from, const int first, const int16 which, Candidates* to) {
  for (uint rest = rs_lane_bits(which); rest != 0; rest &= rest - 1) {
    const int i = first + (int)popcount((rest & -rest) - 1);
    to->place[to->count] = from->place[i];
    to->fill[to->count] = from->fill[i];
    to->face[to->count] = from->face[i];
    to->energy[to->count++] = from->energy[i];
  }
}

/* Alternating elements of two vectors: those of their first and of their second halves. */
RS_INLINE float16 zip_low(const float16 a, const float16 b) {
  return (float16)(a.s0, b.s0, a.s1, b.s1, a.s2, b.s2, a.s3, b.s3, a.s4, b.s4, a.s5, b.s5, a.s6, b.s6, a.s7, b.s7);
}
RS_INLINE float16 zip_high(const float16 a, const float16 b) {
  return (float16)(a.s8, b.s8, a.s9, b.s9, a.sa, b.sa, a.sb, b.sb, a.sc, b.sc, a.sd, b.sd, a.se, b.se, a.sf, b.sf);
}

RS_INLINE void shuffle_rows(const float16* from, float16* to) {
  for (int i = 0; i < 8; ++i) {
    to[2 * i] = zip_low(from[i], from[i + 8]);
    to[2 * i + 1] = zip_high(from[i], from[i + 8]);
  }
}

/* Exchanges rows and columns: four perfect shuffles of 16 x 16 elements. */
RS_INLINE void transpose_sixteen(float16* rows) {
  float16 other[16];
  shuffle_rows(rows, other);
  shuffle_rows(other, rows);
  shuffle_rows(rows, other);
  shuffle_rows(other, rows);
}

/* Writes the coefficients voxel by voxel; zeros for those in the lanes of `without`. */
RS_INLINE void set_basis(const WindowVoxel* v, const int16 without, WindowSums* sums) {
  for (int i = 0; i < RS_WINDOW_SUMS; ++i) {
    sums->basis[i] = without ? (float16)0.0f : v->base[i];
    sums->basis[RS_WINDOW_SUMS + i] = without ? (float16)0.0f : v->slope[i];
  }
  transpose_sixteen(sums->basis);
}

/* Cuts the candidates in the window, except those that must be cut frame by frame, which are moved to `framed`. Returns
 * whether any voxel loses fill. */
bool cut_smooth(__global const SubstepArgs* args, const SubstepWindow* window, __global const MotionWindow* w,
                const OutlineView* outline, Visit* v, Candidates* c, Candidates* framed, WindowSums* work,
                RemovedReport* report, SubstepSums* sums) {
  const int count = (int)(window->end - window->first);
  const int padded = (count + FRAMES_AT_ONCE - 1) / FRAMES_AT_ONCE * FRAMES_AT_ONCE;
  const NodeMiddles middles = node_middles(w, v);
  for (int f = 0; f < count; ++f) work->times[f] = rs_window_time(w, args[window->first + f].frame);
  for (int f = 0; f < padded; ++f) {
    work->sums[f] = (float16)0.0f;
    work->lost_fill[f] = (int16)0;
    work->lost[f] = (float16)0.0f;
  }
  work->removing = 0;
  work->removed_count = 0;
  framed->count = 0;
  bool any_cut = false;
  for (int i = 0; i < c->count; i += 16) {
    WindowVoxel fit;
    const FaceCut cuts = fit_sixteen(w, outline, &middles, c, i, &fit);
    const int16 before = vload16(0, c->fill + i), face = vload16(0, c->face + i), without = fit.pieces == 0.0f;
    append_candidates(c, i, without && before > 0, framed);
    const int16 start = without ? (int16)0 : before;
    __global const SubstepArgs* a = args + window->first;
    const int16 fill = RS_ANY(face != RS_NO_FACE)  ? lower_fill(a, count, &fit, 3, true, &cuts, start, work)
                       : RS_ANY(fit.pieces > 2.0f) ? lower_fill(a, count, &fit, 3, false, &cuts, start, work)
                       : RS_ANY(fit.pieces > 1.0f) ? lower_fill(a, count, &fit, 2, false, &cuts, start, work)
                                                   : lower_fill(a, count, &fit, 1, false, &cuts, start, work);
    if (rs_has_edge(args)) add_edge_forces(args, window, outline, v, c, i, &fit, &cuts, start, work, sums);
    if (!RS_ANY(fill < start)) continue;
    any_cut = true;
    set_basis(&fit, without, work);
    add_products(padded, work);
    vstore16(without ? before : fill, 0, c->fill + i);
    const int16 removed = start > 0 && fill == 0;
    if (RS_ANY(removed)) note_removed(c, i, removed, count, work);
  }
  remove_noted(window, v, work, report);
  return any_cut;
}

/* Marks the candidates without fill, of the sixteen from `first` on. */
void mark_removed(const Candidates* c, const int first, const int16 removed, uint* removed_words) {
  for (uint rest = rs_lane_bits(removed); rest != 0; rest &= rest - 1) {
    const int at = c->place[first + (int)popcount((rest & -rest) - 1)];
    removed_words[at >> 5] |= 1u << (at & 31);
  }
}

/* The tool next to the sixteen candidates from `first` on, and the fill that it leaves. */
Clip clip_sixteen(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v, const Candidates* c,
                  const int first, int16* kept) {
  const int16 place = convert_int16(vload16(0, c->place + first)), face = vload16(0, c->face + first);
  const float16 x = offset_x(place), y = offset_y(place), z = offset_z(place);
  Clip clip;
#ifndef RS_DISTANCE_GRID
  if (c->smooth[first >> 4]) {
    /* The compiler sees that this branch has no corner. */
    clip = rs_clip_smooth(a, outline->pieces + outline->numbers[c->near[first >> 4].first], &v->middle, x, y, z);
    *kept = rs_clip_kept(&clip, face);
    return clip;
  }
#endif
  clip = clip_voxel(a, outline, v, c->near[first >> 4], x, y, z);
  *kept = rs_clip_kept(&clip, face);
  return clip;
}

/* Cuts the candidates in a substep, and adds the forces of edges in contact. Returns whether any voxel loses fill. */
bool cut_candidates(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v, const uint substep,
                    Candidates* c, RemovedReport* report, SubstepSums* total) {
  LaneSums law = zero_sums();
  int16 lost_sum = 0, contacts = 0, any_removed = 0;
  uint removed_words[RS_BRICK_WORDS] = {0};
  for (int i = 0; i < c->count; i += 16) {
    int16 kept;
    Clip clip = clip_sixteen(a, outline, v, c, i, &kept);
    const int16 before = vload16(0, c->fill + i), lost = rs_clip_loss(a, before, kept);
    if (rs_has_edge(a)) rs_edge_force(a, &clip, vload16(0, c->face + i), before - lost, kept, &law);
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
  rs_add_lanes(total, &law);
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
