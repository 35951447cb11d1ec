// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* The narrow phases as published, for `reamsim bench` only: with a work-item per point, in float, with races. */
#include "published.h"

/* ---- direct ---- */

/* The paper's narrow phase (§3.5) in one pass: a work-item decodes, culls, transforms, looks up, clears the voxel and
 * adds its elemental force. Two points in one voxel race: it depends on timing whether both exert a force or only the
 * first. */

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
__kernel void restore_direct(__global const uint* codes, const uint point_count, __global const PublishedFrame* f,
                             __global const uchar* whole, __global uchar* bone) {
  const uint point = get_global_id(0);
  if (point >= point_count) return;
  const uint code = codes[point];
  const uint e = published_voxel(f, rs_compact_bits(code), rs_compact_bits(code >> 1), rs_compact_bits(code >> 2));
  if (e != UINT_MAX) bone[e] = whole[e];
}

/* ---- octree ---- */

/* Zheng et al. as the paper rebuilt it (§4.3.1): points of three floats, voxels of a float HU and a collision flag. A
 * work-item descends from the whole grid to its voxel, one octant per level. The forces of all points, including those
 * outside the bone, are stored and then summed by a parallel reduction. AIR_HU, the HU of density 0, stands for air. */

/* steps[8·level + octant]: increment of the voxel's index for that octant. forces: x, y, z and 1 for a point that
 * touches, zeros for others. */
__kernel void published_octree(__global const float* points, const uint point_count, __global const PublishedFrame* f,
                               __global const float* hu, __global uchar* collided, __global const uint* steps,
                               const int levels, __global float* forces) {
  const uint point = get_global_id(0);
  if (point >= point_count) return;
  const float p[3] = {points[3 * point], points[3 * point + 1], points[3 * point + 2]};
  float d[3], inward[3];
  for (int axis = 0; axis < 3; ++axis) {
    __global const float* row = f->voxel_from_cell + 3 * axis;
    d[axis] = f->voxel_origin[axis] + row[0] * p[0] + row[1] * p[1] + row[2] * p[2];
    inward[axis] =
        row[0] * (f->cap_center[0] - p[0]) + row[1] * (f->cap_center[1] - p[1]) + row[2] * (f->cap_center[2] - p[2]);
  }
  float force[4] = {0, 0, 0, 0};
  const float n = f->side;
  if (d[0] >= 0 && d[1] >= 0 && d[2] >= 0 && d[0] < n && d[1] < n && d[2] < n) {
    uint e = 0;
    float low[3] = {0, 0, 0}, half_side = 0.5f * n;
    for (int level = 0; level < levels; ++level) {
      uint octant = 0;
      for (int axis = 0; axis < 3; ++axis) {
        if (d[axis] >= low[axis] + half_side) {
          octant |= 1u << axis;
          low[axis] += half_side;
        }
      }
      e += steps[8 * level + octant];
      half_side *= 0.5f;
    }
    if (hu[e] > AIR_HU && !collided[e]) {
      collided[e] = 1;
      const float scale = 1 / sqrt(inward[0] * inward[0] + inward[1] * inward[1] + inward[2] * inward[2]);
      for (int axis = 0; axis < 3; ++axis) force[axis] = inward[axis] * scale;
      force[3] = 1;
    }
  }
  for (int i = 0; i < 4; ++i) forces[4 * point + i] = force[i];
}

/* Sums `count` forces of `in` to one per group in `out`. `local_sums`: room for a force per work-item. */
__kernel void published_reduce(__global const float4* in, const uint count, __global float4* out,
                               __local float4* local_sums) {
  const uint item = get_local_id(0);
  float4 sum = (float4)(0, 0, 0, 0);
  for (uint i = get_global_id(0); i < count; i += get_global_size(0)) sum += in[i];
  local_sums[item] = sum;
  for (uint half_group = get_local_size(0) / 2; half_group > 0; half_group /= 2) {
    barrier(CLK_LOCAL_MEM_FENCE);
    if (item < half_group) local_sums[item] += local_sums[item + half_group];
  }
  if (item == 0) out[get_group_id(0)] = local_sums[0];
}

/* Clears the flags that published_octree has set in its last frame. The VOI is the whole shell. */
__kernel void restore_octree(__global const float* points, const uint point_count, __global const PublishedFrame* f,
                             __global uchar* collided) {
  const uint point = get_global_id(0);
  if (point >= point_count) return;
  __global const float* p = points + 3 * point;
  const uint e = published_voxel(f, (int)p[0], (int)p[1], (int)p[2]);
  if (e != UINT_MAX) collided[e] = 0;
}
