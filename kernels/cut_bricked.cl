/* Cut over bricks: every touched voxel loses fill, takes energy and pushes back (design §5). Work-items, or on a GPU
 * work-groups, stride over the list of touched bricks, whose length only the device knows. On a CPU (RS_LANES 8) eight
 * voxels go through the law in the lanes of a vector; on a GPU a work-item takes a voxel.
 *
 * Compiled with RS_POOLS, RS_POOL_BITS and, where voxels can be partly gone, RS_BRICK_FILL. */
#ifndef REAMSIM_KERNELS_SHARED_H
#include "shared.h"
#endif
#pragma OPENCL EXTENSION cl_khr_int64_base_atomics : enable

/* What a voxel is worth, by grade: mJ for the whole of it, and g/cm3. */
typedef struct {
  __global const double* energy;
  __global const double* density;
} Material;

/* Where the law reports: the removed voxels of the substep, and the counts beside the lanes' sums. */
typedef struct {
  __global RemovedInBrick* removed;
  __global uint* removed_count;
  uint brick;
  uint slot;
  long contacts;
  long fill;
} Tally;

void report_removed(Tally* tally, const int block, const ulong gone) {
  const uint count = (uint)popcount(gone);
  if (count == 0) return;
  uint at = atomic_add(tally->removed_count, count);
  for (ulong rest = gone; rest != 0; rest &= rest - 1) {
    const uint bit = (uint)popcount((rest & -rest) - 1);
    tally->removed[at].brick = tally->brick;
    tally->removed[at++].detail = tally->slot << 9 | (uint)block << 6 | bit;
  }
}

/* What voxel `place` loses, taken off its fill; mJ. `gone` says whether nothing is left. */
double lose(__global const SubstepArgs* a, __global Brick* brick, const Material* material, const int place,
            Tally* tally, bool* gone) {
  const uchar grade = brick->grade[place];
#ifdef RS_BRICK_FILL
  const int before = brick->fill[place];
  const int lost = rs_lost_fill(a, material->density[grade], before);
  brick->fill[place] = (ushort)(before - lost);
  *gone = lost == before;
#else
  const int lost = RS_WHOLE_FILL;
  *gone = true;
#endif
  tally->contacts += 1;
  tally->fill += lost;
  return rs_lost_energy(material->energy[grade], lost);
}

void add_sums(__global SubstepSums* total, const long* part) {
  for (int c = 0; c < 3; ++c) {
    if (part[c] != 0) atom_add(&total->force[c], part[c]);
    if (part[3 + c] != 0) atom_add(&total->torque[c], part[3 + c]);
  }
  atom_add(&total->energy, part[6]);
  if (part[7] != 0) atom_add(&total->floor_energy, part[7]);
  atom_add(&total->removed, part[8]);
  atom_add(&total->contacts, part[9]);
}

/* Clears the bit of a brick in which nothing is left, so that cells over it are passed over from now on. */
void clear_if_empty(__global const Brick* brick, __global uint* occupancy, const int x, const int y, const int z,
                    const int4 bricks) {
  uint left = 0;
  for (int w = 0; w < RS_BRICK_WORDS; ++w) left |= brick->bone[w];
  if (left != 0) return;
  const int superbrick = (x >> 2) + ((bricks.x + 3) >> 2) * ((y >> 2) + ((bricks.y + 3) >> 2) * (z >> 2));
  const uint bit = (uint)((x & 3) | (y & 3) << 2 | (z & 3) << 4);
  atomic_and(&occupancy[2 * superbrick + (bit >> 5)], ~(1u << (bit & 31u)));
}

#define PARAMETERS                                                                                                   \
  __global const SubstepArgs *args, const uint substep, __global const uint *lattice_of_slot, __global uint *listed, \
      __global uint *occupancy, __global const uint *touched_list, __global const uint *touched_count,               \
      __global SubstepSums *sums, __global RemovedInBrick *removed, __global uint *removed_count,                    \
      __global const double *energy_of_grade, __global const double *density_of_grade, const int4 bricks,            \
      __global const ProfileEdge *edges, __global const ushort *numbers, __global const EdgeList *lists,             \
      __global const ProfileGrid *grid, RS_POOL_PARAMETERS

