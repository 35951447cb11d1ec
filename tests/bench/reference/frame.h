// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "kernels/bricks.h"
#include "kernels/outline.h"

// What the passes of every instruction set share. No inline functions in here, nor in any header that the passes
// include: the linker keeps one copy of them, which must not hold instructions that the processor lacks.
namespace reamsim::reference {

/// Points of the shell's cells are padded to a multiple of this.
inline constexpr int kPadding = 16;

/// The bone, in the structures of the engines (kernels/bricks.h).
struct BoneArrays {
  Brick* bricks;
  const rs_i32* slot_of_brick;  ///< -1: no bone
  const rs_u32* lattice_of_slot;
  rs_u32* occupancy;     ///< two words per 4×4×4 bricks
  rs_i32 brick_dims[3];  ///< of the lattice
};

/// One substep of `bricked` on plain memory, and what the threads add to. Energetic law, erosion `remove`, voxels whole
/// or removed.
struct Frame {
  const SubstepArgs* args;
  // shell
  const ShellCell* runs;
  rs_u32 run_count;
  const ShellCell* cells;
  const rs_u16* offsets;
  BoneArrays bone;
  const rs_i64* units;         // cutting energy of a voxel by grade
  const rs_u64* bits_of_byte;  ///< bits_of_bytes()
  OutlineView outline;
  // what detect leaves for cut
  rs_u32* listed;  ///< per slot
  rs_u32* touched_list;
  rs_u32 touched_count;
  // results
  RemovedBlock* removed;
  rs_u32 removed_count;
  SubstepSums sums;
  // the next piece of work that no thread has taken yet
  rs_u32 next_run;
  rs_u32 next_touched;
};

// Every thread calls detect(); when all have returned, every thread calls cut(). The results are then the sum over the
// threads. Each of these is the same source for another instruction set.
namespace plain {
void detect(Frame& f);
void cut(Frame& f);
}  // namespace plain
namespace avx2 {
void detect(Frame& f);
void cut(Frame& f);
}  // namespace avx2
namespace avx512 {
void detect(Frame& f);
void cut(Frame& f);
}  // namespace avx512

}  // namespace reamsim::reference
