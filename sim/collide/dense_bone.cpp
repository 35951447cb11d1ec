#include "sim/collide/dense_bone.h"

#include <algorithm>

namespace reamsim {

std::vector<std::uint8_t> grades_left(const Voxmap& voxmap) {
  std::vector<std::uint8_t> out = voxmap.grade;
  if (voxmap.fill.stored_bricks() == 0) return out;
  for (std::int64_t e = 0; e < voxmap.grid.size(); ++e) {
    std::uint8_t& grade = out[static_cast<std::size_t>(e)];
    if (grade != 0 && voxmap.fill.get(voxmap.grid.coord(e)) == 0) grade = 0;
  }
  return out;
}

std::vector<std::uint16_t> dense_fill(const Voxmap& voxmap) {
  std::vector<std::uint16_t> out(static_cast<std::size_t>(voxmap.grid.size()), FillBricks::kWhole);
  if (voxmap.fill.stored_bricks() == 0) return out;
  for (std::int64_t e = 0; e < voxmap.grid.size(); ++e) {
    out[static_cast<std::size_t>(e)] = voxmap.fill.get(voxmap.grid.coord(e));
  }
  return out;
}

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
  return voxmap.grade.size() - static_cast<std::size_t>(std::count(voxmap.grade.begin(), voxmap.grade.end(), 0));
}

void copy_fill(const std::vector<std::uint16_t>& dense, Voxmap& voxmap) {
  for (std::size_t e = 0; e < dense.size(); ++e) {
    if (dense[e] == FillBricks::kWhole || voxmap.grade[e] == 0) continue;
    const Vec3i voxel = voxmap.grid.coord(static_cast<std::int64_t>(e));
    if (voxmap.fill.get(voxel) != dense[e]) voxmap.fill.set(voxel, dense[e]);
  }
}

}  // namespace reamsim
