// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <vector>

#include "render/surface/bone_surface.h"

namespace reamsim {

/// The bone's surface in tiles of the lattice, so that only tiles near changed bone are meshed again. Together they are
/// the surface of make_bone_surface(): neighbouring tiles mesh what crosses their border alike.
class BoneTiles {
 public:
  static constexpr int kSideBricks = 4;

  explicit BoneTiles(const BoneFields& fields);

  /// Updates the tiles after `bricks` of the fields have changed. Returns the changed tiles in ascending order.
  std::vector<std::size_t> update(const BoneFields& fields, const std::vector<Vec3i>& bricks);

  /// One per tile; most are empty.
  [[nodiscard]] const std::vector<BoneSurface>& surfaces() const { return surfaces_; }
  /// Of the reamed vertices, mm; 0 when nothing is reamed.
  [[nodiscard]] double deepest_mm() const;

 private:
  /// Marks tiles at most `reach` bricks from any of `bricks`.
  [[nodiscard]] std::vector<bool> tiles_within(const std::vector<Vec3i>& bricks, int reach) const;
  [[nodiscard]] BoneSurface mesh(const BoneFields& fields, std::size_t tile) const;

  BrickLattice tiles_;  ///< the first tile begins one brick below the lattice, as the surface may
  std::vector<BoneSurface> surfaces_;
};

}  // namespace reamsim
