/* Exact erosion over bricks (design §4): a voxel keeps the part of it that lies outside the tool. A brick goes through
 * all substeps of a visit at once, because no voxel depends on another; what it does to the tool falls into the
 * substeps' slots. Substeps come in windows, in which the tool moves so little that the voxels that it can meet are
 * found once. On a CPU (RS_LANES 16) sixteen voxels are clipped in the lanes of a vector, a brick to a work-item; on a
 * GPU a work-group takes a brick, a work-item every so many of its voxels.
 *
 * Compiled with RS_POOLS and RS_POOL_BITS, and with RS_DISTANCE_GRID where the teeth are resolved: the tool's distance
 * then comes from their grid instead of the envelope's profile. */
#include "candidates.h"
#include "brick_report.h"

#define SUMS 10 /* of a substep, as add_brick_sums() takes them */

/* What a substep's voxels add up to in a work-item, lane by lane. */
typedef struct {
#if defined(RS_LANES)
  LaneSums sums;
  long16 removed, contacts;
#else
  long unused;
#endif
} SubstepLanes;

#define PARAMETERS                                                                                              \
  __global const SubstepArgs *args, __global const SubstepWindow *windows, const uint window_count,             \
      __global const uint *listed, __global VisitCounts *counts, __global const uint *lattice_of_slot,          \
      __global uint *occupancy, const int4 bricks, __global int *page_of_slot, __global uint *slot_of_page,     \
      __global ushort *pages, __global SubstepSums *sums, __global RemovedBlock *removed,                       \
      __global const float *energy_of_grade, __global const OutlinePiece *pieces, __global const ushort *numbers, \
      __global const EdgeList *lists, __global const ProfileGrid *grid, __global SubstepLanes *lanes_of_item,           \
      RS_POOL_PARAMETERS TEETH_PARAMETERS

#if defined(RS_LANES)

void clear_lanes(__global SubstepLanes* lanes) {
  for (int i = 0; i < 3; ++i) lanes->sums.force[i] = lanes->sums.torque[i] = (long16)0;
  lanes->sums.floor_energy = lanes->sums.energy = lanes->removed = lanes->contacts = (long16)0;
}

long add_lanes(const long16 v) {
  const long8 a = v.lo + v.hi;
  return a.s0 + a.s1 + a.s2 + a.s3 + a.s4 + a.s5 + a.s6 + a.s7;
}

void add_up(__global const SubstepLanes* lanes, long* total) {
  for (int i = 0; i < 3; ++i) {
    total[i] = add_lanes(lanes->sums.force[i]);
    total[3 + i] = add_lanes(lanes->sums.torque[i]);
  }
  total[6] = add_lanes(lanes->sums.energy);
  total[7] = add_lanes(lanes->sums.floor_energy);
  total[8] = add_lanes(lanes->removed);
  total[9] = add_lanes(lanes->contacts);
}

/* Takes note of voxels that have nothing left. */
void note_gone(const Candidates* c, const int first, const int16 gone, uint* gone_words) {
  for (uint rest = bits_of(gone); rest != 0; rest &= rest - 1) {
    const int at = c->place[first + (int)popcount((rest & -rest) - 1)];
    gone_words[at >> 5] |= 1u << (at & 31);
  }
}

/* The tool next to sixteen candidates from the i-th on, and the fill that it leaves of whole ones. */
Clip clip_sixteen(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v, const Candidates* c,
                  const int i, int16* outside) {
  const int16 place = convert_int16(vload16(0, c->place + i));
  const float16 x = offset_x(place), y = offset_y(place), z = offset_z(place);
  Clip clip;
#ifdef RS_DISTANCE_GRID
  clip = rs_clip_grid(a, &v->teeth, v->corner, x, y, z);
  *outside = rs_fill_outside(&clip);
#else
  const EdgeList near = c->near[i >> 4];
  if (c->smooth[i >> 4]) {
    clip = rs_clip_smooth(a, outline->pieces + outline->numbers[near.first], v->corner, x, y, z);
    *outside = rs_fill_outside(&clip);
  } else {
    clip = rs_clip(a, outline, near, v->corner, x, y, z);
    *outside = rs_fill_outside(&clip);
  }
#endif
  return clip;
}

