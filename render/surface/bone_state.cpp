#include "render/surface/bone_state.h"

#include <utility>

namespace reamsim {

BoneState::BoneState(const Voxmap& voxmap, FillBricks fill, const UnreamedSurface& unreamed)
    : voxmap_(voxmap),
      fill_(std::move(fill)),
      unreamed_(unreamed),
      occupancy_(voxmap, fill_),
      field_(occupancy_),
      ambient_(occupancy_),
      tiles_(look()) {
  fill_.take_changed();
}

std::vector<std::size_t> BoneState::follow() {
  const std::vector<Vec3i> bricks = fill_.take_changed();
  occupancy_.update(bricks);
  field_.update(occupancy_, bricks);
  ambient_.update(occupancy_, bricks);
  return tiles_.update(look(), bricks);
}

}  // namespace reamsim
