/* Cut over bricks: every touched voxel loses fill, takes energy and pushes back (design §5). Work-items, or on a GPU
 * work-groups, stride over the list of touched bricks, whose length only the device knows. On a CPU (RS_LANES 16)
 * sixteen voxels go through the law in the lanes of a vector; on a GPU a work-item takes a voxel.
 *
 * Compiled with RS_POOLS, RS_POOL_BITS and, where voxels can be partly gone, RS_BRICK_FILL. */
#include "brick_report.h"
#pragma OPENCL EXTENSION cl_khr_int64_base_atomics : enable

/* What a voxel is worth, by grade: mJ for the whole of it, also in units of the sum, and g/cm3. */
typedef struct {
  __global const double* energy;
  __global const long* units;
  __global const double* density;
} Material;

/* What the cut reports besides the law's sums. */
typedef struct {
  RemovedReport gone;
  long contacts;
  long fill;
  long energy;
} Tally;

#ifdef RS_BRICK_FILL
/* What voxel `place` loses, taken off its fill; mJ. `gone` says whether nothing is left. */
float lose(__global const SubstepArgs* a, __global Brick* brick, const Material* material, const int place,
           Tally* tally, bool* gone) {
  const uchar grade = brick->grade[place];
  const int before = brick->fill[place];
  const int lost = rs_lost_fill(a, material->density[grade], before);
  const double energy = rs_lost_energy(material->energy[grade], lost);
  brick->fill[place] = (ushort)(before - lost);
  *gone = lost == before;
  tally->contacts += 1;
  tally->fill += lost;
  tally->energy += rs_energy_units(energy);
  return (float)energy;
}
#else
/* The same where voxels are whole or gone. */
float lose(__global const SubstepArgs* a, __global Brick* brick, const Material* material, const int place,
           Tally* tally, bool* gone) {
  const uchar grade = brick->grade[place];
  *gone = true;
  tally->contacts += 1;
  tally->fill += RS_WHOLE_FILL;
  tally->energy += material->units[grade];
  return (float)material->energy[grade];
}
#endif

#define PARAMETERS                                                                                                   \
  __global const SubstepArgs *args, const uint substep, __global const uint *lattice_of_slot, __global uint *listed, \
      __global uint *occupancy, __global const uint *touched_list, __global const uint *touched_count,               \
      __global SubstepSums *sums, __global RemovedBlock *removed, __global uint *removed_count, const uint2 room,    \
      __global const uint *removed_before, __global const double *energy_of_grade,                                   \
      __global const long *units_of_grade, __global const double *density_of_grade,                                  \
      __global const ulong *bits_of_byte, const int4 bricks, __global const ProfileEdge *edges,                      \
      __global const ushort *numbers, __global const EdgeList *lists, __global const ProfileGrid *grid,              \
      RS_POOL_PARAMETERS

/* Whether the substep has to wait for room in the list of removed voxels. The host learns it from an impossible number
 * of contacts. */
bool stalls(const uint2 room, __global const uint* removed_before, __global const uint* touched_count,
            const uint substep, __global SubstepSums* sums) {
  const bool stalled = rs_stalls(room.x, room.y, removed_before[substep], touched_count[substep]);
  if (stalled && get_global_id(0) == 0) sums[substep].contacts = -1;
  return stalled;
}

#if defined(RS_LANES)

/* The edges that can be nearest to any voxel of the brick whose lowest voxel's centre is `corner`, T. */
EdgeList edges_near_brick(__global const SubstepArgs* a, const ProfileView* profile, const float* corner) {
  float p[3];
  for (int i = 0; i < 3; ++i) {
    __global const double* row = a->tool_from_voxel + 3 * i;
    p[i] = corner[i] + (float)(3.5 * (row[0] + row[1] + row[2]));
  }
  return rs_edges_near(profile, sqrt(p[0] * p[0] + p[1] * p[1]), p[2]);
}

/* Lists the places of the touched voxels, in ascending order and padded to a multiple of 16; returns how many.
 * `bits_of_byte[b]`: the numbers of the bits of b, a byte each, lowest first. */
