/* Exact erosion's visit of a brick: what of it stands while the brick goes through many substeps. With RS_DISTANCE_GRID
 * the tool's teeth are resolved, and a grid of distances to them comes along. */
#ifndef REAMSIM_KERNELS_VISIT_H
#define REAMSIM_KERNELS_VISIT_H

#include "bricks.h"
#include "distance_grid.h"

#ifdef RS_DISTANCE_GRID
#define TEETH_PARAMETERS \
  , __global const DistanceLattice *teeth_lattice, __global const uint *teeth_slots, __global const float *teeth_samples
#define TEETH_MEMBER DistanceView teeth;
#define TAKE_TEETH(visit)                                                   \
  {                                                                         \
    const DistanceView teeth = {teeth_lattice, teeth_slots, teeth_samples}; \
    (visit).teeth = teeth;                                                  \
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

RS_INLINE Visit begin_visit(const uint slot, const uint lattice, const int4 bricks, __global Brick* brick) {
  Visit v;
  v.brick = brick;
  v.slot = slot;
  const uint row = lattice / (uint)bricks.x;
  v.x = 8 * (int)(lattice % (uint)bricks.x);
  v.y = 8 * (int)(row % (uint)bricks.y);
  v.z = 8 * (int)(row / (uint)bricks.y);
  return v;
}

RS_INLINE void go_to_substep(__global const SubstepArgs* a, Visit* v) {
  rs_brick_in_tool(a, v->x, v->y, v->z, v->corner);
}

/* As well, where a window begins with the substep. */
RS_INLINE void begin_window(__global const SubstepArgs* a, const OutlineView* outline, Visit* v) {
  go_to_substep(a, v);
  float p[3];
  for (int i = 0; i < 3; ++i) {
    __global const double* row = a->tool_from_voxel + 3 * i;
    p[i] = v->corner[i] + (float)(3.5 * (row[0] + row[1] + row[2]));
  }
  v->list = rs_pieces_near(outline, sqrt(p[0] * p[0] + p[1] * p[1]), p[2]);
}

/* The brick's page of fill, a new one of whole voxels where it had none. */
RS_INLINE __global ushort* page_of(const uint slot, __global int* page_of_slot, __global uint* slot_of_page,
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
