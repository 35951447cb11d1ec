#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/bone/voxmap/brick_lattice.h"

namespace reamsim {

/// How much of each voxel is still bone: 16 bits, 65535 = whole, 0 = gone. Only bricks (8×8×8 voxels) that are not
/// whole are stored. Fill means nothing where the grade is 0 (air).
class FillBricks {
 public:
  static constexpr int kSide = BrickLattice::kSide;
  static constexpr int kVoxels = BrickLattice::kVoxels;
  static constexpr std::uint16_t kWhole = 65535;
  using Brick = std::array<std::uint16_t, kVoxels>;

  FillBricks() = default;
  /// All whole, over a lattice of `dims` voxels.
  explicit FillBricks(const Vec3i& dims);

  [[nodiscard]] std::uint16_t get(const Vec3i& voxel) const;
  void set(const Vec3i& voxel, std::uint16_t fill);
  /// A whole brick at once.
  void put(const Vec3i& brick_coord, const Brick& brick);

  /// Makes room for that many bricks more, so that they are not copied while they come.
  void reserve(std::size_t bricks);

  /// Number of bricks along each axis: ceil(dims/8).
  [[nodiscard]] Vec3i brick_dims() const { return lattice_.dims; }
  [[nodiscard]] std::size_t stored_bricks() const { return bricks_.size(); }
  /// The stored brick at brick coordinates, or nullptr when it is whole.
  [[nodiscard]] const Brick* brick(const Vec3i& brick_coord) const;
  /// Voxel (x,y,z) of a brick stands at x + 8·(y + 8·z).
  [[nodiscard]] static int offset_in_brick(const Vec3i& voxel) { return BrickLattice::offset_of(voxel); }
  /// Calls visit(brick coordinates, brick) for every stored brick, in the lattice's order.
  template <class Visit>
  void for_each_brick(const Visit& visit) const {
    if (bricks_.empty()) return;
    for (std::size_t i = 0; i < slot_of_brick_.size(); ++i) {
      const std::int32_t slot = slot_of_brick_[i];
      if (slot >= 0) visit(lattice_.coord(i), bricks_[static_cast<std::size_t>(slot)]);
    }
  }

  /// Brick coordinates changed by set() since the last call, in ascending storage order of the lattice.
  std::vector<Vec3i> take_changed();
  /// Memory of the bricks and their tables.
  [[nodiscard]] std::size_t bytes() const;

 private:
  /// The slot of a brick, a new one of whole voxels where there was none.
  std::size_t take_slot(std::size_t index);
  void note_change(std::size_t index);

  BrickLattice lattice_;
  std::vector<std::int32_t> slot_of_brick_;  // -1 = whole
  std::vector<Brick> bricks_;
  std::vector<std::uint8_t> is_changed_;  // of the stored bricks, by slot
  std::vector<std::size_t> changed_;      // their places in the lattice
};

}  // namespace reamsim
