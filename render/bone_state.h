#pragma once

#include <optional>
#include <vector>

#include "render/ambient.h"
#include "render/bone_tiles.h"
#include "render/occupancy.h"
#include "render/solid_field.h"

namespace reamsim {

/// What changes from picture to picture: the bone's fill and everything that is derived from it.
class BoneState {
 public:
  /// Both outlive this.
  BoneState(Voxmap& voxmap, const UnreamedSurface& unreamed);

  /// Follows the voxmap's fill. Returns the tiles whose surfaces are others now.
  std::vector<std::size_t> follow();
  /// Puts the bone back to before the first snapshot; seen at the next follow().
  void rewind();

  [[nodiscard]] const BoneTiles& tiles() const { return tiles_; }
  [[nodiscard]] const SolidField& field() const { return field_; }

 private:
  [[nodiscard]] BoneLook look() const { return {voxmap_, field_, ambient_, unreamed_}; }

  Voxmap& voxmap_;
  const UnreamedSurface& unreamed_;
  Occupancy occupancy_;
  SolidField field_;
  AmbientLight ambient_;
  BoneTiles tiles_;
  std::optional<FillBricks> rewound_from_;  ///< what the surfaces still show after rewind()
};

}  // namespace reamsim
