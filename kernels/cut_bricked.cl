// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Cut over bricks: every touched voxel loses fill, takes energy and exerts a force (docs/physics.md, 4). Work-items, or
 * work-groups on a GPU, divide the list of touched bricks, whose length only the device knows. On a CPU (RS_LANES 16)
 * the law is evaluated for sixteen voxels in the lanes of a vector; on a GPU a work-item takes one voxel.
 *
 * Compiled with RS_POOLS, RS_POOL_BITS and, where voxels can be partly removed, RS_BRICK_FILL. */
#include "brick_report.h"

/* Tables by grade: energy of a whole voxel, in units of the sum, and density in RS_DENSITY_SCALE. */
typedef struct {
  __global const long* units;
  __global const int* density;
} Material;

/* Integer sums of a work-item, beside those of the law. */
typedef struct {
  RemovedReport report;
  long contacts;
  long fill;
  long energy;
} Tally;

/* Lowers the fill of voxel `place` of the grade. Returns the energy, mJ; `removed` tells whether no fill remains. */
float remove_fill(__global const SubstepArgs* a, __global Brick* brick, const Material* material, const int place,
                  const uchar grade, Tally* tally, bool* removed) {
  tally->contacts += 1;
#ifdef RS_BRICK_FILL
  const int before = brick->fill[place];
  const int lost = rs_lost_fill(a, material->density[grade], before);
  const long energy = rs_lost_energy(material->units[grade], lost);
  brick->fill[place] = (ushort)(before - lost);
  *removed = lost == before;
  tally->fill += lost;
  tally->energy += energy;
  return rs_energy_mj(energy);
#else
  *removed = true;
  tally->fill += RS_WHOLE_FILL;
  tally->energy += material->units[grade];
  return rs_energy_mj(material->units[grade]);
#endif
}

#define PARAMETERS                                                                                                    \
  const uint substep, __global const SubstepArgs *args, __global const uint *lattice_of_slot, __global uint *listed,  \
      __global uint *occupancy, __global const uint *touched_list, __global const uint *touched_count,                \
      __global SubstepSums *sums, __global RemovedBlock *removed, __global uint *removed_count, const uint2 room,     \
      __global const uint *removed_before, __global const long *units_of_grade, __global const int *density_of_grade, \
      __global const ulong *bits_of_byte, const int4 bricks, __global const OutlinePiece *pieces,                     \
      __global const ushort *numbers, __global const PieceList *lists, __global const OutlineGrid *grid,              \
      RS_POOL_PARAMETERS

/* The number of bricks to cut: 0 where the list of removed voxels might overflow. A negative number of contacts tells
 * the host that the substep waits. */
uint bricks_to_cut(const uint2 room, __global const uint* removed_before, __global const uint* touched_count,
                   const uint substep, __global SubstepSums* sums) {
  const bool waits = rs_list_would_overflow(room.x, room.y, removed_before[substep], touched_count[substep]);
  if (waits && get_global_id(0) == 0) sums[substep].contacts = -1;
  return waits ? 0 : touched_count[substep];
}

void begin_tally(Tally* tally, __global RemovedBlock* removed, __global uint* removed_count) {
  begin_report(&tally->report, removed, removed_count);
  tally->contacts = tally->fill = tally->energy = 0;
}

void finish_tally(Tally* tally, const LaneSums* law, __global SubstepSums* sums) {
  flush_report(&tally->report);
  if (tally->contacts != 0) add_brick_sums(sums, law, tally->energy, tally->fill, tally->contacts);
}

#if defined(RS_LANES)

/* Bricks that a work-item cuts together: their data are requested before the first is used, because waiting for memory
 * takes most of the time. */
#define GROUP 8
/* Touched voxels of a group, each brick's padded to a multiple of 16. A group ends before a brick might not fit:
 * private memory is small where a work-group has many work-items. */
#define GROUP_VOXELS (2 * (RS_BRICK_VOXELS + 16))

/* A touched brick. Its touched voxels are in the group's list from `first`, a multiple of 16, on. */
typedef struct {
  __global Brick* brick;
  uint16 bone;
  uint16 touched;
  uint lattice; /* index in the lattice of bricks */
  int first;
  int count;
} CutBrick;

/* Reads the bits of a brick. */
void take_brick(__global Brick* brick, const uint lattice, CutBrick* cut) {
  cut->brick = brick;
  cut->bone = vload16(0, brick->bone);
  cut->touched = vload16(0, brick->touched);
  cut->lattice = lattice;
}

/* Lists the places of the touched voxels in ascending order, padded to a multiple of 16. Returns their number.
 * `bits_of_byte[b]`: the numbers of the bits of b, a byte each, lowest first. */
