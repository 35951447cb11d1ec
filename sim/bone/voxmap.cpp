#include "sim/bone/voxmap.h"

namespace reamsim {

std::int64_t Voxmap::count_bone() const {
  std::int64_t count = 0;
  std::size_t index = 0;
  for (int z = 0; z < grid.dims.z(); ++z) {
    for (int y = 0; y < grid.dims.y(); ++y) {
      for (int x = 0; x < grid.dims.x(); ++x, ++index) {
        if (grade[index] != 0 && fill.get({x, y, z}) != 0) ++count;
      }
    }
  }
  return count;
}

double Voxmap::bone_mm3() const {
  std::int64_t sum = 0;  // in 1/65535 of a voxel, so that the order of summing does not matter
  std::size_t index = 0;
  for (int z = 0; z < grid.dims.z(); ++z) {
    for (int y = 0; y < grid.dims.y(); ++y) {
      for (int x = 0; x < grid.dims.x(); ++x, ++index) {
        if (grade[index] != 0) sum += fill.get({x, y, z});
      }
    }
  }
  return static_cast<double>(sum) / FillBricks::kWhole * grid.voxel_mm3();
}

}  // namespace reamsim