#if defined(RS_LANES)

/* The edges that can be nearest to any voxel of a block with lowest voxel (x, y, z). */
EdgeList edges_near_block(__global const SubstepArgs* a, const ProfileView* profile, const int x, const int y,
                          const int z) {
  double p[3];
  for (int i = 0; i < 3; ++i) {
    __global const double* row = a->tool_from_voxel + 3 * i;
    p[i] = a->tool_origin[i] + row[0] * (x + 1.5) + row[1] * (y + 1.5) + row[2] * (z + 1.5);
  }
  return rs_edges_near(profile, sqrt(p[0] * p[0] + p[1] * p[1]), p[2]);
}

/* The touched voxels `bits` of one block, eight at a time; returns those that are gone. */
ulong cut_block(__global const SubstepArgs* a, __global Brick* brick, const int block, const int* corner, ulong bits,
                const Material* material, const ProfileView* profile, LaneSums* sums, Tally* tally) {
  ulong gone_bits = 0;
  const EdgeList list = edges_near_block(a, profile, corner[0], corner[1], corner[2]);
  while (bits != 0) {
    int bit[8];
    double energy[8];
    int lane = 0;
    for (; lane < 8 && bits != 0; ++lane, bits &= bits - 1) {
      bool gone;
      bit[lane] = popcount((bits & -bits) - 1);
      energy[lane] = lose(a, brick, material, block << 6 | bit[lane], tally, &gone);
      gone_bits |= (ulong)gone << bit[lane];
    }
    for (; lane < 8; ++lane) {
      bit[lane] = bit[0];
      energy[lane] = 0;
    }
    const int8 at = vload8(0, bit);
    const double8 whole = vload8(0, energy);
    if (a->law == RS_LAW_ENERGY) {
      double8 p[3];
      rs_voxel_in_tool(a, convert_double8(corner[0] + (at & 3)), convert_double8(corner[1] + (at >> 2 & 3)),
                       convert_double8(corner[2] + (at >> 4)), p);
      rs_cut_force(a, profile, list, p, whole, sums);
    } else {
      sums->energy += rs_quantise(whole, RS_ENERGY_SCALE);
    }
  }
  return gone_bits;
}

long add_lanes(const long8 v) {
  return v.s0 + v.s1 + v.s2 + v.s3 + v.s4 + v.s5 + v.s6 + v.s7;
}

__kernel void cut_bricked(PARAMETERS) {
  __global const SubstepArgs* a = args + substep;
  const uint count = touched_count[substep];
  const Material material = {energy_of_grade, density_of_grade};
  const ProfileView profile = {edges, numbers, lists, grid};
  __global Brick* pools[RS_POOLS] = RS_POOL_ARRAY;
  LaneSums lanes;
  for (int i = 0; i < 3; ++i) lanes.force[i] = lanes.torque[i] = (long8)0;
  lanes.energy = lanes.floor_energy = (long8)0;
  Tally tally = {removed, removed_count, 0, substep, 0, 0};
  for (uint t = get_global_id(0); t < count; t += get_global_size(0)) {
    const uint slot = touched_list[t];
    __global Brick* brick = pools[slot >> RS_POOL_BITS] + (slot & RS_POOL_MASK);
    listed[slot] = 0;
    tally.brick = lattice_of_slot[slot];
    const uint row = tally.brick / (uint)bricks.x;
    const int x = (int)(tally.brick % (uint)bricks.x), y = (int)(row % (uint)bricks.y), z = (int)(row / (uint)bricks.y);
    for (int block = 0; block < 8; ++block) {
      const ulong bits = brick->touched[2 * block] | (ulong)brick->touched[2 * block + 1] << 32;
      if (bits == 0) continue;
      const int corner[3] = {8 * x + 4 * (block & 1), 8 * y + 4 * (block >> 1 & 1), 8 * z + 4 * (block >> 2)};
      const ulong gone = cut_block(a, brick, block, corner, bits, &material, &profile, &lanes, &tally);
      brick->touched[2 * block] = brick->touched[2 * block + 1] = 0;
      brick->bone[2 * block] &= ~(uint)gone;
      brick->bone[2 * block + 1] &= ~(uint)(gone >> 32);
      report_removed(&tally, block, gone);
    }
    clear_if_empty(brick, occupancy, x, y, z, bricks);
  }
  const long part[10] = {add_lanes(lanes.force[0]),  add_lanes(lanes.force[1]),  add_lanes(lanes.force[2]),
                         add_lanes(lanes.torque[0]), add_lanes(lanes.torque[1]), add_lanes(lanes.torque[2]),
                         add_lanes(lanes.energy),    add_lanes(lanes.floor_energy), tally.fill, tally.contacts};
  if (tally.contacts != 0) add_sums(&sums[substep], part);
}