/* Cuts the candidates in one substep, or lets the lips' edges rub on them; true where any loses something. */
bool cut_candidates(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v, const uint substep,
                    Candidates* c, RemovedReport* report, __global SubstepLanes* total) {
  SubstepLanes lanes = *total;
  int16 removed = 0, contacts = 0, any_gone = 0;
  uint gone_words[RS_BRICK_WORDS] = {0};
  for (int i = 0; i < c->count; i += 16) {
    int16 outside;
    Clip clip = clip_sixteen(a, outline, v, c, i, &outside);
    const int16 before = vload16(0, c->fill + i), lost = rs_clip_loss(a, before, outside);
    if (rs_has_edge(a)) rs_edge_force(a, &clip, before - lost, outside, &lanes.sums);
    TURN_TO_FORCE(outline, v->list, &clip);
    rs_clip_force(a, &clip, vload16(0, c->energy + i), lost, &lanes.sums);
    removed += lost;
    contacts -= lost > 0;
    vstore16(before - lost, 0, c->fill + i);
    const int16 gone = lost > 0 && before == lost;
    any_gone |= gone;
    if (any(gone)) note_gone(c, i, gone, gone_words);
  }
  lanes.removed += convert_long16(removed);
  lanes.contacts += convert_long16(contacts);
  *total = lanes;
  if (any(any_gone)) {
    for (int block = 0; block < RS_BRICK_WORDS / 2; ++block) {
      const uint low = gone_words[2 * block], high = gone_words[2 * block + 1];
      v->brick->bone[2 * block] &= ~low;
      v->brick->bone[2 * block + 1] &= ~high;
      report_removed(report, substep, block, low, high);
    }
  }
  return any(contacts > 0);
}

__kernel void cut_exact(PARAMETERS) {
  const OutlineView outline = {pieces, numbers, lists, grid};
  __global Brick* pools[RS_POOLS] = RS_POOL_ARRAY;
  const uint first = windows[0].first, end = windows[window_count - 1].end;
  __global SubstepLanes* lanes = lanes_of_item + get_global_id(0) * RS_VISIT_SUBSTEPS;
  for (uint s = 0; s < end - first; ++s) clear_lanes(lanes + s);
  RemovedReport report;
  begin_report(&report, removed, &counts->removed);
  Candidates candidates;
  for (uint t = get_global_id(0); t < counts->listed; t += get_global_size(0)) {
    const uint slot = listed[t];
    report.brick = lattice_of_slot[slot];
    Visit v = begin_visit(slot, report.brick, bricks, pools[slot >> RS_POOL_BITS] + (slot & RS_POOL_MASK));
    TAKE_TEETH(v);
    bool any_cut = false;
    for (uint w = 0; w < window_count; ++w) {
      const SubstepWindow window = windows[w];
      begin_window(args + window.first, &outline, &v);
      const int page = page_of_slot[slot];
      find_candidates(args + window.first, &outline, &v, window.shift_mm * args->per_voxel_mm, page < 0 ? 0 : pages + (ulong)page * RS_BRICK_VOXELS, energy_of_grade, &candidates);
      if (candidates.count == 0) continue;
      bool cut = false;
      for (uint s = window.first; s < window.end; ++s) {
        go_to_substep(args + s, &v);
        cut |= cut_candidates(args + s, &outline, &v, s, &candidates, &report, lanes + (s - first));
      }
      if (!cut) continue;
      any_cut = true;
      __global ushort* fills = page_of(slot, page_of_slot, slot_of_page, pages, counts);
      for (int i = 0; i < candidates.count; ++i) fills[candidates.place[i]] = (ushort)candidates.fill[i];
    }
    if (any_cut) clear_if_empty(v.brick, occupancy, v.x >> 3, v.y >> 3, v.z >> 3, bricks);
  }
  hand_over_removed(&report);
  for (uint s = first; s < end; ++s) {
    long total[SUMS];
    add_up(lanes + (s - first), total);
    if (total[9] != 0 || rs_has_edge(args + s)) add_brick_sums(&sums[s], total);
  }
}

#else

