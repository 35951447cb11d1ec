// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Narrow phase over bricks. The shell's points are grouped in cells with bounds; a cell outside the VOI, or over bricks
 * without bone, is culled as a whole. Points of other cells are transformed with 32-bit integers relative to a window
 * of 32x32x32 voxels around the cell, and collected there as bits. A brick then needs a few atomic operations instead
 * of one per point. Two shapes share the arithmetic: on a CPU a work-item takes a run of cells, 16 points in the lanes
 * of a vector; on a GPU a work-group takes a cell, a work-item a point.
 *
 * Compiled with RS_POOLS (1 or 16 buffers of bricks) and RS_POOL_BITS (log2 of a buffer's bricks). */
#include "cut_law.h"

#define WINDOW_BLOCKS 512 /* of 4x4x4 voxels */
#define LIST_BLOCKS 768   /* of several cells, so that the memory of many blocks is requested at once */

/* The bricks and their tables. */
typedef struct {
  __global const int* slot_of_brick; /* -1: no bone */
  __global const uint* occupancy;    /* two words per 4x4x4 bricks: bit (x & 3) | (y & 3) << 2 | (z & 3) << 4 */
  __global uint* listed;             /* per slot: 1 if in the list of touched bricks */
  __global uint* touched_list;
  __global uint* touched_count; /* of this substep */
  __global Brick* pools[RS_POOLS];
  int bricks[3];
  int superbricks[3];
} Bricks;

/* The box of voxels that contains the points of a cell. */
typedef struct {
  long first[3]; /* fixed point: the centre of the cell's lowest shell cell */
  int low[3];    /* voxels */
  int high[3];
} Reach;

__global Brick* brick_at(const Bricks* b, const int slot) {
  return b->pools[slot >> RS_POOL_BITS] + ((uint)slot & RS_POOL_MASK);
}

Reach cell_reach(__global const SubstepArgs* a, __global const ShellCell* cell) {
  Reach reach;
  for (int i = 0; i < 3; ++i) {
    __global const long* row = a->voxel_from_cell + 3 * i;
    const long first = a->voxel_origin[i] + row[0] * cell->first[0] + row[1] * cell->first[1] + row[2] * cell->first[2];
    long low = first, high = first;
    for (int j = 0; j < 3; ++j) {
      const long step = row[j] * cell->span[j];
      low += min(step, 0L);
      high += max(step, 0L);
    }
    reach.first[i] = first;
    reach.low[i] = (int)(low >> RS_POSITION_BITS);
    reach.high[i] = (int)(high >> RS_POSITION_BITS);
  }
  return reach;
}

bool meets_voi(__global const SubstepArgs* a, __global const ShellCell* cell) {
  bool meets = true;
  for (int i = 0; i < 3; ++i)
    meets = meets && cell->first[i] <= a->voi_max[i] && cell->first[i] + cell->span[i] >= a->voi_min[i];
  return meets;
}

/* Four bits: the bricks of 4s…4s+3 that lie in low…high. */
uint nibble(const int s, const int low, const int high) {
  const int first = max(low - 4 * s, 0), last = min(high - 4 * s, 3);
  return ((2u << last) - 1u) & ~((1u << first) - 1u);
}

/* Whether a brick that the box overlaps has bone. */
bool meets_bone(__global const SubstepArgs* a, const Bricks* b, const Reach* reach) {
  int low[3], high[3];
  for (int i = 0; i < 3; ++i) {
    if (reach->high[i] < 0 || reach->low[i] >= a->dims[i]) return false;
    low[i] = max(reach->low[i], 0) >> 3;
    high[i] = min(reach->high[i], a->dims[i] - 1) >> 3;
  }
  uint found = 0;
  for (int sz = low[2] >> 2; sz <= high[2] >> 2; ++sz) {
    const uint mz = nibble(sz, low[2], high[2]);
    for (int sy = low[1] >> 2; sy <= high[1] >> 2; ++sy) {
      const uint my = nibble(sy, low[1], high[1]);
      const uint rows = ((my & 1u) | (my & 2u) << 3 | (my & 4u) << 6 | (my & 8u) << 9) * 0xfu;
      for (int sx = low[0] >> 2; sx <= high[0] >> 2; ++sx) {
        const uint layer = rows & (nibble(sx, low[0], high[0]) * 0x1111u);
        __global const uint* words = b->occupancy + 2 * (sx + b->superbricks[0] * (sy + b->superbricks[1] * sz));
        const uint lower = ((mz & 1u) | (mz & 2u) << 15) * layer, upper = ((mz >> 2 & 1u) | (mz & 8u) << 13) * layer;
        found |= (words[0] & lower) | (words[1] & upper);
      }
    }
  }
  return found != 0;
}

/* Marks the voxels `bits` of half a block as touched. They are bone. */
void mark_touched(const Bricks* b, const int slot, const int word, const uint bits) {
  if (bits == 0) return;
  /* Only the first mark of a word can be the first of the brick. */
  if (atomic_or(&brick_at(b, slot)->touched[word], bits) == 0 && atomic_xchg(&b->listed[slot], 1u) == 0)
    b->touched_list[atomic_inc(b->touched_count)] = (uint)slot;
}

/* Slot of the brick with a block (coordinates in blocks of 4 voxels), or -1. */
int slot_of_block(const Bricks* b, const int x, const int y, const int z) {
  const int bx = x >> 1, by = y >> 1, bz = z >> 1;
  if (bx < 0 || by < 0 || bz < 0 || bx >= b->bricks[0] || by >= b->bricks[1] || bz >= b->bricks[2]) return -1;
  return b->slot_of_brick[bx + (ulong)b->bricks[0] * (by + (ulong)b->bricks[1] * bz)];
}

int word_of_block(const int x, const int y, const int z) {
  return 2 * ((x & 1) | (y & 1) << 1 | (z & 1) << 2);
}

/* Law per_point: the elemental force of a point, if it lies in bone. */
void add_point_force(__global const SubstepArgs* a, const Bricks* b, const OutlineView* outline,
                     __global const ShellCell* cell, const ushort offset, LaneSums* sums) {
  const int x = cell->first[0] + (offset & 31), y = cell->first[1] + (offset >> 5 & 31),
            z = cell->first[2] + (offset >> 10);
  const int i = rs_voxel_coordinate(a, 0, x, y, z), j = rs_voxel_coordinate(a, 1, x, y, z),
            k = rs_voxel_coordinate(a, 2, x, y, z);
  const int slot = slot_of_block(b, i >> 2, j >> 2, k >> 2);
  if (slot < 0) return;
  const int place = rs_brick_offset(i, j, k);
  if ((brick_at(b, slot)->bone[place >> 5] >> (place & 31) & 1u) != 0) rs_point_force(a, outline, x, y, z, sums);
}

#define PARAMETERS                                                                                              \
  const uint substep, __global const SubstepArgs *args, __global const ShellCell *cells, const uint cell_count, \
      __global const ShellCell *runs, const uint run_cells, __global const ushort *offsets,                     \
      __global const int *slot_of_brick, __global const uint *occupancy, __global uint *listed,                 \
      __global uint *touched_list, __global uint *touched_count, __global SubstepSums *sums, const int4 bricks, \
      const int culling, const uint2 room, __global const uint *removed_count, __global uint *removed_before,   \
      __global const OutlinePiece *pieces, __global const ushort *numbers, __global const PieceList *lists,     \
      __global const OutlineGrid *grid, RS_POOL_PARAMETERS
#define BRICKS                                                                              \
  {                                                                                         \
    slot_of_brick, occupancy, listed, touched_list, touched_count + substep, RS_POOL_ARRAY, \
        {bricks.x, bricks.y, bricks.z}, {                                                   \
      (bricks.x + 3) >> 2, (bricks.y + 3) >> 2, (bricks.z + 3) >> 2                         \
    }                                                                                       \
  }

/* Stores the length of the list of removed blocks before this substep. Returns whether the substep must wait, because
 * the one before it waits. */
bool must_wait(const uint2 room, __global const uint* removed_count, __global uint* removed_before,
               __global const uint* touched_count, const uint substep) {
  const bool waits =
      substep > 0 && rs_list_would_overflow(room.x, room.y, removed_before[substep - 1], touched_count[substep - 1]);
  if (get_global_id(0) == 0) removed_before[substep] = waits ? RS_WAITING : *removed_count;
  return waits;
}

#ifdef RS_CPU_SHAPE

/* Collects the points of a cell as bits of the window whose lowest voxel is `origin`. */
void collect_points(__global const SubstepArgs* a, __global const ShellCell* cell, __global const ushort* offsets,
                    const Reach* reach, const int* origin, ulong* window) {
  int base[3], step[9];
  for (int i = 0; i < 3; ++i) {
    base[i] = (int)(reach->first[i] - ((long)origin[i] << RS_POSITION_BITS));
    for (int j = 0; j < 3; ++j) step[3 * i + j] = (int)a->voxel_from_cell[3 * i + j];
  }
  for (uint p = cell->begin; p < cell->begin + cell->count; p += 16) {
    const int16 o = convert_int16(vload16(0, offsets + p));
    const int16 x = o & 31, y = o >> 5 & 31, z = o >> 10;
    const int16 i = (base[0] + x * step[0] + y * step[1] + z * step[2]) >> RS_POSITION_BITS;
    const int16 j = (base[1] + x * step[3] + y * step[4] + z * step[5]) >> RS_POSITION_BITS;
    const int16 k = (base[2] + x * step[6] + y * step[7] + z * step[8]) >> RS_POSITION_BITS;
    const int16 block = i >> 2 | (j >> 2) << 3 | (k >> 2) << 6;
    const int16 bit = (i & 3) | (j & 3) << 2 | (k & 3) << 4;
    int place[16];
    vstore16(block << 6 | bit, 0, place);
    for (int l = 0; l < 16; ++l) window[place[l] >> 6] |= 1ul << (place[l] & 63);
  }
}

/* Blocks with points, of one window or several. */
typedef struct {
  ulong bits[LIST_BLOCKS];
  int slot[LIST_BLOCKS];   /* of the brick */
  uchar word[LIST_BLOCKS]; /* of the brick's bits, the first of two */
  int count;
} BlockList;

/* Lists the blocks of a row of the window that lie in stored bricks. (x, y, z): the first one, in blocks of 4 voxels.
 */
void list_row(const Bricks* b, const int x, const int y, const int z, const ulong8 blocks, BlockList* list) {
  const int by = y >> 1, bz = z >> 1;
  if (by < 0 || bz < 0 || by >= b->bricks[1] || bz >= b->bricks[2]) return;
  __global const int* slots = b->slot_of_brick + (ulong)b->bricks[0] * (by + (ulong)b->bricks[1] * bz);
  const ulong* each = (const ulong*)&blocks;
  for (int i = 0; i < 8; ++i) {
    const int bx = (x + i) >> 1;
    if (each[i] == 0 || bx < 0 || bx >= b->bricks[0]) continue;
    list->bits[list->count] = each[i];
    list->slot[list->count] = slots[bx];
    list->word[list->count] = (uchar)word_of_block(x + i, y, z);
    list->count += slots[bx] >= 0;
  }
}

/* Lists the blocks of the window with points, and clears the window. */
void list_blocks(const Bricks* b, const Reach* reach, const int* origin, ulong* window, BlockList* list) {
  const int ox = origin[0] >> 2, oy = origin[1] >> 2, oz = origin[2] >> 2;
  const int last_y = (reach->high[1] >> 2) - oy, last_z = (reach->high[2] >> 2) - oz;
  for (int z = 0; z <= last_z; ++z) {
    for (int y = 0; y <= last_y; ++y) {
      ulong* row = window + 8 * (y + 8 * z);
      const ulong8 blocks = vload8(0, row);
      if (!any(blocks != 0ul)) continue;
      vstore8((ulong8)0, 0, row);
      list_row(b, ox, oy + y, oz + z, blocks, list);
    }
  }
}

/* Marks the voxels of the list that are bone, and empties it. The bone of all blocks is read before the first is
 * marked, because waiting for memory takes most of the time. */
void mark_blocks(const Bricks* b, BlockList* list) {
  for (int i = 0; i < list->count; ++i)
    list->bits[i] &= as_ulong(vload2(0, brick_at(b, list->slot[i])->bone + list->word[i]));
  for (int i = 0; i < list->count; ++i) {
    mark_touched(b, list->slot[i], list->word[i], (uint)list->bits[i]);
    mark_touched(b, list->slot[i], list->word[i] + 1, (uint)(list->bits[i] >> 32));
  }
  list->count = 0;
}

__kernel void detect_bricked(PARAMETERS) {
  const uint run = get_global_id(0);
  const uint first = run * run_cells, last = min(first + run_cells, cell_count);
  if (must_wait(room, removed_count, removed_before, touched_count, substep) || first >= cell_count) return;
  __global const SubstepArgs* a = args + substep;
  const Bricks b = BRICKS;
  const OutlineView outline = {pieces, numbers, lists, grid};
  if (culling) {
    const Reach whole = cell_reach(a, runs + run);
    if (!meets_voi(a, runs + run) || !meets_bone(a, &b, &whole)) return;
  }
  ulong window[WINDOW_BLOCKS];
  for (int w = 0; w < WINDOW_BLOCKS; ++w) window[w] = 0;
  BlockList list;
  list.count = 0;
  LaneSums point_sums = {{0, 0, 0}, {0, 0, 0}, 0};
  for (uint c = first; c < last; ++c) {
    __global const ShellCell* cell = cells + c;
    if (culling && !meets_voi(a, cell)) continue;
    const Reach reach = cell_reach(a, cell);
    if (culling && !meets_bone(a, &b, &reach)) continue;
    const int origin[3] = {reach.low[0] & ~3, reach.low[1] & ~3, reach.low[2] & ~3};
    collect_points(a, cell, offsets, &reach, origin, window);
    list_blocks(&b, &reach, origin, window, &list);
    if (list.count > LIST_BLOCKS - WINDOW_BLOCKS) mark_blocks(&b, &list);
    if (a->law == RS_LAW_PER_POINT)
      for (uint p = 0; p < cell->count; ++p)
        add_point_force(a, &b, &outline, cell, offsets[cell->begin + p], &point_sums);
  }
  mark_blocks(&b, &list);
  if (a->law == RS_LAW_PER_POINT) rs_add_point_sums(&sums[substep], &point_sums);
}

#else

__kernel void detect_bricked(PARAMETERS) {
  __local uint window[2 * WINDOW_BLOCKS];
  /* All work-items decide alike, and reach the barriers. */
  const bool waits = must_wait(room, removed_count, removed_before, touched_count, substep);
  if (get_group_id(0) >= cell_count) return; /* groups are smaller than the launch was made for */
  __global const SubstepArgs* a = args + substep;
  __global const ShellCell* cell = cells + get_group_id(0);
  const Bricks b = BRICKS;
  const OutlineView outline = {pieces, numbers, lists, grid};
  const Reach reach = cell_reach(a, cell);
  const bool culled = culling && !(meets_voi(a, cell) && meets_bone(a, &b, &reach));
  const int origin[3] = {reach.low[0] & ~3, reach.low[1] & ~3, reach.low[2] & ~3};
  for (uint w = get_local_id(0); w < 2 * WINDOW_BLOCKS; w += get_local_size(0)) window[w] = 0;
  barrier(CLK_LOCAL_MEM_FENCE);
  LaneSums point_sums = {{0, 0, 0}, {0, 0, 0}, 0};
  const uint count = waits || culled ? 0 : cell->count;
  for (uint p = get_local_id(0); p < count; p += get_local_size(0)) {
    const ushort offset = offsets[cell->begin + p];
    int v[3];
    for (int i = 0; i < 3; ++i) {
      __global const long* row = a->voxel_from_cell + 3 * i;
      const int base = (int)(reach.first[i] - ((long)origin[i] << RS_POSITION_BITS));
      v[i] = (base + (offset & 31) * (int)row[0] + (offset >> 5 & 31) * (int)row[1] + (offset >> 10) * (int)row[2]) >>
             RS_POSITION_BITS;
    }
    const int block = v[0] >> 2 | (v[1] >> 2) << 3 | (v[2] >> 2) << 6;
    const int bit = (v[0] & 3) | (v[1] & 3) << 2 | (v[2] & 3) << 4;
    atomic_or(&window[2 * block + (bit >> 5)], 1u << (bit & 31));
    if (a->law == RS_LAW_PER_POINT) add_point_force(a, &b, &outline, cell, offset, &point_sums);
  }
  barrier(CLK_LOCAL_MEM_FENCE);
  for (uint w = get_local_id(0); w < 2 * WINDOW_BLOCKS; w += get_local_size(0)) {
    const uint bits = window[w];
    if (bits == 0) continue;
    const int block = (int)(w >> 1);
    const int x = (origin[0] >> 2) + (block & 7), y = (origin[1] >> 2) + (block >> 3 & 7),
              z = (origin[2] >> 2) + (block >> 6);
    const int slot = slot_of_block(&b, x, y, z);
    const int word = word_of_block(x, y, z) + (int)(w & 1u);
    if (slot >= 0) mark_touched(&b, slot, word, bits & brick_at(&b, slot)->bone[word]);
  }
  if (a->law == RS_LAW_PER_POINT && count != 0) rs_add_point_sums(&sums[substep], &point_sums);
}

#endif
