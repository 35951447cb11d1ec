// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Restores removed voxels from a list of (voxel, value), for benchmarks that repeat a frame on the same bone. */
#include "shared.h"

__kernel void restore_bytes(__global const uint2* voxels, const uint count, __global uchar* values) {
  const uint i = get_global_id(0);
  if (i < count) values[voxels[i].x] = (uchar)voxels[i].y;
}

__kernel void restore_halves(__global const uint2* voxels, const uint count, __global ushort* values) {
  const uint i = get_global_id(0);
  if (i < count) values[voxels[i].x] = (ushort)voxels[i].y;
}

/* Words of any type, floats by their bits. */
__kernel void restore_words(__global const uint2* voxels, const uint count, __global uint* values) {
  const uint i = get_global_id(0);
  if (i < count) values[voxels[i].x] = voxels[i].y;
}
