#include "sim/engine/common/teeth_table.h"

#include <algorithm>

namespace reamsim {

// Host and device lay the struct out alike, and agree on the bricks.
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
                         std::size_t taken_bytes) {
  const cl::DeviceInfo& info = device.info();
  const std::size_t left = info.global_memory_bytes - std::min(info.global_memory_bytes, taken_bytes);
  require_room_for_grid(static_cast<double>(grid.bytes()),
                        static_cast<double>(std::min(left, info.max_allocation_bytes)), voxel_mm, info.name);
  lattice_ = {device, 1, "the teeth's distance grid"};
  slots_ = {device, grid.slot_of_brick.size(), "the teeth's distance grid"};
  samples_ = {device, grid.samples.size(), "the teeth's distance grid"};
  DistanceLattice lattice = distance_lattice(grid);
  lattice.slack_mm += static_cast<float>(bulge_mm);
  lattice_.write(device, &lattice, 1);
  slots_.write(device, grid.slot_of_brick.data(), grid.slot_of_brick.size());
  samples_.write(device, grid.samples.data(), grid.samples.size());
}

}  // namespace reamsim
