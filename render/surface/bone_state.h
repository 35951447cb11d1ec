#pragma once

#include <vector>

#include "render/surface/ambient.h"
#include "render/surface/bone_tiles.h"
#include "render/surface/occupancy.h"
#include "render/surface/solid_field.h"

namespace reamsim {

/// What changes from picture to picture: the bone's fill and everything that is derived from it.
class BoneState {
 public:
  /// Of `voxmap` the lattice and the grades count. Both outlive this.
  BoneState(const Voxmap& voxmap, FillBricks fill, const UnreamedSurface& unreamed);
  BoneState(const BoneState&) = delete;
  BoneState& operator=(const BoneState&) = delete;

  /// What is left of the bone. After changes, follow().
  [[nodiscard]] FillBricks& fill() { return fill_; }
  /// Follows the fill. Returns the tiles whose surfaces are others now.
  std::vector<std::size_t> follow();

  [[nodiscard]] const BoneTiles& tiles() const { return tiles_; }
  [[nodiscard]] const SolidField& field() const { return field_; }

 private:
  [[nodiscard]] BoneLook look() const { return {voxmap_, field_, ambient_, unreamed_}; }

  const Voxmap& voxmap_;
  FillBricks fill_;
  const UnreamedSurface& unreamed_;
  Occupancy occupancy_;
  SolidField field_;
  AmbientLight ambient_;
  BoneTiles tiles_;
};

}  // namespace reamsim
