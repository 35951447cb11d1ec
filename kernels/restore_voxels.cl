/* Puts back voxels that went, from a list of (voxel, value); for benchmarks, which repeat a frame on the same bone. */
#ifndef REAMSIM_KERNELS_SHARED_H
#include "shared.h"
#endif

/* As in cut_voxels.cl: a float HU where REAMSIM_FLAGGED_HU is defined, an 8-bit grade otherwise. */
#ifdef REAMSIM_FLAGGED_HU
typedef float Voxel;
#define VOXEL_OF(grade) ((float)(hu_of_air + (grade) * hu_per_grade))
#else
typedef uchar Voxel;
#define VOXEL_OF(grade) ((uchar)(grade))
#endif

/* voxels[count]: index and 16-bit fill above 8-bit grade. */
__kernel void restore_voxels(__global const uint2* voxels, const uint count, __global Voxel* bone,
                             __global ushort* fill, const int has_fill, const double hu_of_air,
                             const double hu_per_grade) {
  const uint i = get_global_id(0);
  if (i >= count) return;
  bone[voxels[i].x] = VOXEL_OF(voxels[i].y & 255u);
  if (has_fill) fill[voxels[i].x] = (ushort)(voxels[i].y >> 8);
}
