#pragma once

#include <array>
#include <cstdint>
#include <utility>
#include <vector>

#include "sim/bone/voxmap/brick_lattice.h"

namespace reamsim {

/// Density grades of a lattice, 8 bits a voxel, 0 = air. Only bricks (8×8×8 voxels) that hold bone are stored: a brick
/// of bone takes 512 bytes, a brick of air 4, so that an almost empty lattice costs little to keep and to go through.
class GradeBricks {
 public:
  static constexpr int kSide = BrickLattice::kSide;
  static constexpr int kVoxels = BrickLattice::kVoxels;
  using Brick = std::array<std::uint8_t, kVoxels>;

  GradeBricks() = default;
  /// All air, over a lattice of `dims` voxels.
  explicit GradeBricks(const Vec3i& dims);

  /// Both take a voxel of the lattice only.
  [[nodiscard]] std::uint8_t get(const Vec3i& voxel) const {
    const Brick* stored = brick(BrickLattice::brick_of(voxel));
    return stored == nullptr ? 0 : (*stored)[static_cast<std::size_t>(BrickLattice::offset_of(voxel))];
  }
  void set(const Vec3i& voxel, std::uint8_t grade);
  /// A whole brick at once. Voxels that stick out of the lattice must be air.
  void put(const Vec3i& brick_coord, const Brick& brick);

  /// Number of bricks along each axis: ceil(dims/8).
  [[nodiscard]] Vec3i brick_dims() const { return lattice_.dims; }
  [[nodiscard]] std::size_t stored_bricks() const { return used_ - free_.size(); }
  /// The stored brick at brick coordinates, voxel (x,y,z) of it at x + 8·(y + 8·z), or nullptr when it is all air.
  [[nodiscard]] const Brick* brick(const Vec3i& brick_coord) const {
    const std::int32_t slot = slot_of_brick_[lattice_.index(brick_coord)];
    return slot < 0 ? nullptr : &stored(slot);
  }

  /// Calls visit(brick coordinates, brick) for every stored brick, in the lattice's order.
  template <class Visit>
  void for_each_brick(const Visit& visit) const {
    for (std::size_t i = 0; i < slot_of_brick_.size(); ++i) {
      if (slot_of_brick_[i] >= 0) visit(lattice_.coord(i), stored(slot_of_brick_[i]));
    }
  }
  /// Coordinates of the stored bricks, in the lattice's order.
  [[nodiscard]] std::vector<Vec3i> stored_coords() const;
  /// Coordinates of the bricks that are stored or touch a stored one, by a corner at least, in the order of z, y, x.
  /// They reach one brick beyond the lattice.
  [[nodiscard]] std::vector<Vec3i> coords_around() const;
  /// Voxels with bone.
  [[nodiscard]] std::int64_t count() const;
  /// Memory of the bricks and their table.
  [[nodiscard]] std::size_t bytes() const;

  /// The same lattice of bricks and the same grades.
  bool operator==(const GradeBricks& other) const;

 private:
  /// Bricks live in pages, so that a growing bone is never copied.
  static constexpr std::size_t kPageBits = 12;
  static constexpr std::size_t kPageBricks = std::size_t{1} << kPageBits;

  [[nodiscard]] const Brick& stored(std::int32_t slot) const {
    const auto at = static_cast<std::size_t>(slot);
    return pages_[at >> kPageBits][at & (kPageBricks - 1)];
  }
  Brick& stored(std::int32_t slot) { return const_cast<Brick&>(std::as_const(*this).stored(slot)); }
  std::int32_t take_slot();

  BrickLattice lattice_;
  std::vector<std::int32_t> slot_of_brick_;  // -1 = air
  std::vector<std::vector<Brick>> pages_;
  std::size_t used_ = 0;            // slots that were ever taken
  std::vector<std::int32_t> free_;  // of these, the ones whose brick became air
};

}  // namespace reamsim
