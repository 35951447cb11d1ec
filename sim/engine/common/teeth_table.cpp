// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/teeth_table.h"

#include <algorithm>
#include <array>

namespace reamsim {

// The struct has the same layout on host and device.
static_assert(sizeof(DistanceLattice) == 44);
static_assert(DistanceGrid::kSide == RS_GRID_SIDE && DistanceGrid::kRow == RS_GRID_ROW);
static_assert(DistanceGrid::kSamples == RS_GRID_SAMPLES);

DistanceLattice distance_lattice(const DistanceGrid& grid) {
  DistanceLattice out{};
  for (int i = 0; i < 3; ++i) {
    out.origin[i] = static_cast<float>(grid.origin_mm[i]);
    out.last[i] = static_cast<float>(RS_GRID_SIDE * grid.bricks[i]) - 0.5F;
    out.bricks[i] = grid.bricks[i];
  }
  out.per_mm = static_cast<float>(1 / grid.spacing_mm);
  out.slack_mm = static_cast<float>(grid.slack_mm);
  return out;
}

DeviceTeeth::DeviceTeeth(const cl::Device& device, const DistanceGrid& grid, double voxel_mm, double bulge_mm,
                         std::size_t bone_bytes) {
  constexpr const char* kWhat = "the teeth's distance grid";
  const cl::DeviceInfo& info = device.info();
  const std::size_t free_bytes = info.global_memory_bytes - std::min(info.global_memory_bytes, bone_bytes);
  require_room_for_grid(static_cast<double>(grid.bytes()),
                        static_cast<double>(std::min(free_bytes, info.max_allocation_bytes)), voxel_mm, info.name);
  DistanceLattice lattice = distance_lattice(grid);
  lattice.slack_mm += static_cast<float>(bulge_mm);
  lattice_ = cl::upload(device, std::array{lattice}, kWhat);
  slots_ = cl::upload(device, grid.slot_of_brick, kWhat);
  samples_ = cl::upload(device, grid.samples, kWhat);
}

}  // namespace reamsim
