// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "sim/bone/voxmap/voxmap.h"
#include "tests/bench/reference/frame.h"

namespace reamsim::reference {

/// Per byte the numbers of its bits, a byte each, lowest first; then zeros.
const std::vector<rs_u64>& bits_of_bytes();

/// The bricks of a bone of whole voxels, for the passes.
class BoneMemory {
 public:
  /// Throws RunError where bone is partly removed.
  explicit BoneMemory(const BoneView& bone);

  /// Restores the bone; the same voxmap.
  void restore(const Voxmap& voxmap);
  /// Marks a brick as one with bone. `brick`: coordinates in bricks.
  void occupy(const Vec3i& brick);
  /// Valid as long as this object.
  [[nodiscard]] BoneArrays arrays();

  [[nodiscard]] const VoxelGrid& grid() const { return grid_; }
  [[nodiscard]] const BrickLattice& lattice() const { return lattice_; }
  [[nodiscard]] std::size_t count() const { return bricks_.size(); }
  /// Place of a brick in the lattice. `slot`: its number in memory.
  [[nodiscard]] std::size_t lattice_index(std::size_t slot) const { return lattice_of_slot_[slot]; }
  /// A stored brick. `index`: in the lattice.
  Brick& brick_at(std::size_t index) { return bricks_[static_cast<std::size_t>(slot_of_brick_[index])]; }
  [[nodiscard]] std::size_t bytes() const;

 private:
  VoxelGrid grid_;
  BrickLattice lattice_;
  std::vector<Brick> bricks_;
  std::vector<rs_i32> slot_of_brick_;
  std::vector<rs_u32> lattice_of_slot_, occupancy_;
};

/// Index in the voxmap's grid of a voxel of a brick. `brick`: in the lattice of bricks; `place`: by rs_brick_offset.
std::int64_t voxel_index(const BoneMemory& bone, std::size_t brick, rs_i32 place);

}  // namespace reamsim::reference
