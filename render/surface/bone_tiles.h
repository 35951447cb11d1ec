#pragma once

#include <cstddef>
#include <vector>

#include "render/surface/bone_surface.h"

namespace reamsim {

/// The bone's surface in tiles of the lattice, so that only those near bone that has changed are meshed again. Together
/// they are the surface that make_bone_surface() makes: what reaches over a tile's border is meshed by both neighbours
/// alike.
class BoneTiles {
 public:
  static constexpr int kSideBricks = 4;

  explicit BoneTiles(const BoneFields& fields);

  /// Follows fields of the same lattice in which `bricks` have changed. Returns the tiles whose surfaces have changed,
  /// in ascending order.
  std::vector<std::size_t> update(const BoneFields& fields, const std::vector<Vec3i>& bricks);

  /// One per tile; most are empty.
  [[nodiscard]] const std::vector<BoneSurface>& surfaces() const { return surfaces_; }
  /// Of the reamed vertices, mm; 0 when nothing is reamed.
  [[nodiscard]] double deepest_mm() const;

 private:
  [[nodiscard]] Vec3i coord_of(std::size_t tile) const;
  /// Tiles that are no more than `reach` bricks away from any of `bricks`.
  [[nodiscard]] std::vector<bool> tiles_within(const std::vector<Vec3i>& bricks, int reach) const;
  [[nodiscard]] BoneSurface mesh(const BoneFields& fields, std::size_t tile) const;

  Vec3i tiles_;  ///< along each axis; the first begins one brick below the lattice, because the surface may
  std::vector<BoneSurface> surfaces_;
};

}  // namespace reamsim
