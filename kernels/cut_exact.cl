/* Exact erosion over bricks (design §4): a voxel keeps the part of it that lies outside the tool. A brick goes through
 * all substeps of a visit at once, because no voxel depends on another; what it does to the tool falls into the
 * substeps' slots. Substeps come in windows, in which the tool moves so little that the voxels that it can meet are
 * found once. On a CPU (RS_LANES 16) sixteen voxels are clipped in the lanes of a vector, a brick to a work-item; on a
 * GPU a work-group takes a brick, a work-item every so many of its voxels.
 *
 * Compiled with RS_POOLS and RS_POOL_BITS, and with RS_DISTANCE_GRID where the teeth are resolved: the tool's distance
 * then comes from their grid instead of the envelope's profile. */
#ifndef REAMSIM_KERNELS_CLIP_H
#include "clip.h"
#endif
#ifndef REAMSIM_KERNELS_DISTANCE_GRID_H
#include "distance_grid.h"
#endif
#ifndef REAMSIM_KERNELS_BRICK_REPORT_H
#include "brick_report.h"
#endif

/* More than positions in single precision are off by, mm. */
#define POSITION_SLACK 1e-4f

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

#ifdef RS_DISTANCE_GRID
#define TEETH_PARAMETERS                                                              \
  , __global const DistanceLattice *teeth_lattice, __global const uint *teeth_slots, \
      __global const float *teeth_samples
#define TEETH_MEMBER DistanceView teeth;
#define TAKE_TEETH(visit)                                                           \
  {                                                                                 \
    const DistanceView teeth = {teeth_lattice, teeth_slots, teeth_samples};         \
    (visit).teeth = teeth;                                                          \
  }
#define ENVELOPE_SLACK(visit) (visit)->teeth.lattice->slack_mm
/* The force goes by the envelope's normal. */
#define TURN_TO_FORCE(outline, list, clip) rs_face_envelope(outline, list, clip)
#else
#define TEETH_PARAMETERS
#define TEETH_MEMBER
#define TAKE_TEETH(visit)
#define ENVELOPE_SLACK(visit) 0.0f
#define TURN_TO_FORCE(outline, list, clip)
#endif

/* A brick on its way through a visit. */
typedef struct {
  __global Brick* brick;
  uint slot;
  int x, y, z;     /* its lowest voxel */
  float corner[3]; /* that voxel's centre in the substep at hand, T */
  EdgeList list;   /* pieces of the outline that can be nearest in the window at hand */
  TEETH_MEMBER
} Visit;

Visit begin_visit(const uint slot, const uint lattice, const int4 bricks, __global Brick* brick) {
  Visit v;
  v.brick = brick;
  v.slot = slot;
  const uint row = lattice / (uint)bricks.x;
  v.x = 8 * (int)(lattice % (uint)bricks.x);
  v.y = 8 * (int)(row % (uint)bricks.y);
  v.z = 8 * (int)(row / (uint)bricks.y);
  return v;
}

void go_to_substep(__global const SubstepArgs* a, Visit* v) {
  rs_brick_in_tool(a, v->x, v->y, v->z, v->corner);
}

/* As well, where a window begins with the substep. */
void begin_window(__global const SubstepArgs* a, const OutlineView* outline, Visit* v) {
  go_to_substep(a, v);
  float p[3];
  for (int i = 0; i < 3; ++i) {
    __global const double* row = a->tool_from_voxel + 3 * i;
    p[i] = v->corner[i] + (float)(3.5 * (row[0] + row[1] + row[2]));
  }
  v->list = rs_pieces_near(outline, sqrt(p[0] * p[0] + p[1] * p[1]), p[2]);
}

/* The brick's page of fill, a new one of whole voxels where it had none. */
__global ushort* page_of(const uint slot, __global int* page_of_slot, __global uint* slot_of_page,
                         __global ushort* pages, __global VisitCounts* counts) {
  int page = page_of_slot[slot];
  if (page < 0) {
    page = (int)atomic_inc(&counts->pages);
    page_of_slot[slot] = page;
    slot_of_page[page] = slot;
    for (int i = 0; i < RS_BRICK_VOXELS; ++i) pages[(ulong)page * RS_BRICK_VOXELS + i] = RS_WHOLE_FILL;
  }
  return pages + (ulong)page * RS_BRICK_VOXELS;
}

