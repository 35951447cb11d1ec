// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Exact erosion on a CPU: the voxels of a brick that the tool's surface can intersect in a window of substeps.
 * Conservative: an extra voxel costs time and changes nothing. */
#ifndef REAMSIM_KERNELS_CANDIDATES_H
#define REAMSIM_KERNELS_CANDIDATES_H

#include "reach.h"
#include "visit.h"

/* The eight blocks of a brick: a section of its list with the pieces that can be nearest to a voxel of the block, and
 * whether that is a single piece with its ends out of reach. */
typedef struct {
  PieceList near[8];
  bool smooth[8];
} BlockPieces;

/* Candidates, padded to a multiple of 16 with voxels without fill. */
typedef struct {
  int count;
  ushort place[RS_BRICK_VOXELS + 16];
  int fill[RS_BRICK_VOXELS + 16];
  int face[RS_BRICK_VOXELS + 16];           /* bone_face.h */
  float energy[RS_BRICK_VOXELS + 16];       /* of the whole voxel, mJ */
  PieceList near[RS_BRICK_VOXELS / 16 + 1]; /* per sixteen: the pieces that can be nearest */
  bool smooth[RS_BRICK_VOXELS / 16 + 1];    /* per sixteen: one piece, with its ends out of reach */
} Candidates;

RS_INLINE float16 offset_x(const int16 place) {
  return convert_float16((place >> 6 & 1) << 2 | (place & 3));
}
RS_INLINE float16 offset_y(const int16 place) {
  return convert_float16((place >> 7 & 1) << 2 | (place >> 2 & 3));
}
RS_INLINE float16 offset_z(const int16 place) {
  return convert_float16((place >> 8 & 1) << 2 | (place >> 4 & 3));
}

/* Whether the surface is a single piece near the brick while the tool moves by `shift` mm: never asked of cutting
 * edges. */
RS_INLINE bool brick_is_smooth(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v,
                               const float shift) {
#ifdef RS_DISTANCE_GRID
  return false;
#else
  return rs_brick_is_smooth(a, outline, v->list, &v->middle, shift) != 0;
#endif
}

/* Distance of a voxel's centre from the surface minus the reach while the tool moves by `shift`, voxels. `near`: the
 * pieces that can be nearest; `smooth`: one piece, with its ends out of reach. */
RS_INLINE float16 distance_beyond_reach(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v,
                                        const PieceList near, const bool smooth, const float16 x, const float16 y,
                                        const float16 z, const float shift) {
#ifdef RS_DISTANCE_GRID
  const float slack = RS_CLIP_REACH + RS_GRID_STEEPEST * shift + RS_POSITION_SLACK * a->per_voxel_mm;
  return rs_clip_grid_distance(a, &v->teeth, &v->middle, x, y, z) * a->per_voxel_mm - slack;
#else
  if (smooth) return rs_distance_beyond_reach_of_piece(a, outline, near, &v->middle, x, y, z, shift);
  return rs_distance_beyond_reach(a, outline, near, &v->middle, x, y, z, shift);
#endif
}

/* Pads the brick's candidates, and finds the pieces that can be nearest while the tool moves by `shift` mm. */
RS_INLINE void finish_candidates(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v,
                                 const BlockPieces* blocks, const float shift, Candidates* c) {
  vstore16((ushort16)0, 0, c->place + c->count);
  vstore16((int16)0, 0, c->fill + c->count);
  vstore16((int16)RS_NO_FACE, 0, c->face + c->count);
  vstore16((float16)0.0f, 0, c->energy + c->count);
#ifndef RS_DISTANCE_GRID
  for (int i = 0; i < c->count; i += 16) {
    const int first = c->place[i] >> 6, last = c->place[min(i + 15, c->count - 1)] >> 6; /* places ascend */
    PieceList near = blocks->near[first];
    bool smooth = blocks->smooth[first];
    for (int block = first + 1; block <= last; ++block) {
      const PieceList other = blocks->near[block];
      smooth = smooth && blocks->smooth[block] && other.first == near.first;
      const uint end = max(near.first + near.count, other.first + other.count);
      near.first = min(near.first, other.first);
      near.count = end - near.first;
    }
    c->near[i >> 4] = near;
    c->smooth[i >> 4] = smooth;
    if (smooth) continue;
    const int16 place = convert_int16(vload16(0, c->place + i));
    c->smooth[i >> 4] = rs_find_nearest_pieces(a, outline, near, &v->middle, offset_x(place), offset_y(place),
                                               offset_z(place), shift, c->near + (i >> 4));
  }
#endif
}

/* Half the diagonal between the centres of a block of 4x4x4 voxels, voxels, rounded up. */
#define RS_BLOCK_RADIUS 2.6f

/* Sets `out` while the tool moves by `shift` voxels. `middle`: the distance of the middle (x, y, z) of each block from
 * the outline, mm, in the first eight lanes; `smooth`: of the brick. */
