#include "sim/engine/common/dense_bone.h"

namespace reamsim {

void copy_fill(const std::vector<std::uint16_t>& dense, const Voxmap& voxmap, FillBricks& fill) {
  voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick& grades) {
    for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
      if (grades[static_cast<std::size_t>(offset)] == 0) continue;
      const Vec3i voxel = BrickLattice::voxel_at(coord, offset);
      const auto left = dense[static_cast<std::size_t>(voxmap.grid.index(voxel))];
      if (left != FillBricks::kWhole) fill.set(voxel, left);
    }
  });
}

}  // namespace reamsim
