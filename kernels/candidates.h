/* Exact erosion on a CPU: the voxels of a brick that the tool's surface can intersect in a window of substeps.
 * Conservative: an extra voxel costs time and changes nothing. */
#ifndef REAMSIM_KERNELS_CANDIDATES_H
#define REAMSIM_KERNELS_CANDIDATES_H

#include "reach.h"
#include "visit.h"

#if defined(RS_LANES)

/* Candidates, padded to a multiple of 16 with voxels without fill. */
typedef struct {
  int count;
  ushort place[RS_BRICK_VOXELS + 16];
  int fill[RS_BRICK_VOXELS + 16];
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

#ifdef RS_DISTANCE_GRID

/* Whether the surface is a single piece near the brick: never asked of cutting edges. */
RS_INLINE bool brick_is_smooth(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v,
                               const float shift) {
  return false;
}

/* Distance of a voxel's centre from the cutting edges minus the reach while the tool moves by `shift`, voxels. */
RS_INLINE float16 distance_beyond_reach(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v,
                                        const bool smooth, const float16 x, const float16 y, const float16 z,
                                        const float shift) {
  const float slack = RS_CLIP_REACH + RS_GRID_STEEPEST * shift + RS_POSITION_SLACK * a->per_voxel_mm;
  return rs_clip_grid_distance(a, &v->teeth, &v->middle, x, y, z) * a->per_voxel_mm - slack;
}

#else

/* Whether the surface is a single piece near the brick while the tool moves by `shift` mm. */
RS_INLINE bool brick_is_smooth(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v,
                               const float shift) {
  return rs_brick_is_smooth(a, outline, v->list, &v->middle, shift) != 0;
}

/* Distance of a voxel's centre from the surface minus the reach while the tool moves by `shift`, voxels. `smooth`: of
 * its brick. */
RS_INLINE float16 distance_beyond_reach(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v,
                                        const bool smooth, const float16 x, const float16 y, const float16 z,
                                        const float shift) {
  if (smooth) return rs_distance_beyond_reach_of_piece(a, outline, v->list, &v->middle, x, y, z, shift);
  return rs_distance_beyond_reach(a, outline, v->list, &v->middle, x, y, z, shift);
}

#endif

/* Pads the candidates, and finds the pieces that can be nearest while the tool moves by `shift` mm. `smooth`: of the
 * brick. */
RS_INLINE void finish_candidates(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v,
                                 const bool smooth, const float shift, Candidates* c) {
  vstore16((ushort16)0, 0, c->place + c->count);
  vstore16((int16)0, 0, c->fill + c->count);
  vstore16((float16)0.0f, 0, c->energy + c->count);
#ifndef RS_DISTANCE_GRID
  for (int i = 0; i < c->count; i += 16) {
    c->near[i >> 4] = v->list;
    c->smooth[i >> 4] = smooth;
    if (smooth) continue;
    const int16 place = convert_int16(vload16(0, c->place + i));
    c->smooth[i >> 4] = rs_find_nearest_pieces(a, outline, v->list, &v->middle, offset_x(place), offset_y(place),
                                               offset_z(place), shift, c->near + (i >> 4));
  }
#endif
}

/* Lists the places of the voxels that the surface can intersect, or that lie inside it, while the tool moves by `shift`
 * voxels. Returns their number. */
RS_INLINE int list_places(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v, const bool smooth,
                          const float shift, ushort* places) {
  const int16 lane = (int16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  int count = 0;
  /* First the eight blocks of 4x4x4 voxels, by the envelope; then layers of 16 voxels in the near blocks. */
  const float16 middle = rs_clip_distance(a, outline, v->list, &v->middle, convert_float16((lane & 1) << 2) + 1.5f,
                                          convert_float16((lane & 2) << 1) + 1.5f, convert_float16(lane & 4) + 1.5f);
  const float near = RS_CLIP_REACH + 2.6f + 0.1f + shift + envelope_slack(v) * a->per_voxel_mm;
  const uint blocks = rs_lane_bits(middle * a->per_voxel_mm <= near);
  for (int block = 0; block < 8; ++block) {
    if ((blocks >> block & 1u) == 0) continue;
    const float16 x = convert_float16((block & 1) << 2 | (lane & 3)), y = convert_float16((block & 2) << 1 | lane >> 2);
    for (int layer = 0; layer < 4; ++layer) {
      const int first = block << 6 | layer << 4;
      const uint bone = v->brick->bone[first >> 5] >> (first & 31) & 0xffffu;
      if (bone == 0) continue;
      const float16 z = (float16)(float)((block & 4) | layer);
      uint rest = bone & rs_lane_bits(distance_beyond_reach(a, outline, v, smooth, x, y, z, shift) <= 0.0f);
      for (; rest != 0; rest &= rest - 1) places[count++] = (ushort)(first + (int)popcount((rest & -rest) - 1));
    }
  }
  return count;
}

/* Finds the voxels of a brick that the surface can cut while the tool moves by `shift` voxels. */
RS_INLINE void find_candidates(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v,
                               const float shift, __global const ushort* page, __global const float* energy_of_grade,
                               Candidates* c) {
  const float shift_mm = shift * a->voxel_mm;
  const bool smooth = brick_is_smooth(a, outline, v, shift_mm);
  const int count = list_places(a, outline, v, smooth, shift, c->place);
  for (int i = 0; i < count; ++i) {
    const int place = c->place[i];
    c->fill[i] = page == 0 ? RS_WHOLE_FILL : page[place];
    c->energy[i] = energy_of_grade[v->brick->grade[place]];
  }
  c->count = count;
  finish_candidates(a, outline, v, smooth, shift_mm, c);
}

#endif

#endif
