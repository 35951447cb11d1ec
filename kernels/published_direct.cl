// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* The paper's narrow phase as published (§3.5), for `reamsim bench` only: one pass in float, with races. A work-item
 * per point decodes, culls, transforms, looks up, clears the voxel and adds its elemental force. Two points in one
 * voxel race: it depends on timing whether both exert a force or only the first. */
#include "published.h"

/* Index of the voxel that point (x, y, z) lies in; UINT_MAX outside the VOI or the bone's lattice. */
static uint published_voxel(__global const PublishedFrame* f, int x, int y, int z) {
  if (x < f->voi_min[0] || x > f->voi_max[0] || y < f->voi_min[1] || y > f->voi_max[1] || z < f->voi_min[2] ||
      z > f->voi_max[2])
    return UINT_MAX;
  int d[3];
  for (int axis = 0; axis < 3; ++axis) {
    __global const float* row = f->voxel_from_cell + 3 * axis;
    d[axis] = (int)floor(f->voxel_origin[axis] + row[0] * x + row[1] * y + row[2] * z);
  }
  const int n = f->side;
  if (d[0] < 0 || d[1] < 0 || d[2] < 0 || d[0] >= n || d[1] >= n || d[2] >= n) return UINT_MAX;
  return (uint)d[0] + (uint)d[1] * n + (uint)d[2] * n * n;
}

__kernel void published_direct(__global const uint* codes, const uint point_count, __global PublishedFrame* f,
                               __global uchar* bone) {
  const uint point = get_global_id(0);
  if (point >= point_count) return;
  const uint code = codes[point];
  const int x = rs_compact_bits(code), y = rs_compact_bits(code >> 1), z = rs_compact_bits(code >> 2);
  const uint e = published_voxel(f, x, y, z);
  if (e == UINT_MAX || bone[e] == 0) return;
  bone[e] = 0;
  const float p[3] = {f->cap_center[0] - x, f->cap_center[1] - y, f->cap_center[2] - z};
  float inward[3];
  for (int axis = 0; axis < 3; ++axis) {
    __global const float* row = f->voxel_from_cell + 3 * axis;
    inward[axis] = row[0] * p[0] + row[1] * p[1] + row[2] * p[2];
  }
  const float scale = RS_PUBLISHED_SCALE / sqrt(inward[0] * inward[0] + inward[1] * inward[1] + inward[2] * inward[2]);
  for (int axis = 0; axis < 3; ++axis) add_to_sum(&f->force[axis], (long)(inward[axis] * scale));
  if (f->count_contacts) add_to_sum(&f->contacts, 1L);
}

/* Puts back the voxels that published_direct has cleared in its last frame. */
__kernel void published_restore(__global const uint* codes, const uint point_count, __global const PublishedFrame* f,
                                __global const uchar* whole, __global uchar* bone) {
  const uint point = get_global_id(0);
  if (point >= point_count) return;
  const uint code = codes[point];
  const uint e = published_voxel(f, rs_compact_bits(code), rs_compact_bits(code >> 1), rs_compact_bits(code >> 2));
  if (e != UINT_MAX) bone[e] = whole[e];
}
