/* Exact erosion on a CPU: the voxels of a brick that the tool's surface can intersect in a window of substeps.
 * Conservative: an extra voxel costs time and changes nothing. */
#ifndef REAMSIM_KERNELS_CANDIDATES_H
#define REAMSIM_KERNELS_CANDIDATES_H

#include "visit.h"

#if defined(RS_LANES)

/* Bound of the error of positions in single precision, mm. */
#define POSITION_SLACK 1e-4f

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

/* For sixteen voxels: the section of the brick's list with all pieces that can be nearest to any of them while the tool
 * moves by `shift` mm, and whether it is a single piece with its ends out of reach. */
RS_INLINE void find_nearest_pieces(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v,
                                   const int16 place, const float shift, PieceList* near, bool* smooth) {
  const PieceList list = v->list;
  float16 p[3];
  rs_voxel_in_tool(a, v->corner, offset_x(place), offset_y(place), offset_z(place), p);
  const float16 r = sqrt(p[0] * p[0] + p[1] * p[1]);
  const float16 limit = fabs(rs_outline_nearest(outline, list, r, p[2]).distance) + 2.0f * (shift + POSITION_SLACK);
  uint begin = list.count, end = 0;
  for (uint i = 0; i < list.count; ++i) {
    const PieceList one = {list.first + i, 1};
    if (!any(fabs(rs_outline_nearest(outline, one, r, p[2]).distance) <= limit)) continue;
    begin = min(begin, i);
    end = i + 1;
  }
  near->first = list.first + begin;
  near->count = end - begin;
  __global const OutlinePiece* piece = outline->pieces + outline->numbers[near->first];
  const float margin = RS_CLIP_REACH * a->voxel_mm + shift + POSITION_SLACK;
  *smooth = near->count == 1 && all(rs_distance_to_ends(piece, r, p[2]) > margin);
}

#ifdef RS_DISTANCE_GRID

/* Distance of a voxel's centre from the cutting edges minus the reach while the tool moves by `shift`, voxels. */
RS_INLINE float16 distance_beyond_reach(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v,
                                        const float16 x, const float16 y, const float16 z, const float shift) {
  const float slack = RS_CLIP_REACH + RS_GRID_STEEPEST * shift + POSITION_SLACK * a->per_voxel_mm;
  return rs_clip_grid_distance(a, &v->teeth, v->corner, x, y, z) * a->per_voxel_mm - slack;
}

#else

/* Bound of half the width of a voxel along the surface's normal while the tool moves by `shift`, voxels. The normal
 * rotates with the curvature of the surface and with the tool; next to a sharp corner it is discontinuous. */
RS_INLINE float16 half_width(__global const SubstepArgs* a, const OutlineView* outline, const PieceList list,
                             const NearestPiece* nearest, const float16 px, const float16 py, const float16 r,
                             const float shift) {
  const float widest = RS_CLIP_REACH;
  __global const OutlinePiece* piece = outline->pieces + outline->numbers[list.first];
  if (list.count > 1 || piece->before >= 0 || piece->after >= 0) return (float16)widest;
  const float16 per_r = 1.0f / fmax(r, 0.5f * a->voxel_mm);
  const ClipPlane plane = rs_clip_plane(a, px * per_r, py * per_r, nearest->normal_r, nearest->normal_z,
                                        nearest->distance, nearest->curvature, per_r);
  const float16 turn = (fabs(nearest->curvature) + fabs(nearest->normal_r) * per_r) * a->voxel_mm;
  const float16 width = 0.5f * (fabs(plane.n[0]) + fabs(plane.n[1]) + fabs(plane.n[2]));
  return fmin(width + (turn * (1.0f / 24.0f) + 0.02f) + shift * (2.0f * turn + 0.1f), widest);
}

/* Distance of a voxel's centre from the surface minus the reach while the tool moves by `shift`, voxels. */
RS_INLINE float16 distance_beyond_reach(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v,
                                        const float16 x, const float16 y, const float16 z, const float shift) {
  float16 p[3];
  rs_voxel_in_tool(a, v->corner, x, y, z, p);
  const float16 r = sqrt(p[0] * p[0] + p[1] * p[1]);
  const NearestPiece nearest = rs_outline_nearest(outline, v->list, r, p[2]);
  const float slack = shift + POSITION_SLACK * a->per_voxel_mm;
  return nearest.distance * a->per_voxel_mm - half_width(a, outline, v->list, &nearest, p[0], p[1], r, slack) - slack;
}

#endif

/* The lanes that are true, as bits. */
RS_INLINE uint bits_of(const int16 lanes) {
  const int16 bit = lanes & (int16)(1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768);
  const int8 eight = bit.lo | bit.hi;
  const int4 four = eight.lo | eight.hi;
  const int2 two = four.lo | four.hi;
  return (uint)(two.x | two.y);
}

/* Pads the candidates, and finds the pieces that can be nearest while the tool moves by `shift` mm. */
RS_INLINE void finish_candidates(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v,
                                 const float shift, Candidates* c) {
  vstore16((ushort16)0, 0, c->place + c->count);
  vstore16((int16)0, 0, c->fill + c->count);
  vstore16((float16)0.0f, 0, c->energy + c->count);
#ifndef RS_DISTANCE_GRID
  for (int i = 0; i < c->count; i += 16)
    find_nearest_pieces(a, outline, v, convert_int16(vload16(0, c->place + i)), shift, c->near + (i >> 4),
                        c->smooth + (i >> 4));
#endif
}

/* The voxels that the surface can intersect, or that lie inside it, while the tool moves by `shift` voxels. */
RS_INLINE void find_candidates(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v,
                               const float shift, __global const ushort* page, __global const float* energy_of_grade,
                               Candidates* c) {
  const int16 lane = (int16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  c->count = 0;
  /* First the eight blocks of 4x4x4 voxels, by the envelope; then layers of 16 voxels in the near blocks. */
  const float16 middle = rs_clip_distance(a, outline, v->list, v->corner, convert_float16((lane & 1) << 2) + 1.5f,
                                          convert_float16((lane & 2) << 1) + 1.5f, convert_float16(lane & 4) + 1.5f);
  const float near = RS_CLIP_REACH + 2.6f + 0.1f + shift + envelope_slack(v) * a->per_voxel_mm;
  const uint blocks = bits_of(middle * a->per_voxel_mm <= near);
  for (int block = 0; block < 8; ++block) {
    if ((blocks >> block & 1u) == 0) continue;
    const float16 x = convert_float16((block & 1) << 2 | (lane & 3)), y = convert_float16((block & 2) << 1 | lane >> 2);
    for (int layer = 0; layer < 4; ++layer) {
      const int first = block << 6 | layer << 4;
      const uint bone = v->brick->bone[first >> 5] >> (first & 31) & 0xffffu;
      if (bone == 0) continue;
      const float16 z = (float16)(float)((block & 4) | layer);
      uint rest = bone & bits_of(distance_beyond_reach(a, outline, v, x, y, z, shift) <= 0.0f);
      for (; rest != 0; rest &= rest - 1) {
        const int place = first + (int)popcount((rest & -rest) - 1);
        c->place[c->count] = (ushort)place;
        c->fill[c->count] = page == 0 ? RS_WHOLE_FILL : page[place];
        c->energy[c->count] = energy_of_grade[v->brick->grade[place]];
        ++c->count;
      }
    }
  }
  finish_candidates(a, outline, v, shift * a->voxel_mm, c);
}

#endif

#endif
