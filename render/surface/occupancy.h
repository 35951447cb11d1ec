#pragma once

#include <cstdint>
#include <vector>

#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// The bone fraction of each voxel, 0…1, read brick by brick (8×8×8 voxels): bricks that are all air or all bone are
/// known as such.
class Occupancy {
 public:
  enum class Kind : std::uint8_t { kEmpty, kFull, kMixed };

  /// Both must outlive this.
  Occupancy(const Voxmap& voxmap, const FillBricks& fill);

  /// Classifies bricks again whose fill has changed.
  void update(const std::vector<Vec3i>& bricks);

  [[nodiscard]] const Voxmap& voxmap() const { return voxmap_; }
  [[nodiscard]] Vec3i brick_dims() const { return bricks_.dims; }
  /// Outside the lattice everything is air.
  [[nodiscard]] Kind kind(const Vec3i& brick) const;
  /// Copies the fractions of a box of side³ voxels from `lower` on, x fastest, to `out`.
  void gather(const Vec3i& lower, int side, float* out) const;

 private:
  [[nodiscard]] Kind classify(const Vec3i& brick) const;

  const Voxmap& voxmap_;
  const FillBricks& fill_;
  BrickLattice bricks_;
  std::vector<Kind> kinds_;
};

}  // namespace reamsim