#if defined(RS_LANES)

/* The voxels of a brick that the tool can meet in a window, padded to a multiple of 16 with ones that have nothing
 * left. */
typedef struct {
  int count;
  ushort place[RS_BRICK_VOXELS + 16];
  int fill[RS_BRICK_VOXELS + 16];
  float energy[RS_BRICK_VOXELS + 16]; /* of the whole voxel, mJ */
  EdgeList near[RS_BRICK_VOXELS / 16 + 1]; /* of each sixteen: the pieces that can be nearest */
  bool smooth[RS_BRICK_VOXELS / 16 + 1];   /* one piece alone, far from its ends */
} Candidates;

float16 offset_x(const int16 place) {
  return convert_float16((place >> 6 & 1) << 2 | (place & 3));
}
float16 offset_y(const int16 place) {
  return convert_float16((place >> 7 & 1) << 2 | (place >> 2 & 3));
}
float16 offset_z(const int16 place) {
  return convert_float16((place >> 8 & 1) << 2 | (place >> 4 & 3));
}

/* Of sixteen voxels: the part of the brick's list from the first to the last piece that can be nearest to any of them
 * while the tool moves by `shift` mm, and whether they lie far from that piece's ends if it is one. */
void look_near(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v, const int16 place,
               const float shift, EdgeList* near, bool* smooth) {
  const EdgeList list = v->list;
  float16 p[3];
  rs_voxel_in_tool(a, v->corner, offset_x(place), offset_y(place), offset_z(place), p);
  const float16 r = sqrt(p[0] * p[0] + p[1] * p[1]);
  const float16 limit = fabs(rs_outline_nearest(outline, list, r, p[2]).distance) + 2.0f * (shift + POSITION_SLACK);
  uint begin = list.count, end = 0;
  for (uint i = 0; i < list.count; ++i) {
    const EdgeList one = {list.first + i, 1};
    if (!any(fabs(rs_outline_nearest(outline, one, r, p[2]).distance) <= limit)) continue;
    begin = min(begin, i);
    end = i + 1;
  }
  near->first = list.first + begin;
  near->count = end - begin;
  __global const OutlinePiece* piece = outline->pieces + outline->numbers[near->first];
  const float margin = RS_CLIP_REACH * a->voxel_mm + shift + POSITION_SLACK;
  *smooth = near->count == 1 && all(rs_from_ends(piece, r, p[2]) > margin);
}

#ifdef RS_DISTANCE_GRID

/* How much further than it can matter a voxel's centre lies from the teeth, voxels, while the tool moves by `shift`. */
float16 beyond_reach(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v, const float16 x,
                     const float16 y, const float16 z, const float shift) {
  const float slack = RS_CLIP_REACH + RS_GRID_STEEPEST * shift + POSITION_SLACK * a->per_voxel_mm;
  return rs_clip_grid_distance(a, &v->teeth, v->corner, x, y, z) * a->per_voxel_mm - slack;
}

#else

/* Half the width of a voxel along the surface's normal, voxels, and what more it can be while the tool moves by `shift`
 * voxels: the normal turns with the surface's curvature, and with the tool. Next to an edge of the outline it jumps. */
float16 half_width(__global const SubstepArgs* a, const OutlineView* outline, const EdgeList list,
                   const NearestPiece* nearest, const float16 px, const float16 py, const float16 r, const float shift) {
  const float widest = RS_CLIP_REACH;
  __global const OutlinePiece* piece = outline->pieces + outline->numbers[list.first];
  if (list.count > 1 || piece->before >= 0 || piece->after >= 0) return (float16)widest;
  const float16 per_r = 1.0f / fmax(r, 0.5f * a->voxel_mm);
  const ClipPlane plane = rs_clip_plane(a, px * per_r, py * per_r, nearest->normal_r, nearest->normal_z,
                                        nearest->distance, nearest->curvature, per_r);
  const float16 turn = (fabs(nearest->curvature) + fabs(nearest->normal_r) * per_r) * a->voxel_mm;
  const float16 width = 0.5f * (fabs(plane.n[0]) + fabs(plane.n[1]) + fabs(plane.n[2]));
  return fmin(width + (turn * (1.0f / 24.0f) + 0.02f) + shift * (2.0f * turn + 0.1f), widest);
}

