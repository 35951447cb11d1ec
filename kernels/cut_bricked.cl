/* Cut over bricks: every touched voxel loses fill, takes energy and exerts a force (docs/physics.md, 4). Work-items, or
 * work-groups on a GPU, stride over the list of touched bricks, whose length only the device knows. On a CPU (RS_LANES
 * 16) the law is evaluated for sixteen voxels in the lanes of a vector; on a GPU a work-item takes one voxel.
 *
 * Compiled with RS_POOLS, RS_POOL_BITS and, where voxels can be partly removed, RS_BRICK_FILL. */
#include "brick_report.h"

/* Tables by grade: energy of a whole voxel in mJ and in units of the energy sum, and density in g/cm3. */
typedef struct {
  __global const double* energy;
  __global const long* units;
  __global const double* density;
} Material;

/* Integer sums of a work-item, beside those of the law. */
typedef struct {
  RemovedReport report;
  long contacts;
  long fill;
  long energy;
} Tally;

/* Lowers the fill of voxel `place`. Returns the energy, mJ; `removed` tells whether no fill remains. */
float remove_fill(__global const SubstepArgs* a, __global Brick* brick, const Material* material, const int place,
                  Tally* tally, bool* removed) {
  const uchar grade = brick->grade[place];
  tally->contacts += 1;
#ifdef RS_BRICK_FILL
  const int before = brick->fill[place];
  const int lost = rs_lost_fill(a, material->density[grade], before);
  const double energy = rs_lost_energy(material->energy[grade], lost);
  brick->fill[place] = (ushort)(before - lost);
  *removed = lost == before;
  tally->fill += lost;
  tally->energy += rs_energy_units(energy);
  return (float)energy;
#else
  *removed = true;
  tally->fill += RS_WHOLE_FILL;
  tally->energy += material->units[grade];
  return (float)material->energy[grade];
#endif
}

#define PARAMETERS                                                                                                   \
  const uint substep, __global const SubstepArgs *args, __global const uint *lattice_of_slot, __global uint *listed, \
      __global uint *occupancy, __global const uint *touched_list, __global const uint *touched_count,               \
      __global SubstepSums *sums, __global RemovedBlock *removed, __global uint *removed_count, const uint2 room,    \
      __global const uint *removed_before, __global const double *energy_of_grade,                                   \
      __global const long *units_of_grade, __global const double *density_of_grade,                                  \
      __global const ulong *bits_of_byte, const int4 bricks, __global const OutlinePiece *pieces,                    \
      __global const ushort *numbers, __global const PieceList *lists, __global const OutlineGrid *grid,             \
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

/* Lists the places of the touched voxels in ascending order, padded to a multiple of 16. Returns their number.
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

/* Lowers the fill of the listed voxels, and removes those without fill from the brick. */
void remove_all_fill(__global const SubstepArgs* a, const uint substep, __global Brick* brick, const Material* material,
                     const ushort* places, const int count, float* energies, Tally* tally) {
#ifdef RS_BRICK_FILL
  uint removed_words[RS_BRICK_WORDS] = {0};
#else
  __global const uint* removed_words = brick->touched; /* a touched voxel is removed whole */
#endif
  for (int i = 0; i < count; ++i) {
    bool removed;
    energies[i] = remove_fill(a, brick, material, places[i], tally, &removed);
#ifdef RS_BRICK_FILL
    removed_words[places[i] >> 5] |= (uint)removed << (places[i] & 31);
#endif
  }
  vstore16((float16)0.0f, 0, energies + count);
  for (int block = 0; block < RS_BRICK_WORDS / 2; ++block) {
    remove_voxels(brick, substep, block, removed_words[2 * block], removed_words[2 * block + 1], &tally->report);
    brick->touched[2 * block] = brick->touched[2 * block + 1] = 0;
  }
}

/* The law for the listed voxels, sixteen at a time. (x, y, z): lowest voxel of the brick. */
void accumulate_cut_forces(__global const SubstepArgs* a, const OutlineView* outline, const int x, const int y,
                           const int z, const ushort* places, const float* energies, const int count, LaneSums* sums) {
  float corner[3], middle[3];
  rs_brick_in_tool(a, x, y, z, corner);
  rs_brick_middle(a, corner, middle);
  const PieceList list = rs_pieces_near(outline, sqrt(middle[0] * middle[0] + middle[1] * middle[1]), middle[2]);
  for (int i = 0; i < count; i += 16) {
    const int16 place = convert_int16(vload16(0, places + i));
    const float16 lx = convert_float16((place >> 6 & 1) << 2 | (place & 3));
    const float16 ly = convert_float16((place >> 7 & 1) << 2 | (place >> 2 & 3));
    const float16 lz = convert_float16((place >> 8 & 1) << 2 | (place >> 4 & 3));
    float16 p[3], n[3];
    rs_voxel_in_tool(a, corner, lx, ly, lz, p);
    rs_outline_normal(outline, list, p, n);
    rs_cut_force(a, n, p, vload16(0, energies + i), sums);
  }
}

__kernel void cut_bricked(PARAMETERS) {
  __global const SubstepArgs* a = args + substep;
  const uint count = bricks_to_cut(room, removed_before, touched_count, substep, sums);
  const Material material = {energy_of_grade, units_of_grade, density_of_grade};
  const OutlineView outline = {pieces, numbers, lists, grid};
  __global Brick* pools[RS_POOLS] = RS_POOL_ARRAY;
  LaneSums law = zero_sums();
  Tally tally;
  begin_tally(&tally, removed, removed_count);
  ushort places[RS_BRICK_VOXELS + 16];
  float energies[RS_BRICK_VOXELS + 16];
  for (uint t = get_global_id(0); t < count; t += get_global_size(0)) {
    const uint slot = touched_list[t];
    __global Brick* brick = pools[slot >> RS_POOL_BITS] + (slot & RS_POOL_MASK);
    listed[slot] = 0;
    tally.report.brick = lattice_of_slot[slot];
    const int3 at = brick_position(tally.report.brick, bricks);
    const int touched = list_places(brick, bits_of_byte, places);
    remove_all_fill(a, substep, brick, &material, places, touched, energies, &tally);
    if (a->law == RS_LAW_ENERGY)
      accumulate_cut_forces(a, &outline, 8 * at.x, 8 * at.y, 8 * at.z, places, energies, touched, &law);
    clear_if_empty(brick, occupancy, at, bricks);
  }
  finish_tally(&tally, &law, &sums[substep]);
}

#else

/* Cuts one touched voxel; the touched bit is cleared later by the work-item of its block. Returns whether no fill
 * remains. (x, y, z): lowest voxel of the brick. */
bool cut_voxel(__global const SubstepArgs* a, __global Brick* brick, const int place, const int x, const int y,
               const int z, const Material* material, const OutlineView* outline, LaneSums* law, Tally* tally) {
  bool removed;
  const float energy = remove_fill(a, brick, material, place, tally, &removed);
  if (a->law == RS_LAW_ENERGY)
    rs_voxel_force(a, outline, x + rs_offset_x(place), y + rs_offset_y(place), z + rs_offset_z(place), energy, law);
  return removed;
}

__kernel void cut_bricked(PARAMETERS) {
  __local uint removed_words[RS_BRICK_WORDS];
  __global const SubstepArgs* a = args + substep;
  const uint count = bricks_to_cut(room, removed_before, touched_count, substep, sums);
  const Material material = {energy_of_grade, units_of_grade, density_of_grade};
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
  finish_tally(&tally, &law, &sums[substep]);
}

#endif