RS_INLINE void find_block_pieces(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v,
                                 const bool smooth, const float shift, const float16 x, const float16 y,
                                 const float16 z, const float16 middle, BlockPieces* out) {
  for (int block = 0; block < 8; ++block) {
    out->near[block] = v->list;
    out->smooth[block] = smooth;
  }
#ifndef RS_DISTANCE_GRID
  if (v->list.count == 1) return;
  uint begin[8], end[8] = {0};
  float16 p[3];
  const float16 r = rs_voxel_in_tool(a, &v->middle, x, y, z, p);
  const float slack = (RS_BLOCK_RADIUS + shift) * a->voxel_mm + RS_POSITION_SLACK;
  const float out_of_reach = slack + RS_CLIP_REACH * a->voxel_mm;
  uint ends_near = 0;
  for (uint i = 0; i < v->list.count; ++i) {
    const PieceList one = {v->list.first + i, 1};
    __global const OutlinePiece* piece = outline->pieces + outline->numbers[one.first];
    const int16 can_be = rs_abs(rs_outline_nearest(outline, one, r, p[2]).distance) <= rs_abs(middle) + 2.0f * slack;
    ends_near |= rs_lane_bits(can_be && rs_distance_to_ends(piece, r, p[2]) <= out_of_reach);
    for (uint blocks = rs_lane_bits(can_be) & 0xffu; blocks != 0; blocks &= blocks - 1) {
      const uint block = popcount((blocks & -blocks) - 1);
      if (end[block] == 0) begin[block] = i;
      end[block] = i + 1;
    }
  }
  for (int block = 0; block < 8; ++block) {
    if (end[block] == 0) continue;
    out->near[block].first = v->list.first + begin[block];
    out->near[block].count = end[block] - begin[block];
    out->smooth[block] = out->near[block].count == 1 && (ends_near >> block & 1u) == 0;
  }
#endif
}

/* Lists the places of the voxels that the surface can intersect, or that lie inside it, while the tool moves by `shift`
 * voxels, and sets `of`. Returns their number. */
RS_INLINE int list_places(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v, const bool smooth,
                          const float shift, BlockPieces* of, ushort* places) {
  const int16 lane = (int16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  int count = 0;
  /* First the eight blocks of 4x4x4 voxels, by the envelope; then layers of 16 voxels in the near blocks. */
  const float16 middle_x = convert_float16((lane & 1) << 2) + 1.5f, middle_y = convert_float16((lane & 2) << 1) + 1.5f,
                middle_z = convert_float16(lane & 4) + 1.5f;
  const float16 middle = rs_clip_distance(a, outline, v->list, &v->middle, middle_x, middle_y, middle_z);
  const float near = RS_CLIP_REACH + RS_BLOCK_RADIUS + 0.1f + shift + envelope_slack(v) * a->per_voxel_mm;
  const uint blocks = rs_lane_bits(middle * a->per_voxel_mm <= near);
  find_block_pieces(a, outline, v, smooth, shift, middle_x, middle_y, middle_z, middle, of);
  for (int block = 0; block < 8; ++block) {
    if ((blocks >> block & 1u) == 0) continue;
    const float16 x = convert_float16((block & 1) << 2 | (lane & 3)), y = convert_float16((block & 2) << 1 | lane >> 2);
    for (int layer = 0; layer < 4; ++layer) {
      const int first = block << 6 | layer << 4;
      const uint bone = v->brick->bone[first >> 5] >> (first & 31) & 0xffffu;
      if (bone == 0) continue;
      const float16 z = (float16)(float)((block & 4) | layer);
      uint rest = bone & rs_lane_bits(distance_beyond_reach(a, outline, v, of->near[block], of->smooth[block], x, y, z,
                                                            shift) <= 0.0f);
      for (; rest != 0; rest &= rest - 1) places[count++] = (ushort)(first + (int)popcount((rest & -rest) - 1));
    }
  }
  return count;
}

/* Finds the voxels of a brick that the surface can cut while the tool moves by `shift` voxels, and what can be nearest
 * to its blocks. */
RS_INLINE void find_candidates(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v,
                               const float shift, __global const ushort* page, __global const float* energy_of_grade,
                               BlockPieces* blocks, Candidates* c) {
  const float shift_mm = shift * a->voxel_mm;
  const bool smooth = brick_is_smooth(a, outline, v, shift_mm);
  const int count = list_places(a, outline, v, smooth, shift, blocks, c->place);
  for (int i = 0; i < count; ++i) {
    const int place = c->place[i];
    c->fill[i] = page == 0 ? RS_WHOLE_FILL : page[place];
    c->face[i] = rs_face_at(v->face_brick, v->faces, place);
    c->energy[i] = energy_of_grade[v->brick->grade[place]];
  }
  c->count = count;
  finish_candidates(a, outline, v, blocks, shift_mm, c);
}

#endif
