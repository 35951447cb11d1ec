// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "render/surface/bone_surface.h"
#include "sim/bone/voxmap/cube_fraction.h"
#include "sim/bone/voxmap/sample_voxels.h"

namespace reamsim::test {

/// A ball of radius 10 mm about the origin, whole voxels by their centres.
inline FilledVoxmap ball(double voxel_mm = 0.5) {
  VoxelGrid grid;
  grid.voxel_mm = voxel_mm;
  grid.dims = (Vec3(46, 45, 47) * (0.5 / voxel_mm)).cast<int>();  // no multiples of a brick
  grid.origin_mm = Vec3(-11.5, -11.2, -11.7);
  FilledVoxmap voxmap(grid);
  for (int k = 0; k < grid.dims.z(); ++k) {
    for (int j = 0; j < grid.dims.y(); ++j) {
      for (int i = 0; i < grid.dims.x(); ++i) {
        if (grid.center_mm({i, j, k}).norm() < 10) voxmap.grade.set({i, j, k}, 150);
      }
    }
  }
  return voxmap;
}

/// Takes away what lies above z = `height`, by fractions.
inline void plane_off(const VoxelGrid& grid, double height_mm, FillBricks& fill) {
  for (int k = 0; k < grid.dims.z(); ++k) {
    const double left = std::clamp((height_mm - grid.center_mm({0, 0, k}).z()) / grid.voxel_mm + 0.5, 0.0, 1.0);
    for (int j = 0; j < grid.dims.y(); ++j) {
      for (int i = 0; i < grid.dims.x(); ++i) {
        fill.set({i, j, k}, static_cast<std::uint16_t>(std::lround(left * FillBricks::kWhole)));
      }
    }
  }
}

struct Vertex {
  Vec3 position_mm;
  Vec3 normal;
  double depth_mm, reamed, density, open;
};

inline std::vector<Vertex> vertices(const BoneSurface& surface) {
  std::vector<Vertex> out;
  for (std::size_t i = 0; i < surface.vertices.size(); i += BoneSurface::kStride) {
    const float* v = surface.vertices.data() + i;
    out.push_back({{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, v[6], v[7], v[8], v[9]});
  }
  return out;
}

/// Of a bone that began with the fill `before`.
inline BoneSurface surface_of(const FilledVoxmap& voxmap, const FillBricks& before) {
  const UnreamedSurface unreamed(voxmap, before, voxmap.fill);
  return BoneTiles(BoneFields(voxmap, voxmap.fill, unreamed)).whole();
}

/// Of a bone that began whole.
inline BoneSurface surface_of(const FilledVoxmap& voxmap) {
  return surface_of(voxmap, FillBricks(voxmap.grid.dims));
}

/// The ball with partial voxels at its surface.
inline FilledVoxmap smooth_ball(double voxel_mm = 0.5) {
  FilledVoxmap voxmap = ball(voxel_mm);
  const auto distance = [](const Vec3& point) { return point.norm() - 10; };
  const auto sample = [&](const Vec3i& voxel, std::uint8_t) -> SurfaceVoxel {
    const Vec3 center = voxmap.grid.center_mm(voxel);
    return {fraction_inside(distance, center, voxmap.grid.voxel_mm), 150};
  };
  set_partial_fill(sample, voxmap);
  return voxmap;
}

}  // namespace reamsim::test
