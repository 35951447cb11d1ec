// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

/* Exact erosion: a brick during a visit of many substeps. With RS_DISTANCE_GRID the cutting edges are resolved, and the
 * grid of distances to them is part of it. */
#ifndef REAMSIM_KERNELS_VISIT_H
#define REAMSIM_KERNELS_VISIT_H

#include "brick_report.h"
#include "distance_grid.h"
#include "window.h"

#ifdef RS_DISTANCE_GRID
#define TEETH_PARAMETERS \
  , __global const DistanceLattice *teeth_lattice, __global const uint *teeth_slots, __global const float *teeth_samples
#define TEETH_VIEW \
  { teeth_lattice, teeth_slots, teeth_samples }
#else
#define TEETH_PARAMETERS
#define TEETH_VIEW \
  { 0, 0, 0 }
#endif

/* A brick in a visit. */
typedef struct {
  __global Brick* brick;
  int3 at;                              /* position in the lattice of bricks */
  BrickMiddle middle;                   /* in the current substep */
  PieceList list;                       /* pieces of the outline that can be nearest in the current window */
  __global const FaceBrick* face_brick; /* of the bone's faces; 0: none in this brick */
  __global const int* faces;
  DistanceView teeth; /* with RS_DISTANCE_GRID */
} Visit;

/* The brick with faces of a slot; 0: it has none. */
RS_INLINE __global const FaceBrick* face_brick_of(const uint slot, __global const int* number_of_slot,
                                                  __global const FaceBrick* bricks) {
  const int number = number_of_slot[slot];
  return number < 0 ? 0 : bricks + number;
}

RS_INLINE void set_substep(__global const SubstepArgs* a, Visit* v) {
  rs_brick_in_tool(a, 8 * v->at.x, 8 * v->at.y, 8 * v->at.z, &v->middle);
}

/* set_substep() for the first substep of a window. */
RS_INLINE void set_window(__global const SubstepArgs* a, const OutlineView* outline, Visit* v) {
  set_substep(a, v);
  v->list = rs_pieces_near_brick(outline, &v->middle);
}

/* The middle of a brick at the nodes of a window. */
typedef struct {
  BrickMiddle first, middle, last;
} NodeMiddles;

RS_INLINE NodeMiddles node_middles(__global const MotionWindow* w, const Visit* v) {
  const int x = 8 * v->at.x, y = 8 * v->at.y, z = 8 * v->at.z;
  NodeMiddles out;
  rs_brick_in_tool(&w->first, x, y, z, &out.first);
  rs_brick_in_tool(&w->middle, x, y, z, &out.middle);
  rs_brick_in_tool(&w->last, x, y, z, &out.last);
  return out;
}

/* The tool next to voxel (x, y, z) of the brick, by the pieces in `list`. */
RS_INLINE Clip clip_voxel(__global const SubstepArgs* a, const OutlineView* outline, const Visit* v,
                          const PieceList list, const rs_real x, const rs_real y, const rs_real z) {
#ifdef RS_DISTANCE_GRID
  return rs_clip_grid(a, &v->teeth, &v->middle, x, y, z);
#else
  return rs_clip(a, outline, list, &v->middle, x, y, z);
#endif
}

/* The normal of the force: the envelope's, also where the cutting edges are resolved. */
RS_INLINE void set_force_normal(const OutlineView* outline, const PieceList list, Clip* clip) {
#ifdef RS_DISTANCE_GRID
  rs_use_envelope_normal(outline, list, clip);
#endif
}

/* How far the cutting edges can lie outside the envelope's outline, mm. */
RS_INLINE float envelope_slack(const Visit* v) {
#ifdef RS_DISTANCE_GRID
  return v->teeth.lattice->slack_mm;
#else
  return 0.0f;
#endif
}

/* The page of a brick's fill. A brick without a page gets a new one of whole voxels. */
RS_INLINE __global ushort* find_or_add_page(const uint slot, __global int* page_of_slot, __global uint* slot_of_page,
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

#endif
