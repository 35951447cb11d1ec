// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// The cut of `exact` in C++: cut_exact.cl as it runs on a CPU, over the same structures.
#include "tests/bench/reference/exact_candidates.h"
#include "tests/bench/reference/exact_visit.h"
#include "tests/bench/reference/exact_window.h"
#include "tests/bench/reference/lanes.h"

namespace reamsim::reference::REAMSIM_TARGET {

namespace {

constexpr rs_u32 kBricksTaken = 4;  // that a thread takes at once

/// Memory of a thread.
struct Workspace {
  Candidates candidates, framed;
  WindowWork window;
  ThreadSums sums;
};

/// Lists the voxels in `lanes` (a bit each) of the candidates from `i` on as removed.
void list_removed_in(rs_u32 substep, rs_u32 brick, const Candidates& c, int i, rs_u32 lanes, WindowWork& work) {
  for (rs_u32 rest = lanes; rest != 0; rest &= rest - 1)
    work.removed_voxels[work.removed_count++] = {brick, c.place[i + __builtin_ctz(rest)], static_cast<rs_u16>(substep)};
}

/// The tool next to the candidates from `i` on.
Clip clip_candidates(const SubstepArgs& a, const OutlineView& outline, const BrickVisit& b, const Candidates& c,
                     int i) {
  const Ints place = ints_of(c.place + i);
  const Reals x = offset_x(place), y = offset_y(place), z = offset_z(place);
  const PieceList near = c.near[i / kLanes];
  if (!c.smooth[i / kLanes]) return rs_clip(&a, &outline, near, &b.middle, x, y, z);
  return rs_clip_smooth(&a, outline.pieces + outline.numbers[near.first], &b.middle, x, y, z);
}

/// Cuts the candidates in one substep. Returns whether any voxel loses fill.
bool cut_in_substep(const ExactVisit& v, rs_u32 substep, const BrickVisit& b, Candidates& c, Workspace& work) {
  const SubstepArgs& a = v.args[substep];
  LaneSums law{};
  rs_i64 contacts = 0;
  for (int i = 0; i < c.count; i += kLanes) {
    const Clip clip = clip_candidates(a, v.outline, b, c, i);
    const Ints before = load<Ints>(c.fill + i), lost = rs_clip_loss(&a, before, rs_fill_outside(&clip));
    const rs_u32 cut = rs_lane_bits(lost > 0);
    if (cut == 0) continue;
    contacts += __builtin_popcount(cut);
    rs_clip_force(&a, &clip, load<Reals>(c.energy + i), lost, &law);
    store(before - lost, c.fill + i);
    for (int lane = 0; lane < kLanes; ++lane) work.sums.of[substep].removed += lost[lane];
    list_removed_in(substep, v.bone.lattice_of_slot[b.slot], c, i, rs_lane_bits((lost > 0) & (lost == before)),
                    work.window);
  }
  if (contacts == 0) return false;
  work.sums.of[substep].contacts += contacts;
  rs_add_lanes(&work.sums.of[substep], &law);
  return true;
}

/// Cuts the candidates frame by frame. Returns whether any voxel loses fill.
bool cut_framed(const ExactVisit& v, const SubstepWindow& window, BrickVisit& b, Candidates& c, Workspace& work) {
  bool cut = false;
  for (rs_u32 s = window.first; s < window.end; ++s) {
    set_substep(v.args[s], b);
    cut |= cut_in_substep(v, s, b, c, work);
  }
  return cut;
}

/// Takes the candidates of a brick through a window. Returns whether any voxel loses fill.
bool cut_in_window(const ExactVisit& v, const SubstepWindow& window, BrickVisit& b, Workspace& work) {
  work.framed.count = 0;
  if (window.motion < 0) return cut_framed(v, window, b, work.candidates, work);
  bool cut = cut_smooth(v, window, b, work.candidates, work.framed, work.window, work.sums);
  if (work.framed.count > 0) {
    finish_candidates(v.args[window.first], v.outline, b, window.shift_mm, work.framed);
    cut |= cut_framed(v, window, b, work.framed, work);
  }
  return cut;
}

/// The page of a brick's fill. A brick without a page gets a new one of whole voxels.
rs_u16* find_or_add_page(ExactVisit& v, rs_u32 slot) {
  const bool whole = v.page_of_slot[slot] < 0;
  if (whole) v.page_of_slot[slot] = static_cast<rs_i32>(__atomic_fetch_add(&v.page_count, 1U, __ATOMIC_RELAXED));
  rs_u16* page = v.fills + static_cast<rs_i64>(RS_BRICK_VOXELS) * v.page_of_slot[slot];
  if (whole) __builtin_memset(page, 0xff, sizeof(rs_u16) * RS_BRICK_VOXELS);
  return page;
}

void write_fill(const Candidates& c, rs_u16* fills) {
  for (int i = 0; i < c.count; ++i) fills[c.place[i]] = static_cast<rs_u16>(c.fill[i]);
}

/// Clears the bits of the listed removed voxels, and reports them.
void remove_listed_voxels(ExactVisit& v, BrickVisit& b, WindowWork& work) {
  const auto count = static_cast<rs_u32>(work.removed_count);
  if (count == 0) return;
  work.removed_count = 0;
  for (rs_u32 i = 0; i < count; ++i) {
    const rs_u16 place = work.removed_voxels[i].place;
    b.brick->bone[place >> 5] &= ~(1U << (place & 31U));
  }
  RemovedVoxel* to = v.removed + __atomic_fetch_add(&v.removed_count, count, __ATOMIC_RELAXED);
  __builtin_memcpy(to, work.removed_voxels, sizeof(RemovedVoxel) * count);
  clear_if_empty(v.bone, *b.brick, b.at);
}

/// Requests what find_candidates() reads of a brick.
void prefetch_brick(const ExactVisit& v, rs_u32 slot) {
  constexpr int kLine = 64;
  const auto fetch = [](const void* from, int bytes) {
    for (int at = 0; at < bytes; at += kLine) __builtin_prefetch(static_cast<const char*>(from) + at);
  };
  fetch(v.bone.bricks + slot, static_cast<int>(sizeof(Brick)));
  const rs_i32 page = v.page_of_slot[slot];
  if (page >= 0)
    fetch(v.fills + static_cast<rs_i64>(RS_BRICK_VOXELS) * page, static_cast<int>(sizeof(rs_u16)) * RS_BRICK_VOXELS);
}

/// Takes a brick through all windows of the visit.
void cut_brick_in_visit(ExactVisit& v, rs_u32 slot, Workspace& work) {
  BrickVisit b{v.bone.bricks + slot, slot, position_of(v.bone, slot), {}, {}, false};
  for (rs_u32 w = 0; w < v.window_count; ++w) {
    const SubstepWindow& window = v.windows[w];
    set_window(v.args[window.first], v.outline, window.shift_mm, b);
    find_candidates(v, window, b, work.candidates);
    if (work.candidates.count == 0 || !cut_in_window(v, window, b, work)) continue;
    rs_u16* fills = find_or_add_page(v, slot);
    write_fill(work.candidates, fills);
    write_fill(work.framed, fills);
    remove_listed_voxels(v, b, work.window);
  }
}

void add_atomically(rs_i64& total, rs_i64 part) {
  if (part != 0) __atomic_fetch_add(&total, part, __ATOMIC_RELAXED);
}

/// Adds the sums of a thread to those of the visit.
void add_to_visit(ExactVisit& v, const ThreadSums& sums) {
  for (rs_u32 s = 0; s < v.windows[v.window_count - 1].end; ++s) {
    SubstepSums& total = v.sums[s];
    const SubstepSums& part = sums.of[s];
    for (int i = 0; i < 3; ++i) {
      add_atomically(total.force[i], part.force[i]);
      add_atomically(total.torque[i], part.torque[i]);
    }
    add_atomically(total.floor_energy, part.floor_energy);
    add_atomically(total.energy, part.energy);
    add_atomically(total.removed, part.removed);
    add_atomically(total.contacts, part.contacts);
  }
}

}  // namespace

void cut_exact(ExactVisit& visit) {
  Workspace work;
  work.window.removed_count = 0;
  work.sums = {};
  for (;;) {
    const rs_u32 first = __atomic_fetch_add(&visit.next_listed, kBricksTaken, __ATOMIC_RELAXED);
    if (first >= visit.listed_count) break;
    const rs_u32 rest = visit.listed_count - first, count = rest < kBricksTaken ? rest : kBricksTaken;
    for (rs_u32 i = first; i < first + count; ++i) {
      if (i + 1 < visit.listed_count) prefetch_brick(visit, visit.listed[i + 1]);
      cut_brick_in_visit(visit, visit.listed[i], work);
    }
  }
  add_to_visit(visit, work.sums);
}

}  // namespace reamsim::reference::REAMSIM_TARGET