/* The tool next to voxel (x, y, z) of the brick. */
Clip clip_one(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v, const float x, const float y,
              const float z) {
#ifdef RS_DISTANCE_GRID
  return rs_clip_grid(a, &v->teeth, v->corner, x, y, z);
#else
  return rs_clip(a, outline, v->list, v->corner, x, y, z);
#endif
}

/* What the work-item's voxels of the brick lose in one substep. */
void cut_voxels(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v, __global ushort* page,
                __global const float* energy_of_grade, __local uint* gone_words, long* total) {
  LaneSums sums = {{0, 0, 0}, {0, 0, 0}, 0, 0};
  for (uint place = get_local_id(0); place < RS_BRICK_VOXELS; place += get_local_size(0)) {
    if ((v->brick->bone[place >> 5] >> (place & 31u) & 1u) == 0) continue;
    const int at = (int)place;
    Clip clip = clip_one(a, outline, v, (float)rs_offset_x(at), (float)rs_offset_y(at), (float)rs_offset_z(at));
    const int before = page[place];
    const int outside = rs_fill_outside(&clip), lost = rs_clip_loss(a, before, outside);
    if (rs_has_edge(a)) rs_edge_force(a, &clip, before - lost, outside, &sums);
    if (lost == 0) continue;
    TURN_TO_FORCE(outline, v->list, &clip);
    rs_clip_force(a, &clip, energy_of_grade[v->brick->grade[place]], lost, &sums);
    page[place] = (ushort)(before - lost);
    total[8] += lost;
    total[9] += 1;
    if (lost == before) atomic_or(&gone_words[place >> 5], 1u << (place & 31u));
  }
  for (int i = 0; i < 3; ++i) {
    total[i] += sums.force[i];
    total[3 + i] += sums.torque[i];
  }
  total[6] += sums.energy;
  total[7] += sums.floor_energy;
}

__kernel void cut_exact(PARAMETERS) {
  __local uint gone_words[RS_BRICK_WORDS];
  __local int page_here;
  const OutlineView outline = {pieces, numbers, lists, grid};
  __global Brick* pools[RS_POOLS] = RS_POOL_ARRAY;
  const uint first = windows[0].first, end = windows[window_count - 1].end, listed_count = counts->listed;
  const uint item = get_local_id(0), items = get_local_size(0);
  RemovedReport report;
  begin_report(&report, removed, &counts->removed);
  /* Every work-item of a group makes the same rounds, so that all meet the barriers. */
  for (uint t = get_group_id(0); t < listed_count; t += get_num_groups(0)) {
    const uint slot = listed[t];
    report.brick = lattice_of_slot[slot];
    Visit v = begin_visit(slot, report.brick, bricks, pools[slot >> RS_POOL_BITS] + (slot & RS_POOL_MASK));
    TAKE_TEETH(v);
    if (item == 0) {
      page_of(slot, page_of_slot, slot_of_page, pages, counts);
      page_here = page_of_slot[slot];
    }
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    __global ushort* page = pages + (ulong)page_here * RS_BRICK_VOXELS;
    for (uint s = first; s < end; ++s) {
      for (uint w = item; w < RS_BRICK_WORDS; w += items) gone_words[w] = 0;
      barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
      long total[SUMS] = {0};
      begin_window(args + s, &outline, &v);
      cut_voxels(args + s, &outline, &v, page, energy_of_grade, gone_words, total);
      if (total[9] != 0 || rs_has_edge(args + s)) add_brick_sums(&sums[s], total);
      barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
      for (uint block = item; block < 8; block += items) {
        v.brick->bone[2 * block] &= ~gone_words[2 * block];
        v.brick->bone[2 * block + 1] &= ~gone_words[2 * block + 1];
        report_removed(&report, s, (int)block, gone_words[2 * block], gone_words[2 * block + 1]);
      }
      barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
    }
    if (item == 0) clear_if_empty(v.brick, occupancy, v.x >> 3, v.y >> 3, v.z >> 3, bricks);
    barrier(CLK_LOCAL_MEM_FENCE | CLK_GLOBAL_MEM_FENCE);
  }
  hand_over_removed(&report);
}

#endif
