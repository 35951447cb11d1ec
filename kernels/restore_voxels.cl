/* Puts back voxels that went, from a list; for benchmarks, which repeat a frame on the same bone. */
#ifndef REAMSIM_KERNELS_SHARED_H
#include "shared.h"
#endif

/* voxels[count]: index and 16-bit fill above 8-bit grade. */
__kernel void restore_voxels(__global const uint2* voxels, const uint count, __global uchar* bone,
                             __global ushort* fill, const int has_fill) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  bone[voxels[i].x] = (uchar)(voxels[i].y & 255u);
  if (has_fill) fill[voxels[i].x] = (ushort)(voxels[i].y >> 8);
}
