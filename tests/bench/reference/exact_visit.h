// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "kernels/bricks.h"
#include "kernels/window.h"
#include "tests/bench/reference/frame.h"

namespace reamsim::reference {

/// A voxel that a visit removed.
struct RemovedVoxel {
  rs_u32 brick;  ///< in the lattice of bricks
  rs_u16 place;  ///< by rs_brick_offset
  rs_u16 slot;   ///< of the substep
};

/// A visit of `exact` on plain memory, and what the threads add to. Energetic law, envelope of revolution.
struct ExactVisit {
  // substeps, by slot
  const SubstepArgs* args;
  const SubstepWindow* windows;  ///< without gaps
  rs_u32 window_count;
  const MotionWindow* motions;  ///< of the windows
  const float* times;           ///< of the substeps in their windows
  SubstepSums* sums;
  // superbricks that the tool's box overlaps, and how far the surface may be from them
  rs_i32 first_super[3], supers[3];
  float shift_mm;
  const CoarseGrid* coarse;
  const float* distances;
  // bone
  BoneArrays bone;
  rs_i32* page_of_slot;        ///< of fill, by brick; -1: whole
  rs_u16* fills;               ///< page after page; room for a page per listed brick
  const float* energy;         ///< cutting energy of a whole voxel by grade, mJ
  const rs_u64* bits_of_byte;  ///< bits_of_bytes()
  OutlineView outline;
  // results
  rs_u32* listed;  ///< bricks in reach
  rs_u32 listed_count;
  rs_u32 page_count;
  RemovedVoxel* removed;  ///< room for every voxel of the listed bricks
  rs_u32 removed_count;
  // the next piece of work that no thread has taken
  rs_u32 next_super;
  rs_u32 next_listed;
};

// Every thread calls list_bricks(); when all have returned, every thread calls cut_exact(). Each of these is the same
// source for another instruction set.
namespace plain {
void list_bricks(ExactVisit& visit);
void cut_exact(ExactVisit& visit);
}  // namespace plain
namespace avx2 {
void list_bricks(ExactVisit& visit);
void cut_exact(ExactVisit& visit);
}  // namespace avx2
namespace avx512 {
void list_bricks(ExactVisit& visit);
void cut_exact(ExactVisit& visit);
}  // namespace avx512

}  // namespace reamsim::reference
