#include "render/bone_state.h"

#include <algorithm>
#include <utility>

namespace reamsim {
namespace {

/// Is a brick that the other fill has no page for different from it?
bool is_cut(const FillBricks::Brick& brick) {
  return std::any_of(brick.begin(), brick.end(), [](std::uint16_t fill) { return fill != FillBricks::kWhole; });
}

/// Bricks whose fill is not the same in both.
std::vector<Vec3i> differing(const FillBricks& a, const FillBricks& b) {
  std::vector<Vec3i> out;
  a.for_each_brick([&](const Vec3i& coord, const FillBricks::Brick& brick) {
    const FillBricks::Brick* other = b.brick(coord);
    if (other == nullptr ? is_cut(brick) : brick != *other) out.push_back(coord);
  });
  b.for_each_brick([&](const Vec3i& coord, const FillBricks::Brick& brick) {
    if (a.brick(coord) == nullptr && is_cut(brick)) out.push_back(coord);
  });
  return out;
}

}  // namespace

BoneState::BoneState(Voxmap& voxmap, const UnreamedSurface& unreamed)
    : voxmap_(voxmap),
      unreamed_(unreamed),
      occupancy_(voxmap, voxmap.fill),
      field_(occupancy_),
      ambient_(occupancy_),
      tiles_(look()) {
  voxmap_.fill.take_changed();
}

std::vector<std::size_t> BoneState::follow() {
  std::vector<Vec3i> bricks = voxmap_.fill.take_changed();
  if (rewound_from_) bricks = differing(*rewound_from_, voxmap_.fill);
  rewound_from_.reset();
  occupancy_.update(bricks);
  field_.update(occupancy_, bricks);
  ambient_.update(occupancy_, bricks);
  return tiles_.update(look(), bricks);
}

void BoneState::rewind() {
  if (!rewound_from_) rewound_from_ = std::move(voxmap_.fill);
  voxmap_.fill = FillBricks(voxmap_.grid.dims);
}

}  // namespace reamsim
