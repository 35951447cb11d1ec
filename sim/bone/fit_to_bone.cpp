#include <algorithm>

#include "sim/base/error.h"
#include "sim/bone/bone.h"
#include "sim/bone/lattice.h"

namespace reamsim {

namespace {

/// First and last voxel with bone along each axis; first > last where there is none.
struct BoneExtent {
  Vec3i first;
  Vec3i last;
};

BoneExtent bone_extent(const Voxmap& voxmap) {
  const VoxelGrid& grid = voxmap.grid;
  BoneExtent out{grid.dims, Vec3i::Constant(-1)};
  for (int z = 0; z < grid.dims.z(); ++z) {
    for (int y = 0; y < grid.dims.y(); ++y) {
      const auto row = voxmap.grade.begin() + grid.index(0, y, z);
      const auto end = row + grid.dims.x();
      const auto begin = std::find_if(row, end, [](std::uint8_t grade) { return grade != 0; });
      if (begin == end) continue;
      auto back = end - 1;
      while (*back == 0) --back;
      out.first = out.first.cwiseMin(Vec3i(static_cast<int>(begin - row), y, z));
      out.last = out.last.cwiseMax(Vec3i(static_cast<int>(back - row), y, z));
    }
  }
  return out;
}

}  // namespace

Voxmap fit_to_bone(const Voxmap& voxmap, int margin_voxels) {
  const BoneExtent extent = bone_extent(voxmap);
  if ((extent.first.array() > extent.last.array()).any()) {
    throw InputError({}, "bone", "no bone in the volume", "expected at least one voxel of bone");
  }
  const Vec3i shift = extent.first - Vec3i::Constant(margin_voxels);
  const Vec3i needed = extent.last - extent.first + Vec3i::Constant(1 + 2 * margin_voxels);
  const Vec3i dims = (needed.array() + (FillBricks::kSide - 1)) / FillBricks::kSide * FillBricks::kSide;
  check_lattice("bone", dims.cast<double>().array(), voxmap.grid.voxel_mm);

  const VoxelGrid& from = voxmap.grid;
  Voxmap out(VoxelGrid{dims, from.voxel_mm, from.origin_mm + from.voxel_mm * shift.cast<double>()});
  out.mapping = voxmap.mapping;
  out.frame = voxmap.frame;
  for (int z = extent.first.z(); z <= extent.last.z(); ++z) {
    for (int y = extent.first.y(); y <= extent.last.y(); ++y) {
      const auto row = voxmap.grade.begin() + from.index(extent.first.x(), y, z);
      std::copy(row, row + (extent.last.x() - extent.first.x() + 1),
                out.grade.begin() + out.grid.index(margin_voxels, y - shift.y(), z - shift.z()));
      for (int x = extent.first.x(); x <= extent.last.x(); ++x) {
        const std::uint16_t fill = voxmap.fill.get({x, y, z});
        if (fill != FillBricks::kWhole) out.fill.set(Vec3i(x, y, z) - shift, fill);
      }
    }
  }
  return out;
}

}  // namespace reamsim
