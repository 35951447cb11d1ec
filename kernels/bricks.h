/* Bricks of 8x8x8 voxels, stored only where there is bone, and the cells of shell points that meet them. */
#ifndef REAMSIM_KERNELS_BRICKS_H
#define REAMSIM_KERNELS_BRICKS_H

#include "shared.h"

#define RS_BRICK_SIDE 8
#define RS_BRICK_VOXELS 512
#define RS_BRICK_WORDS 16 /* of 32 bits, a bit per voxel */

/* Half diagonals in voxels, of a brick and of 4x4x4 bricks, rounded up: no point of their voxels lies further from
 * their middle. The second one has half a voxel's diagonal more. */
#define RS_BRICK_RADIUS 7.0f
#define RS_SUPERBRICK_RADIUS 27.8f

/* A voxel's place in its brick: eight blocks of 4x4x4 voxels, x before y before z in the block and among the blocks, so
 * that a block is 64 consecutive bits and what a surface touches lies close together. */
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

/* By rs_brick_offset. RS_BRICK_FILL is defined where voxels can be partly gone. */
typedef struct {
  rs_u32 bone[RS_BRICK_WORDS];    /* bit: something is left of the voxel */
  rs_u32 touched[RS_BRICK_WORDS]; /* bit: the tool touches it in this substep; all 0 between cut and detect */
  rs_u8 grade[RS_BRICK_VOXELS];
#ifdef RS_BRICK_FILL
  rs_u16 fill[RS_BRICK_VOXELS];
#endif
} Brick;

/* The bricks stand in RS_POOLS buffers (1 or 16) of 2^RS_POOL_BITS bricks, because devices limit one allocation. */
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

/* A block of the shell's grid with its points: their lowest cell, and how far the highest lies from it. Points are
 * 16-bit offsets from the lowest cell, 5 bits an axis, x in bit 0. */
#define RS_CELL_BITS 5
typedef struct {
  rs_i32 first[3];
  rs_i32 span[3];
  rs_u32 begin; /* of the offsets; a multiple of 16 */
  rs_u32 count;
} ShellCell;

/* The voxels of a block that a substep removed, as the kernels report them. */
typedef struct {
  rs_u32 brick;  /* in the lattice of bricks */
  rs_u32 detail; /* substep's slot << 3 | block in the brick */
  rs_u64 removed; /* a bit per voxel of the block */
} RemovedBlock;

/* The list of records has room for what any one substep can remove, not for every substep of a batch. A substep for
 * which there might be no room is left for the host to resume, and all that follow it with it: detect notes how long
 * the list was before the substep, or RS_WAITING where an earlier one waits already. */
#define RS_WAITING 0xffffffffu

/* Whether a substep that touches `bricks` bricks has to wait, with `before` records in a list of `records`, when no
 * substep can write more than `per_substep` (never more than the list holds). */
RS_INLINE int rs_list_would_overflow(rs_u32 records, rs_u32 per_substep, rs_u32 before, rs_u32 bricks) {
  const rs_u32 most = bricks < per_substep / 8 ? 8 * bricks : per_substep;
  return before == RS_WAITING || before > records - most;
}

/* ---- Exact erosion: what many substeps share ---- */

/* Substeps that a brick goes through in one visit at most, and so that sums are kept for meanwhile. */
#define RS_VISIT_SUBSTEPS 64

/* Substeps first…end-1, in which no point near the tool moves further than `shift_mm` from where it is in the first. */
typedef struct {
  rs_u32 first;
  rs_u32 end;
  float shift_mm;
} SubstepWindow;

/* Counters of a visit. */
typedef struct {
  rs_u32 listed;  /* bricks in reach of the tool */
  rs_u32 pages;   /* of fill that are in use: 512 fills of a brick that is not whole */
  rs_u32 removed; /* records of removed blocks */
} VisitCounts;

/* Signed distances to the tool's surface over cells of (r, z), at their centres: where the tool may be near, at a
 * glance. */
typedef struct {
  float z0; /* mm; r begins at 0 */
  float per_mm;
  float slack_mm; /* half a cell's diagonal */
  rs_i32 count_r, count_z;
} CoarseGrid;

#endif
