#include "sim/collide/serial_reach.h"

#include "sim/collide/voxel_box.h"

namespace reamsim {

void SerialReach::detect(int slot) {
  const Stopwatch watch;
  const VoxelGrid& grid = state_.grid;
  // A voxel is met by a surface that passes less than its diagonal from its centre.
  const Aabb tool = state_.tool->profile.bounds().expanded(grid.voxel_mm + state_.outline.bulge_mm);
  const VoxelBox all{Vec3i::Zero(), grid.dims - Vec3i::Ones()};
  const VoxelBox box = voxel_voi(state_.args[static_cast<std::size_t>(slot)], tool, all);
  for (int z = box.first.z(); z <= box.last.z(); ++z) {
    for (int y = box.first.y(); y <= box.last.y(); ++y) {
      for (int x = box.first.x(); x <= box.last.x(); ++x) {
        const std::int64_t e = grid.index(x, y, z);
        if (state_.bone[static_cast<std::size_t>(e)] != 0) state_.contacts.push_back(e);
      }
    }
  }
  seconds_.push_back(watch.seconds());
}

}  // namespace reamsim