#else

/* One touched voxel; its bits are cleared by whoever owns the word afterwards. */
bool cut_voxel(__global const SubstepArgs* a, __global Brick* brick, const int place, const int x, const int y,
               const int z, const Material* material, const ProfileView* profile, LaneSums* sums, Tally* tally) {
  bool gone;
  const double energy = lose(a, brick, material, place, tally, &gone);
  if (a->law == RS_LAW_ENERGY) {
    double p[3];
    rs_voxel_in_tool(a, 8 * x + rs_offset_x(place), 8 * y + rs_offset_y(place), 8 * z + rs_offset_z(place), p);
    rs_cut_force(a, profile, rs_edges_near(profile, sqrt(p[0] * p[0] + p[1] * p[1]), p[2]), p, energy, sums);
  } else {
    sums->energy += rs_quantise(energy, RS_ENERGY_SCALE);
  }
  return gone;
}

__kernel void cut_bricked(PARAMETERS) {
  __local uint gone_words[RS_BRICK_WORDS];
  __global const SubstepArgs* a = args + substep;
  const uint count = touched_count[substep];
  const Material material = {energy_of_grade, density_of_grade};
  const ProfileView profile = {edges, numbers, lists, grid};
  __global Brick* pools[RS_POOLS] = RS_POOL_ARRAY;
  LaneSums sum = {{0, 0, 0}, {0, 0, 0}, 0, 0};
  Tally tally = {removed, removed_count, 0, substep, 0, 0};
  const uint item = get_local_id(0), items = get_local_size(0);
  /* Every work-item of a group makes the same number of rounds, so that all meet the barriers. */
  for (uint t = get_group_id(0); t < count; t += get_num_groups(0)) {
    const uint slot = touched_list[t];
    __global Brick* brick = pools[slot >> RS_POOL_BITS] + (slot & RS_POOL_MASK);
    tally.brick = lattice_of_slot[slot];
    const uint row = tally.brick / (uint)bricks.x;
    const int x = (int)(tally.brick % (uint)bricks.x), y = (int)(row % (uint)bricks.y), z = (int)(row / (uint)bricks.y);
    for (uint w = item; w < RS_BRICK_WORDS; w += items) gone_words[w] = 0;
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    for (uint place = item; place < RS_BRICK_VOXELS; place += items) {
      if ((brick->touched[place >> 5] >> (place & 31u) & 1u) == 0) continue;
      if (cut_voxel(a, brick, (int)place, x, y, z, &material, &profile, &sum, &tally))
        atomic_or(&gone_words[place >> 5], 1u << (place & 31u));
    }
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    for (uint block = item; block < 8; block += items) {
      brick->touched[2 * block] = brick->touched[2 * block + 1] = 0;
      brick->bone[2 * block] &= ~gone_words[2 * block];
      brick->bone[2 * block + 1] &= ~gone_words[2 * block + 1];
      report_removed(&tally, (int)block, gone_words[2 * block] | (ulong)gone_words[2 * block + 1] << 32);
    }
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    if (item == 0) {
      listed[slot] = 0;
      clear_if_empty(brick, occupancy, x, y, z, bricks);
    }
  }
  const long part[10] = {sum.force[0],  sum.force[1], sum.force[2],     sum.torque[0], sum.torque[1],
                         sum.torque[2], sum.energy,   sum.floor_energy, tally.fill,    tally.contacts};
  if (tally.contacts != 0) add_sums(&sums[substep], part);
}

#endif
