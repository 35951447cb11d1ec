// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Restores removed voxels from a list of (voxel, value), for benchmarks that repeat a frame on the same bone. */
#include "shared.h"

#define RESTORE(name, type)                                                                   \
  __kernel void name(__global const uint2* voxels, const uint count, __global type* values) { \
    const uint i = get_global_id(0);                                                          \
    if (i < count) values[voxels[i].x] = (type)voxels[i].y;                                   \
  }

RESTORE(restore_bytes, uchar)
RESTORE(restore_halves, ushort)
RESTORE(restore_words, uint) /* of any type, floats by their bits */