int list_places(const uint16 touched, __global const ulong* bits_of_byte, ushort* places) {
  const uint* words = (const uint*)&touched;
  int count = 0;
  for (int w = 0; w < RS_BRICK_WORDS; ++w) {
    const uint word = words[w];
    if (word == 0) continue;
    for (int b = 0; b < 4; ++b) {
      const uint byte = word >> 8 * b & 0xffu;
      const ushort8 bits = convert_ushort8(as_uchar8(bits_of_byte[byte]));
      vstore8(bits + (ushort)(32 * w + 8 * b), 0, places + count);
      count += popcount(byte);
    }
  }
  vstore16((ushort16)places[0], 0, places + count);
  return count;
}

/* The grades of a brick's touched voxels: a loop by itself, so that the processor waits for many of them at once. */
void read_grades(const CutBrick* cut, const ushort* restrict places, uchar* restrict grades) {
  __global const uchar* grade = cut->brick->grade;
  const int count = cut->count;
  for (int i = 0; i < count; ++i) grades[i] = grade[places[i]];
}

/* Lists the touched voxels of the group and their grades, brick by brick while there is room, and clears the bricks'
 * marks. Returns the number of bricks. */
int list_group(CutBrick* cuts, const int group, __global const ulong* bits_of_byte, ushort* places, uchar* grades) {
  int first = 0, bricks = 0;
  for (; bricks < group && first <= GROUP_VOXELS - (RS_BRICK_VOXELS + 16); ++bricks) {
    CutBrick* cut = cuts + bricks;
    cut->first = first;
    cut->count = list_places(cut->touched, bits_of_byte, places + first);
    first += (cut->count + 15) & ~15;
    vstore16((uint16)0, 0, cut->brick->touched);
  }
  for (int g = 0; g < bricks; ++g) read_grades(cuts + g, places + cuts[g].first, grades + cuts[g].first);
  return bricks;
}

/* Lowers the fill of the listed voxels of a brick. Returns those without fill, a bit each. */
uint16 remove_all_fill(__global const SubstepArgs* a, const CutBrick* cut, const Material* material,
                       const ushort* places, const uchar* grades, float* energies, Tally* tally) {
#ifdef RS_BRICK_FILL
  uint16 removed_voxels = (uint16)0;
  uint* removed_words = (uint*)&removed_voxels;
  for (int i = 0; i < cut->count; ++i) {
    bool removed;
    energies[i] = remove_fill(a, cut->brick, material, places[i], grades[i], tally, &removed);
    removed_words[places[i] >> 5] |= (uint)removed << (places[i] & 31);
  }
#else
  const uint16 removed_voxels = cut->touched; /* a touched voxel is removed whole */
  long units = 0;
  for (int i = 0; i < cut->count; ++i) {
    units += material->units[grades[i]];
    energies[i] = rs_energy_mj(material->units[grades[i]]);
  }
  tally->contacts += cut->count;
  tally->fill += (long)RS_WHOLE_FILL * cut->count;
  tally->energy += units;
#endif
  vstore16((float16)0.0f, 0, energies + cut->count);
  return removed_voxels;
}

/* Removes voxels without fill from the brick, and reports them. */
void remove_from_brick(const CutBrick* cut, const uint16 removed_voxels, const uint substep, __global uint* occupancy,
                       const int4 bricks, RemovedReport* report) {
  const uint16 bone = cut->bone & ~removed_voxels;
  vstore16(bone, 0, cut->brick->bone);
  const uint* words = (const uint*)&removed_voxels;
  report->brick = cut->lattice;
  for (int block = 0; block < RS_BRICK_WORDS / 2; ++block)
    if ((words[2 * block] | words[2 * block + 1]) != 0)
      report_removed(substep, block, words[2 * block], words[2 * block + 1], report);
  if (!any(bone != 0u)) clear_occupied(occupancy, brick_position(cut->lattice, bricks), bricks);
}

/* The law for the listed voxels of a brick, sixteen at a time. */
void accumulate_cut_forces(__global const SubstepArgs* a, const OutlineView* outline, const CutBrick* cut,
                           const int4 bricks, const ushort* places, const float* energies, LaneSums* sums) {
  const int3 at = brick_position(cut->lattice, bricks);
  BrickMiddle middle;
  rs_brick_in_tool(a, 8 * at.x, 8 * at.y, 8 * at.z, &middle);
  const PieceList list = rs_pieces_near_brick(outline, &middle);
  for (int i = 0; i < cut->count; i += 16) {
    const int16 place = convert_int16(vload16(0, places + i));
    const float16 lx = convert_float16((place >> 6 & 1) << 2 | (place & 3));
    const float16 ly = convert_float16((place >> 7 & 1) << 2 | (place >> 2 & 3));
    const float16 lz = convert_float16((place >> 8 & 1) << 2 | (place >> 4 & 3));
    float16 p[3], n[3];
    rs_voxel_in_tool(a, &middle, lx, ly, lz, p);
    rs_outline_normal(outline, list, p, n);
    rs_cut_force(a, n, p, vload16(0, energies + i), sums);
  }
}

