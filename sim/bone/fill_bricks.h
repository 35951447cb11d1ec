#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "sim/bone/voxel_grid.h"

namespace reamsim {

/// How much of each voxel is still bone: 16 bits, 65535 = whole, 0 = gone. Only bricks (8×8×8 voxels) that are not
/// whole are stored. Fill means nothing where the grade is 0 (air).
class FillBricks {
 public:
  static constexpr int kSide = 8;
  static constexpr int kVoxels = kSide * kSide * kSide;
  static constexpr std::uint16_t kWhole = 65535;
  using Brick = std::array<std::uint16_t, kVoxels>;

  FillBricks() = default;
  /// All whole, over a lattice of `dims` voxels.
  explicit FillBricks(const Vec3i& dims);

  [[nodiscard]] std::uint16_t get(const Vec3i& voxel) const;
  void set(const Vec3i& voxel, std::uint16_t fill);

  /// Number of bricks along each axis: ceil(dims/8).
  [[nodiscard]] Vec3i brick_dims() const { return brick_dims_; }
  [[nodiscard]] std::size_t stored_bricks() const { return bricks_.size(); }
  /// The stored brick at brick coordinates, or nullptr when it is whole.
  [[nodiscard]] const Brick* brick(const Vec3i& brick_coord) const;
  /// Voxel (x,y,z) of a brick stands at x + 8·(y + 8·z).
  [[nodiscard]] static int offset_in_brick(const Vec3i& voxel) {
    return (voxel.x() & 7) + kSide * ((voxel.y() & 7) + kSide * (voxel.z() & 7));
  }

  /// Brick coordinates changed by set() since the last call, in ascending storage order of the lattice.
  std::vector<Vec3i> take_changed();

 private:
  [[nodiscard]] std::size_t brick_index(const Vec3i& brick_coord) const;

  Vec3i brick_dims_ = Vec3i::Zero();
  std::vector<std::int32_t> slot_of_brick_;  // -1 = whole
  std::vector<Brick> bricks_;
  std::vector<std::uint8_t> changed_;
};

}  // namespace reamsim
