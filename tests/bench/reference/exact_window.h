// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "kernels/window.h"
#include "tests/bench/reference/exact_candidates.h"
#include "tests/bench/reference/lanes.h"

// A brick in a window of smooth motion (kernels/window.h), as in kernels/cut_window.h: the voxels lie in the lanes
// while they are fitted and while their fill is lowered frame by frame, the coefficients of force while these are
// summed.
namespace reamsim::reference::REAMSIM_TARGET {

constexpr int kCoefficients = 2 * RS_WINDOW_SUMS;  ///< of a voxel's force, torque and energies
constexpr int kVectors = kCoefficients / kLanes;   ///< that hold them
constexpr int kFramesAtOnce = kLanes / 2;          ///< sums that the registers hold

/// Sums of a thread over the voxels of its bricks, by slot.
struct ThreadSums {
  alignas(64) SubstepSums of[RS_VISIT_SUBSTEPS];
};

/// A brick in a window.
struct WindowWork {
  alignas(64) float lost[RS_WINDOW_SUBSTEPS * kLanes];         ///< by the voxels in the lanes, frame by frame
  alignas(64) float basis[kLanes * kCoefficients];             ///< coefficients, voxel by voxel
  alignas(64) float sums[RS_WINDOW_SUBSTEPS * kCoefficients];  ///< losses times coefficients, frame by frame
  alignas(64) rs_i32 removed[RS_WINDOW_SUBSTEPS * kLanes];     ///< lost fill, lane by lane
  rs_i32 contacts[RS_WINDOW_SUBSTEPS];
  int removed_count;
  RemovedVoxel removed_voxels[RS_BRICK_VOXELS];
};

/// The middle of a brick at the nodes of a window.
struct NodeMiddles {
  BrickMiddle first, middle, last;
};

inline NodeMiddles node_middles(const MotionWindow& w, const BrickPosition& at) {
  const rs_i32 x = RS_BRICK_SIDE * at.x, y = RS_BRICK_SIDE * at.y, z = RS_BRICK_SIDE * at.z;
  NodeMiddles out;
  rs_brick_in_tool(&w.first, x, y, z, &out.first);
  rs_brick_in_tool(&w.middle, x, y, z, &out.middle);
  rs_brick_in_tool(&w.last, x, y, z, &out.last);
  return out;
}

/// Fits the candidates from `i` on.
inline void fit_candidates(const MotionWindow& w, const OutlineView& outline, const NodeMiddles& middles,
                           const Candidates& c, int i, WindowVoxel& out) {
  const Ints place = ints_of(c.place + i);
  const Reals x = offset_x(place), y = offset_y(place), z = offset_z(place), whole = load<Reals>(c.energy + i);
  const PieceList near = c.near[i / kLanes];
  if (c.smooth[i / kLanes]) {
    const OutlinePiece* piece = outline.pieces + outline.numbers[near.first];
    const Clip first = rs_clip_smooth(&w.first, piece, &middles.first, x, y, z);
    const Clip middle = rs_clip_smooth(&w.middle, piece, &middles.middle, x, y, z);
    const Clip last = rs_clip_smooth(&w.last, piece, &middles.last, x, y, z);
    rs_fit_voxel(&w, &first, &middle, &last, whole, &out);
    return;
  }
  const Clip first = rs_clip(&w.first, &outline, near, &middles.first, x, y, z);
  const Clip middle = rs_clip(&w.middle, &outline, near, &middles.middle, x, y, z);
  const Clip last = rs_clip(&w.last, &outline, near, &middles.last, x, y, z);
  rs_fit_voxel(&w, &first, &middle, &last, whole, &out);
}

/// Lowers the fill of the voxels in the lanes, which have at most kPieces cubics, through the frames of a window, as
/// rs_clip_loss() does. Written so that the fill of a frame follows from that before by a comparison and a choice only.
template <int kPieces>
Ints lower_fill(const SubstepArgs& a, const float* times, int count, const WindowVoxel& voxels, Ints fill,
                WindowWork& work) {
  const WindowVoxel v = voxels;  // in registers
  const Ints min_loss = RS_INT(a.min_loss), one = RS_INT(1);
#pragma GCC unroll 2
  for (int f = 0; f < count; ++f) {
    const Ints outside = rs_window_outside(&v, RS_REAL(times[f]), kPieces);
    const Ints least_cut = outside + (outside == 0 ? one : min_loss);  // the least fill that is lowered
    const Ints before = fill;
    fill = least_cut <= fill ? outside : fill;
    const Ints lost = before - fill;
    store(load<Ints>(work.removed + kLanes * f) + lost, work.removed + kLanes * f);
    work.contacts[f] += __builtin_popcount(rs_bits_less(fill, before));
    store(RS_TO_REAL(lost), work.lost + kLanes * f);
  }
  return fill;
}

/// Exchanges rows and columns of a square of vectors.
inline void transpose(Reals* rows) {
  const Ints lane = first_numbers();
  for (int step = 1; step < kLanes; step *= 2) {
    const Ints low = (lane & step) != 0 ? lane + (kLanes - step) : lane;
    const Ints high = (lane & step) != 0 ? lane + kLanes : lane + step;
    for (int i = 0; i < kLanes; ++i) {
      if ((i & step) != 0) continue;
      const Reals a = rows[i], b = rows[i + step];
      rows[i] = __builtin_shuffle(a, b, low);
      rows[i + step] = __builtin_shuffle(a, b, high);
    }
  }
}

/// Writes the coefficients voxel by voxel; zeros for the lanes of `without`.
inline void set_basis(const WindowVoxel& v, Ints without, WindowWork& work) {
  Reals rows[kCoefficients];
  for (int i = 0; i < RS_WINDOW_SUMS; ++i) {
    rows[i] = without ? Reals{} : v.base[i];
    rows[RS_WINDOW_SUMS + i] = without ? Reals{} : v.slope[i];
  }
  for (int part = 0; part < kVectors; ++part) {
    transpose(rows + kLanes * part);
    for (int lane = 0; lane < kLanes; ++lane)
      store(rows[kLanes * part + lane], work.basis + kCoefficients * lane + kLanes * part);
  }
}

/// Adds the losses of the voxels in `lanes` (a bit each) times their coefficients, voxel by voxel, so that the order
/// does not depend on anything else.
inline void add_products(int padded, rs_u32 lanes, WindowWork& work) {
  for (int f = 0; f < padded; f += kFramesAtOnce) {
    Reals sums[kFramesAtOnce][kVectors];
    float* at = work.sums + kCoefficients * f;
    for (int k = 0; k < kFramesAtOnce; ++k)
      for (int part = 0; part < kVectors; ++part) sums[k][part] = load<Reals>(at + kCoefficients * k + kLanes * part);
    for (rs_u32 rest = lanes; rest != 0; rest &= rest - 1) {
      const int lane = __builtin_ctz(rest);
      const float *basis = work.basis + kCoefficients * lane, *lost = work.lost + kLanes * f + lane;
      for (int part = 0; part < kVectors; ++part) {
        const Reals coefficients = load<Reals>(basis + kLanes * part);
        for (int k = 0; k < kFramesAtOnce; ++k)
          sums[k][part] = RS_FMA(RS_REAL(lost[kLanes * k]), coefficients, sums[k][part]);
      }
    }
    for (int k = 0; k < kFramesAtOnce; ++k)
      for (int part = 0; part < kVectors; ++part) store(sums[k][part], at + kCoefficients * k + kLanes * part);
  }
}

/// Lists the voxels that have lost all of their fill. `lanes`: a bit each, of the candidates from `i` on; `first`: slot
/// of the window's first substep; `brick`: in the lattice of bricks.
inline void list_removed(const Candidates& c, int i, rs_u32 lanes, int count, rs_u32 first, rs_u32 brick,
                         WindowWork& work) {
  for (rs_u32 rest = lanes; rest != 0; rest &= rest - 1) {
    const int lane = __builtin_ctz(rest);
    int f = count - 1;
    while (work.lost[kLanes * f + lane] == 0.0F) --f;
    work.removed_voxels[work.removed_count++] = {brick, c.place[i + lane],
                                                 static_cast<rs_u16>(first + static_cast<rs_u32>(f))};
  }
}

/// Appends the candidates in `lanes` (a bit each) from `i` on to `to`.
inline void append_candidates(const Candidates& from, int i, rs_u32 lanes, Candidates& to) {
  for (rs_u32 rest = lanes; rest != 0; rest &= rest - 1) {
    const int at = i + __builtin_ctz(rest);
    to.place[to.count] = from.place[at];
    to.fill[to.count] = from.fill[at];
    to.energy[to.count++] = from.energy[at];
  }
}

/// Adds the sums of a brick in a window, rounded to integers, to those of its substeps. `first`: slot of the first.
inline void add_window_sums(const float* times, int count, rs_u32 first, WindowWork& work, ThreadSums& sums) {
  for (int f = 0; f < count; ++f) {
    SubstepSums& total = sums.of[first + static_cast<rs_u32>(f)];
    rs_finish_window_sums(work.sums + kCoefficients * f, times[f], &total);
    total.contacts += work.contacts[f];
    for (int lane = 0; lane < kLanes; ++lane) total.removed += work.removed[kLanes * f + lane];
  }
}

/// Cuts the candidates in a window, except those that must be cut frame by frame, which are moved to `framed`. Returns
/// whether any voxel loses fill.
inline bool cut_smooth(const ExactVisit& v, const SubstepWindow& window, const BrickVisit& b, Candidates& c,
                       Candidates& framed, WindowWork& work, ThreadSums& sums) {
  const MotionWindow& w = v.motions[window.motion];
  const SubstepArgs& a = v.args[window.first];
  const float* times = v.times + window.first;
  const int count = static_cast<int>(window.end - window.first);
  const int padded = (count + kFramesAtOnce - 1) / kFramesAtOnce * kFramesAtOnce;
  const NodeMiddles middles = node_middles(w, b.at);
  const rs_u32 brick = v.bone.lattice_of_slot[b.slot];
  __builtin_memset(work.sums, 0, sizeof(float) * kCoefficients * static_cast<unsigned>(padded));
  __builtin_memset(work.removed, 0, sizeof(rs_i32) * kLanes * static_cast<unsigned>(count));
  __builtin_memset(work.contacts, 0, sizeof work.contacts);
  for (int f = count; f < padded; ++f) store(Reals{}, work.lost + kLanes * f);
  bool any_cut = false;
  for (int i = 0; i < c.count; i += kLanes) {
    WindowVoxel fit;
    fit_candidates(w, v.outline, middles, c, i, fit);
    const Ints before = load<Ints>(c.fill + i), without = fit.pieces == 0.0F;
    append_candidates(c, i, rs_lane_bits(without & (before > 0)), framed);
    const Ints start = without ? Ints{} : before;
    const Ints fill = RS_ANY(fit.pieces > 2.0F)   ? lower_fill<3>(a, times, count, fit, start, work)
                      : RS_ANY(fit.pieces > 1.0F) ? lower_fill<2>(a, times, count, fit, start, work)
                                                  : lower_fill<1>(a, times, count, fit, start, work);
    const rs_u32 cut = rs_lane_bits(fill < start);
    if (cut == 0) continue;
    any_cut = true;
    set_basis(fit, without, work);
    add_products(padded, cut, work);
    store(without ? before : fill, c.fill + i);
    list_removed(c, i, rs_lane_bits((start > 0) & (fill == 0)), count, window.first, brick, work);
  }
  if (any_cut) add_window_sums(times, count, window.first, work, sums);
  return any_cut;
}

}  // namespace reamsim::reference::REAMSIM_TARGET
