#include "sim/engine/common/dense_bone.h"

#include <algorithm>

namespace reamsim {

bool partly_filled(const Voxmap& voxmap) {
  const Vec3i bricks = voxmap.fill.brick_dims();
  const auto part = [](std::uint16_t fill) { return fill != 0 && fill != FillBricks::kWhole; };
  for (int z = 0; z < bricks.z(); ++z) {
    for (int y = 0; y < bricks.y(); ++y) {
      for (int x = 0; x < bricks.x(); ++x) {
        const FillBricks::Brick* brick = voxmap.fill.brick({x, y, z});
        if (brick != nullptr && std::any_of(brick->begin(), brick->end(), part)) return true;
      }
    }
  }
  return false;
}

std::size_t count_unreamed(const Voxmap& voxmap) {
  return static_cast<std::size_t>(voxmap.grade.count());
}

void copy_fill(const std::vector<std::uint16_t>& dense, Voxmap& voxmap) {
  voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick& grades) {
    for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
      if (grades[static_cast<std::size_t>(offset)] == 0) continue;
      const Vec3i voxel = BrickLattice::voxel_at(coord, offset);
      const auto left = dense[static_cast<std::size_t>(voxmap.grid.index(voxel.x(), voxel.y(), voxel.z()))];
      if (left != FillBricks::kWhole) voxmap.fill.set(voxel, left);
    }
  });
}

}  // namespace reamsim