__kernel void cut_bricked(PARAMETERS) {
  __global const SubstepArgs* a = args + substep;
  const ulong count = bricks_to_cut(room, removed_before, touched_count, substep, sums);
  const Material material = {units_of_grade, density_of_grade};
  const OutlineView outline = {pieces, numbers, lists, grid};
  __global Brick* pools[RS_POOLS] = RS_POOL_ARRAY;
  LaneSums law = zero_sums();
  Tally tally;
  begin_tally(&tally, removed, removed_count);
  CutBrick cuts[GROUP];
  ushort places[GROUP_VOXELS];
  uchar grades[GROUP_VOXELS];
  float energies[GROUP_VOXELS];
  /* Bricks that were listed one after the other lie close together. */
  const uint last = (uint)(count * (get_global_id(0) + 1) / get_global_size(0));
  int group;
  for (uint t = (uint)(count * get_global_id(0) / get_global_size(0)); t < last; t += (uint)group) {
    const int wanted = (int)min(last - t, (uint)GROUP);
    for (int g = 0; g < wanted; ++g) {
      const uint slot = touched_list[t + (uint)g];
      take_brick(pools[slot >> RS_POOL_BITS] + (slot & RS_POOL_MASK), lattice_of_slot[slot], cuts + g);
      listed[slot] = 0;
    }
    group = list_group(cuts, wanted, bits_of_byte, places, grades);
    for (int g = 0; g < group; ++g) {
      const int first = cuts[g].first;
      const uint16 removed_voxels =
          remove_all_fill(a, cuts + g, &material, places + first, grades + first, energies + first, &tally);
      remove_from_brick(cuts + g, removed_voxels, substep, occupancy, bricks, &tally.report);
    }
    for (int g = 0; g < group && a->law == RS_LAW_ENERGY; ++g)
      accumulate_cut_forces(a, &outline, cuts + g, bricks, places + cuts[g].first, energies + cuts[g].first, &law);
  }
  finish_tally(&tally, &law, &sums[substep]);
}

#else

/* Cuts one touched voxel; the touched bit is cleared later by the work-item of its block. Returns whether no fill
 * remains. (x, y, z): lowest voxel of the brick. */
bool cut_voxel(__global const SubstepArgs* a, __global Brick* brick, const int place, const int x, const int y,
               const int z, const Material* material, const OutlineView* outline, LaneSums* law, Tally* tally) {
  bool removed;
  const float energy = remove_fill(a, brick, material, place, brick->grade[place], tally, &removed);
  if (a->law == RS_LAW_ENERGY)
    rs_voxel_force(a, outline, x + rs_offset_x(place), y + rs_offset_y(place), z + rs_offset_z(place), energy, law);
  return removed;
}

__kernel void cut_bricked(PARAMETERS) {
  __local uint removed_words[RS_BRICK_WORDS];
  __global const SubstepArgs* a = args + substep;
  const uint count = bricks_to_cut(room, removed_before, touched_count, substep, sums);
  const Material material = {units_of_grade, density_of_grade};
  const OutlineView outline = {pieces, numbers, lists, grid};
  __global Brick* pools[RS_POOLS] = RS_POOL_ARRAY;
  LaneSums law = zero_sums();
  Tally tally;
  begin_tally(&tally, removed, removed_count);
  const uint item = get_local_id(0), items = get_local_size(0);
  /* All work-items of a group make the same number of iterations, so that all reach the barriers. */
  for (uint t = get_group_id(0); t < count; t += get_num_groups(0)) {
    const uint slot = touched_list[t];
    __global Brick* brick = pools[slot >> RS_POOL_BITS] + (slot & RS_POOL_MASK);
    tally.report.brick = lattice_of_slot[slot];
    const int3 at = brick_position(tally.report.brick, bricks);
    for (uint w = item; w < RS_BRICK_WORDS; w += items) removed_words[w] = 0;
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    for (uint place = item; place < RS_BRICK_VOXELS; place += items) {
      if ((brick->touched[place >> 5] >> (place & 31u) & 1u) == 0) continue;
      if (cut_voxel(a, brick, (int)place, 8 * at.x, 8 * at.y, 8 * at.z, &material, &outline, &law, &tally))
        atomic_or(&removed_words[place >> 5], 1u << (place & 31u));
    }
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    for (uint block = item; block < 8; block += items) {
      brick->touched[2 * block] = brick->touched[2 * block + 1] = 0;
      remove_voxels(brick, substep, (int)block, removed_words[2 * block], removed_words[2 * block + 1], &tally.report);
    }
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    if (item == 0) {
      listed[slot] = 0;
      clear_if_empty(brick, occupancy, at, bricks);
    }
  }
  barrier(CLK_LOCAL_MEM_FENCE); /* without it PoCL 7.1 takes the number of records of another work-item */
  finish_tally(&tally, &law, &sums[substep]);
}

#endif
