// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "kernels/reach.h"
#include "kernels/window.h"
#include "tests/bench/reference/brick_places.h"
#include "tests/bench/reference/exact_visit.h"
#include "tests/bench/reference/lanes.h"

// The voxels of a brick that the tool's surface can intersect in a window, as in kernels/candidates.h.
namespace reamsim::reference::REAMSIM_TARGET {

/// A brick in a visit.
struct BrickVisit {
  Brick* brick;
  rs_u32 slot;
  BrickPosition at;
  BrickMiddle middle;  ///< in the current substep
  PieceList list;      ///< pieces of the outline that can be nearest in the current window
  bool smooth;         ///< a single one, with its ends out of reach
};

/// Candidates, padded to a multiple of the lanes with voxels without fill.
struct Candidates {
  int count;
  rs_u16 place[RS_BRICK_VOXELS + kPadding];
  rs_i32 fill[RS_BRICK_VOXELS + kPadding];
  float energy[RS_BRICK_VOXELS + kPadding];      ///< of the whole voxel, mJ
  PieceList near[RS_BRICK_VOXELS / kLanes + 1];  ///< per vector: the pieces that can be nearest
  bool smooth[RS_BRICK_VOXELS / kLanes + 1];     ///< per vector: one piece, with its ends out of reach
};

inline Ints first_numbers() {
  Ints out;
  for (int lane = 0; lane < kLanes; ++lane) out[lane] = lane;
  return out;
}

inline void set_substep(const SubstepArgs& a, BrickVisit& b) {
  rs_brick_in_tool(&a, RS_BRICK_SIDE * b.at.x, RS_BRICK_SIDE * b.at.y, RS_BRICK_SIDE * b.at.z, &b.middle);
}

/// set_substep() for the first substep of a window.
inline void set_window(const SubstepArgs& a, const OutlineView& outline, float shift_mm, BrickVisit& b) {
  set_substep(a, b);
  b.list = rs_pieces_near_brick(&outline, &b.middle);
  b.smooth = rs_brick_is_smooth(&a, &outline, b.list, &b.middle, shift_mm) != 0;
}

/// The blocks of 4×4×4 voxels that the surface can reach, as bits. `shift`: motion of the tool, voxels.
inline rs_u32 near_blocks(const SubstepArgs& a, const OutlineView& outline, const BrickVisit& b, float shift) {
  constexpr float kBlockRadius = 2.6F, kBulge = 0.1F;
  const float near = RS_CLIP_REACH + kBlockRadius + kBulge + shift;
  rs_u32 out = 0;
  for (int first = 0; first < RS_BRICK_WORDS / 2; first += kLanes) {
    const Ints block = (first_numbers() + first) << 6;
    const Reals distance = rs_clip_distance(&a, &outline, b.list, &b.middle, offset_x(block) + 1.5F,
                                            offset_y(block) + 1.5F, offset_z(block) + 1.5F);
    out |= rs_lane_bits(distance * a.per_voxel_mm <= near) << first;
  }
  return out & 0xffU;
}

/// Pads the candidates, and finds the pieces that can be nearest while the tool moves by `shift` mm.
inline void finish_candidates(const SubstepArgs& a, const OutlineView& outline, const BrickVisit& b, float shift,
                              Candidates& c) {
  store(Shorts{}, c.place + c.count);
  store(Ints{}, c.fill + c.count);
  store(Reals{}, c.energy + c.count);
  for (int i = 0; i < c.count; i += kLanes) {
    c.near[i / kLanes] = b.list;
    c.smooth[i / kLanes] = b.smooth;
    if (b.smooth) continue;
    const Ints place = ints_of(c.place + i);
    c.smooth[i / kLanes] = rs_find_nearest_pieces(&a, &outline, b.list, &b.middle, offset_x(place), offset_y(place),
                                                  offset_z(place), shift, c.near + i / kLanes) != 0;
  }
}

/// Reads fill and energy of the candidates.
inline void read_candidates(const ExactVisit& v, const BrickVisit& b, Candidates& c) {
  const rs_i32 page = v.page_of_slot[b.slot];
  const rs_u16* fills = v.fills + static_cast<rs_i64>(RS_BRICK_VOXELS) * page;
  for (int i = 0; i < c.count; ++i) {
    c.fill[i] = page < 0 ? RS_WHOLE_FILL : fills[c.place[i]];
    c.energy[i] = v.energy[b.brick->grade[c.place[i]]];
  }
}

/// The voxels of a smooth brick that the surface can reach while the tool moves by `shift` voxels, as bits. The width
/// of the voxels is found only where it decides.
inline rs_u32 voxels_in_reach_of_piece(const SubstepArgs& a, const OutlineView& outline, const BrickVisit& b,
                                       Ints place, float shift) {
  const float narrowest = 0.5F, slack = shift + RS_POSITION_SLACK * a.per_voxel_mm;
  const OutlinePiece* piece = outline.pieces + outline.numbers[b.list.first];
  Reals p[3];
  rs_voxel_in_tool(&a, &b.middle, offset_x(place), offset_y(place), offset_z(place), p);
  const Reals r = RS_SQRT(p[0] * p[0] + p[1] * p[1]);
  const PieceDistance away = rs_circle_distance(piece, r, p[2]);
  const Reals distance = away.distance * a.per_voxel_mm - slack;
  const rs_u32 near = rs_lane_bits(distance <= RS_CLIP_REACH), sure = rs_lane_bits(distance <= narrowest);
  if (near == sure) return sure;
  const NearestPiece nearest = rs_nearest_piece(&away, RS_REAL(piece->curvature), Ints{});
  return rs_lane_bits(distance <= rs_half_width(&a, &outline, b.list, &nearest, p, r, slack));
}

/// Finds the voxels that the surface can intersect, or that lie inside it, in a window.
inline void find_candidates(const ExactVisit& v, const SubstepWindow& window, const BrickVisit& b, Candidates& c) {
  const SubstepArgs& a = v.args[window.first];
  const float shift = window.shift_mm * a.per_voxel_mm;
  const rs_u32 blocks = near_blocks(a, v.outline, b, shift);
  rs_u32 words[RS_BRICK_WORDS] = {};
  for (int first = 0; first < RS_BRICK_VOXELS; first += kLanes) {
    constexpr rs_u32 kAll = (1U << kLanes) - 1U;
    const rs_u32 bone = b.brick->bone[first >> 5] >> (first & 31) & kAll;
    if ((blocks >> (first >> 6) & 1U) == 0 || bone == 0) continue;
    const Ints place = first_numbers() + first;
    const rs_u32 near = b.smooth
                            ? voxels_in_reach_of_piece(a, v.outline, b, place, shift)
                            : rs_lane_bits(rs_distance_beyond_reach(&a, &v.outline, b.list, &b.middle, offset_x(place),
                                                                    offset_y(place), offset_z(place), shift) <= 0.0F);
    words[first >> 5] |= (bone & near) << (first & 31);
  }
  c.count = list_places(words, v.bits_of_byte, c.place);
  read_candidates(v, b, c);
  finish_candidates(a, v.outline, b, window.shift_mm, c);
}

}  // namespace reamsim::reference::REAMSIM_TARGET