/* How much further than it can matter a voxel's centre lies from the surface, voxels, while the tool moves by `shift`. */
float16 beyond_reach(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v, const float16 x,
                     const float16 y, const float16 z, const float shift) {
  float16 p[3];
  rs_voxel_in_tool(a, v->corner, x, y, z, p);
  const float16 r = sqrt(p[0] * p[0] + p[1] * p[1]);
  const NearestPiece nearest = rs_outline_nearest(outline, v->list, r, p[2]);
  const float slack = shift + POSITION_SLACK * a->per_voxel_mm;
  return nearest.distance * a->per_voxel_mm - half_width(a, outline, v->list, &nearest, p[0], p[1], r, slack) - slack;
}

#endif

/* A bit for every lane that holds. */
uint bits_of(const int16 holds) {
  const int16 bit =
      holds & (int16)(1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768);
  const int8 eight = bit.lo | bit.hi;
  const int4 four = eight.lo | eight.hi;
  const int2 two = four.lo | four.hi;
  return (uint)(two.x | two.y);
}

/* Voxels that the surface can meet while the tool moves by `shift` voxels; what lies inside it goes in any case. */
void find_candidates(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v, const float shift,
                     __global const ushort* page, __global const float* energy_of_grade, Candidates* c) {
  const int16 lane = (int16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
  c->count = 0;
  /* Eight blocks of 4x4x4 voxels first, by the envelope, which holds the teeth; then in those that are near, layers of 16
   * voxels. */
  const float16 middle = rs_clip_distance(a, outline, v->list, v->corner, convert_float16((lane & 1) << 2) + 1.5f,
                                          convert_float16((lane & 2) << 1) + 1.5f, convert_float16(lane & 4) + 1.5f);
  const float near = RS_CLIP_REACH + 2.6f + 0.1f + shift + ENVELOPE_SLACK(v) * a->per_voxel_mm;
  const uint blocks = bits_of(middle * a->per_voxel_mm <= near);
  for (int block = 0; block < 8; ++block) {
    if ((blocks >> block & 1u) == 0) continue;
    const float16 x = convert_float16((block & 1) << 2 | (lane & 3)), y = convert_float16((block & 2) << 1 | lane >> 2);
    for (int layer = 0; layer < 4; ++layer) {
      const int first = block << 6 | layer << 4;
      const uint bone = v->brick->bone[first >> 5] >> (first & 31) & 0xffffu;
      if (bone == 0) continue;
      const float16 z = (float16)(float)((block & 4) | layer);
      uint rest = bone & bits_of(beyond_reach(a, outline, v, x, y, z, shift) <= 0.0f);
      for (; rest != 0; rest &= rest - 1) {
        const int place = first + (int)popcount((rest & -rest) - 1);
        c->place[c->count] = (ushort)place;
        c->fill[c->count] = page == 0 ? RS_WHOLE_FILL : page[place];
        c->energy[c->count] = energy_of_grade[v->brick->grade[place]];
        ++c->count;
      }
    }
  }
  vstore16((ushort16)0, 0, c->place + c->count);
  vstore16((int16)0, 0, c->fill + c->count);
  vstore16((float16)0.0f, 0, c->energy + c->count);
#ifndef RS_DISTANCE_GRID
  for (int i = 0; i < c->count; i += 16)
    look_near(a, outline, v, convert_int16(vload16(0, c->place + i)), shift * a->voxel_mm, c->near + (i >> 4),
              c->smooth + (i >> 4));
#endif
}

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
