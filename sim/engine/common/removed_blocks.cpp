#include "sim/engine/common/removed_blocks.h"

#include <bit>

#include "sim/bone/voxmap/brick_lattice.h"

namespace reamsim {

void append_removed(const RemovedBlock& block, const VoxelGrid& grid, std::int32_t frame, RemovedFrames& removed) {
  const Vec3i brick = BrickLattice::over(grid.dims).coord(block.brick);
  const auto first = static_cast<rs_i32>((block.detail & 7U) << 6);
  const Vec3i corner = RS_BRICK_SIDE * brick + Vec3i(rs_offset_x(first), rs_offset_y(first), rs_offset_z(first));
  const std::int64_t base = grid.index(corner);
  const std::int64_t row_step = grid.dims.x(), layer_step = row_step * grid.dims.y();
  for (rs_u64 rest = block.gone; rest != 0; rest &= rest - 1) {
    const int bit = std::countr_zero(rest);
    removed.emplace_back(base + (bit & 3) + row_step * (bit >> 2 & 3) + layer_step * (bit >> 4), frame);
  }
}

}  // namespace reamsim
