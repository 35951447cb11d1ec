// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/read_back.h"

#include <bit>

namespace reamsim {

void copy_fill(const std::vector<std::uint16_t>& dense, const Voxmap& voxmap, FillBricks& fill) {
  voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick& grades) {
    for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
      if (grades[static_cast<std::size_t>(offset)] == 0) continue;
      const Vec3i voxel = BrickLattice::voxel_at(coord, offset);
      const auto remaining = dense[static_cast<std::size_t>(voxmap.grid.index(voxel))];
      if (remaining != FillBricks::kWhole) fill.set(voxel, remaining);
    }
  });
}

void append_removed(const RemovedBlock& block, const VoxelGrid& grid, std::int32_t frame, RemovedFrames& removed) {
  const Vec3i brick = BrickLattice::over(grid.dims).coord(block.brick);
  const auto first = static_cast<rs_i32>((block.detail & 7U) << 6);
  const Vec3i corner = RS_BRICK_SIDE * brick + Vec3i(rs_offset_x(first), rs_offset_y(first), rs_offset_z(first));
  const std::int64_t base = grid.index(corner);
  const std::int64_t row_step = grid.dims.x(), layer_step = row_step * grid.dims.y();
  for (rs_u64 rest = block.removed; rest != 0; rest &= rest - 1) {
    const int bit = std::countr_zero(rest);
    removed.emplace_back(base + (bit & 3) + row_step * (bit >> 2 & 3) + layer_step * (bit >> 4), frame);
  }
}

}  // namespace reamsim
