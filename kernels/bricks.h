// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Bricks of 8x8x8 voxels, stored only where there is bone, and the cells of shell points. */
#ifndef REAMSIM_KERNELS_BRICKS_H
#define REAMSIM_KERNELS_BRICKS_H

#include "shared.h"

#define RS_BRICK_SIDE 8
#define RS_BRICK_VOXELS 512
#define RS_BRICK_WORDS 16 /* of 32 bits, a bit per voxel */

/* Bounding radii of a brick and of 4x4x4 bricks about their middles, voxels. */
#define RS_BRICK_RADIUS 7.0f
#define RS_SUPERBRICK_RADIUS 27.8f

/* Place of a voxel in its brick: eight blocks of 4x4x4 voxels, x fastest in the block and among the blocks. A block is
 * 64 consecutive bits, and voxels that a surface touches lie close together. */
RS_INLINE rs_i32 rs_brick_offset(rs_i32 x, rs_i32 y, rs_i32 z) {
  return (((x >> 2) & 1) | ((y >> 2) & 1) << 1 | ((z >> 2) & 1) << 2) << 6 | (x & 3) | (y & 3) << 2 | (z & 3) << 4;
}

RS_INLINE rs_i32 rs_offset_x(rs_i32 offset) {
  return (offset >> 6 & 1) << 2 | (offset & 3);
}
RS_INLINE rs_i32 rs_offset_y(rs_i32 offset) {
  return (offset >> 7 & 1) << 2 | (offset >> 2 & 3);
}
RS_INLINE rs_i32 rs_offset_z(rs_i32 offset) {
  return (offset >> 8 & 1) << 2 | (offset >> 4 & 3);
}

/* Indexed by rs_brick_offset. RS_BRICK_FILL is defined where voxels can be partly removed. */
typedef struct {
  rs_u32 bone[RS_BRICK_WORDS];    /* bit: the voxel has bone */
  rs_u32 touched[RS_BRICK_WORDS]; /* bit: touched in this substep; all 0 between cut and detect */
  rs_u8 grade[RS_BRICK_VOXELS];
#ifdef RS_BRICK_FILL
  rs_u16 fill[RS_BRICK_VOXELS];
#endif
} Brick;
#ifdef RS_BRICK_FILL
RS_SAME_LAYOUT(Brick, 2 * 64 + 512 + 1024);
#else
RS_SAME_LAYOUT(Brick, 2 * 64 + 512);
#endif

/* Bricks are stored in RS_POOLS buffers (1 or 16) of 2^RS_POOL_BITS bricks, because devices limit one allocation. */
#ifdef RS_POOLS
#if RS_POOLS == 1
#define RS_POOL_PARAMETERS __global Brick* pool_0
#define RS_POOL_ARRAY \
  { pool_0 }
#else
#define RS_POOL_PARAMETERS                                                                              \
  __global Brick *pool_0, __global Brick *pool_1, __global Brick *pool_2, __global Brick *pool_3,       \
      __global Brick *pool_4, __global Brick *pool_5, __global Brick *pool_6, __global Brick *pool_7,   \
      __global Brick *pool_8, __global Brick *pool_9, __global Brick *pool_10, __global Brick *pool_11, \
      __global Brick *pool_12, __global Brick *pool_13, __global Brick *pool_14, __global Brick *pool_15
#define RS_POOL_ARRAY                                                                                          \
  {                                                                                                            \
    pool_0, pool_1, pool_2, pool_3, pool_4, pool_5, pool_6, pool_7, pool_8, pool_9, pool_10, pool_11, pool_12, \
        pool_13, pool_14, pool_15                                                                              \
  }
#endif
#define RS_POOL_MASK ((1u << RS_POOL_BITS) - 1u)
#endif

/* A block of the shell's grid with its points: the bounds of their cells. Points are 16-bit offsets from the lowest
 * cell, 5 bits per axis, x in bit 0. */
#define RS_CELL_BITS 5
typedef struct {
  rs_i32 first[3];
  rs_i32 span[3];
  rs_u32 begin; /* of the offsets; a multiple of 16 */
  rs_u32 count;
} ShellCell;
RS_SAME_LAYOUT(ShellCell, 32);

/* The voxels of a block that a substep removed, as the kernels report them. */
typedef struct {
  rs_u32 brick;   /* in the lattice of bricks */
  rs_u32 detail;  /* substep's slot << 3 | block in the brick */
  rs_u64 removed; /* a bit per voxel of the block */
} RemovedBlock;
RS_SAME_LAYOUT(RemovedBlock, 16);

/* The list of removed blocks holds those of any one substep, but not of a whole batch. A substep that might overflow it
 * waits, and all later ones with it, until the host has emptied the list. For each substep detect stores the length of
 * the list before it, or RS_WAITING where an earlier one waits. */
#define RS_WAITING 0xffffffffu

/* Whether a substep that touches `bricks` bricks must wait. `before`: length of the list before the substep; `records`:
 * capacity; `per_substep`: most records of one substep, at most `records`. */
RS_INLINE int rs_list_would_overflow(rs_u32 records, rs_u32 per_substep, rs_u32 before, rs_u32 bricks) {
  const rs_u32 most = bricks < per_substep / 8 ? 8 * bricks : per_substep;
  return before == RS_WAITING || before > records - most;
}

/* Exact erosion: the largest number of substeps that a brick passes through in one visit, and in one window of smooth
 * motion. More per visit means fewer launches, and more bricks that only a part of the visit reaches. */
#define RS_VISIT_SUBSTEPS 256
#define RS_WINDOW_SUBSTEPS 64

/* Substeps first…end-1, in which no point near the tool moves further than `shift_mm` from its place in the first.
 * `motion`: number of their MotionWindow (window.h), or -1 to cut frame by frame. */
typedef struct {
  rs_u32 first;
  rs_u32 end;
  float shift_mm;
  rs_i32 motion;
} SubstepWindow;
RS_SAME_LAYOUT(SubstepWindow, 16);

/* Counters of a visit. */
typedef struct {
  rs_u32 listed;  /* bricks in reach of the tool */
  rs_u32 pages;   /* pages in use, each the fill of a partly removed brick */
  rs_u32 removed; /* records of removed blocks */
  rs_u32 taken;   /* listed bricks that a work-item has taken */
} VisitCounts;
RS_SAME_LAYOUT(VisitCounts, 16);

/* Coarse table of signed distances to the tool's surface, at the centres of cells of (r, z). */
typedef struct {
  float z0; /* mm; r begins at 0 */
  float per_mm;
  float slack_mm; /* half a cell's diagonal */
  rs_i32 count_r, count_z;
} CoarseGrid;
RS_SAME_LAYOUT(CoarseGrid, 20);

#endif
