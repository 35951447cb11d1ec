// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* The published methods of `reamsim bench` (kernels/published.cl), which the engines do not use. */
#ifndef REAMSIM_KERNELS_PUBLISHED_H
#define REAMSIM_KERNELS_PUBLISHED_H

#include "shared.h"

/* Scale of the published integer sums, the paper's large N. Forces are in units of the elemental force. */
#define RS_PUBLISHED_SCALE 1048576.0f /* 2^20 */

/* Sums and arguments of one published frame, in one buffer (paper §3.5). Lengths in shell cells, voxel coordinates in
 * voxels; the lattice is a cube. */
typedef struct {
  rs_i64 force[3]; /* on the tool, in B */
  rs_i64 contacts; /* points; counted where count_contacts is set */
  float voxel_from_cell[9];
  float voxel_origin[3]; /* centre of shell cell (0,0,0) */
  float cap_center[3];   /* of the tool's sphere; elemental forces point towards it */
  float unused;          /* keeps the size a multiple of 8 */
  rs_i32 voi_min[3];
  rs_i32 voi_max[3];
  rs_i32 side;
  rs_i32 count_contacts;
} PublishedFrame;
RS_SAME_LAYOUT(PublishedFrame, 8 * 4 + 4 * 16 + 4 * 8);

#endif