int list_places(__global const Brick* brick, __global const ulong* bits_of_byte, ushort* places) {
  int count = 0;
  for (int w = 0; w < RS_BRICK_WORDS; ++w) {
    const uint word = brick->touched[w];
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

/* Takes what the listed voxels lose, and their bits out of the brick where they are gone. */
void lose_all(__global const SubstepArgs* a, const uint substep, __global Brick* brick, const Material* material,
              const ushort* places, const int count, float* energies, Tally* tally) {
#ifdef RS_BRICK_FILL
  uint gone_words[RS_BRICK_WORDS] = {0};
#endif
  for (int i = 0; i < count; ++i) {
    bool gone;
    energies[i] = lose(a, brick, material, places[i], tally, &gone);
#ifdef RS_BRICK_FILL
    gone_words[places[i] >> 5] |= (uint)gone << (places[i] & 31);
#endif
  }
  vstore16((float16)0.0f, 0, energies + count);
  for (int block = 0; block < RS_BRICK_WORDS / 2; ++block) {
#ifdef RS_BRICK_FILL
    const uint low = gone_words[2 * block], high = gone_words[2 * block + 1];
#else
    const uint low = brick->touched[2 * block], high = brick->touched[2 * block + 1];
#endif
    brick->bone[2 * block] &= ~low;
    brick->bone[2 * block + 1] &= ~high;
    brick->touched[2 * block] = brick->touched[2 * block + 1] = 0;
    report_removed(&tally->gone, substep, block, low, high);
  }
}

/* The law for the listed voxels, sixteen at a time. */
void push_back(__global const SubstepArgs* a, const ProfileView* profile, const int x, const int y, const int z,
               const ushort* places, const float* energies, const int count, LaneSums* sums) {
  float corner[3];
  rs_brick_in_tool(a, x, y, z, corner);
  const EdgeList list = edges_near_brick(a, profile, corner);
  for (int i = 0; i < count; i += 16) {
    const int16 place = convert_int16(vload16(0, places + i));
    const float16 lx = convert_float16((place >> 6 & 1) << 2 | (place & 3));
    const float16 ly = convert_float16((place >> 7 & 1) << 2 | (place >> 2 & 3));
    const float16 lz = convert_float16((place >> 8 & 1) << 2 | (place >> 4 & 3));
    float16 p[3];
    rs_voxel_in_tool(a, corner, lx, ly, lz, p);
    float16 n[3];
    rs_tool_nearest(profile, list, p, n);
    rs_cut_force(a, n, p, vload16(0, energies + i), sums);
  }
}

long add_lanes(const long16 v) {
  const long8 a = v.lo + v.hi;
  return a.s0 + a.s1 + a.s2 + a.s3 + a.s4 + a.s5 + a.s6 + a.s7;
}

__kernel void cut_bricked(PARAMETERS) {
  __global const SubstepArgs* a = args + substep;
  const bool stalled = stalls(room, removed_before, touched_count, substep, sums);
  const uint count = stalled ? 0 : touched_count[substep];
  const Material material = {energy_of_grade, units_of_grade, density_of_grade};
  const ProfileView profile = {edges, numbers, lists, grid};
  __global Brick* pools[RS_POOLS] = RS_POOL_ARRAY;
  LaneSums lanes;
  for (int i = 0; i < 3; ++i) lanes.force[i] = lanes.torque[i] = (long16)0;
  lanes.floor_energy = lanes.energy = (long16)0;
  Tally tally;
  begin_report(&tally.gone, removed, removed_count);
  tally.contacts = tally.fill = tally.energy = 0;
  ushort places[RS_BRICK_VOXELS + 16];
  float energies[RS_BRICK_VOXELS + 16];
  for (uint t = get_global_id(0); t < count; t += get_global_size(0)) {
    const uint slot = touched_list[t];
    __global Brick* brick = pools[slot >> RS_POOL_BITS] + (slot & RS_POOL_MASK);
    listed[slot] = 0;
    tally.gone.brick = lattice_of_slot[slot];
    const uint row = tally.gone.brick / (uint)bricks.x;
    const int x = (int)(tally.gone.brick % (uint)bricks.x), y = (int)(row % (uint)bricks.y),
              z = (int)(row / (uint)bricks.y);
    const int touched = list_places(brick, bits_of_byte, places);
    lose_all(a, substep, brick, &material, places, touched, energies, &tally);
    if (a->law == RS_LAW_ENERGY) push_back(a, &profile, 8 * x, 8 * y, 8 * z, places, energies, touched, &lanes);
    clear_if_empty(brick, occupancy, x, y, z, bricks);
  }
  hand_over_removed(&tally.gone);
  const long part[10] = {add_lanes(lanes.force[0]),
                         add_lanes(lanes.force[1]),
                         add_lanes(lanes.force[2]),
                         add_lanes(lanes.torque[0]),
                         add_lanes(lanes.torque[1]),
                         add_lanes(lanes.torque[2]),
                         tally.energy + add_lanes(lanes.energy),
                         add_lanes(lanes.floor_energy),
                         tally.fill,
                         tally.contacts};
  if (tally.contacts != 0) add_brick_sums(&sums[substep], part);
}

#else

/* One touched voxel; its bits are cleared by whoever owns the word afterwards. */
bool cut_voxel(__global const SubstepArgs* a, __global Brick* brick, const int place, const int x, const int y,
               const int z, const Material* material, const ProfileView* profile, LaneSums* sums, Tally* tally) {
  bool gone;
  const float energy = lose(a, brick, material, place, tally, &gone);
  if (a->law == RS_LAW_ENERGY)
    rs_voxel_force(a, profile, 8 * x + rs_offset_x(place), 8 * y + rs_offset_y(place), 8 * z + rs_offset_z(place),
                   energy, sums);
  return gone;
}

__kernel void cut_bricked(PARAMETERS) {
  __local uint gone_words[RS_BRICK_WORDS];
  __global const SubstepArgs* a = args + substep;
  const bool stalled = stalls(room, removed_before, touched_count, substep, sums);
  const uint count = stalled ? 0 : touched_count[substep];
  const Material material = {energy_of_grade, units_of_grade, density_of_grade};
  const ProfileView profile = {edges, numbers, lists, grid};
  __global Brick* pools[RS_POOLS] = RS_POOL_ARRAY;
  LaneSums sum = {{0, 0, 0}, {0, 0, 0}, 0, 0};
  Tally tally;
  begin_report(&tally.gone, removed, removed_count);
  tally.contacts = tally.fill = tally.energy = 0;
  const uint item = get_local_id(0), items = get_local_size(0);
  /* Every work-item of a group makes the same number of rounds, so that all meet the barriers. */
  for (uint t = get_group_id(0); t < count; t += get_num_groups(0)) {
    const uint slot = touched_list[t];
    __global Brick* brick = pools[slot >> RS_POOL_BITS] + (slot & RS_POOL_MASK);
    tally.gone.brick = lattice_of_slot[slot];
    const uint row = tally.gone.brick / (uint)bricks.x;
    const int x = (int)(tally.gone.brick % (uint)bricks.x), y = (int)(row % (uint)bricks.y),
              z = (int)(row / (uint)bricks.y);
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
      report_removed(&tally.gone, substep, (int)block, gone_words[2 * block], gone_words[2 * block + 1]);
    }
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    if (item == 0) {
      listed[slot] = 0;
      clear_if_empty(brick, occupancy, x, y, z, bricks);
    }
  }
  hand_over_removed(&tally.gone);
  const long part[10] = {sum.force[0],
                         sum.force[1],
                         sum.force[2],
                         sum.torque[0],
                         sum.torque[1],
                         sum.torque[2],
                         tally.energy + sum.energy,
                         sum.floor_energy,
                         tally.fill,
                         tally.contacts};
  if (tally.contacts != 0) add_brick_sums(&sums[substep], part);
}

#endif
