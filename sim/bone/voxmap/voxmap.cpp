// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/voxmap/voxmap.h"

#include <algorithm>

namespace reamsim {

namespace {

/// Sum of `value(fill)` over the voxels with grade ≠ 0.
template <class Value>
std::int64_t sum_over_bone(const BoneView& bone, const Value& value) {
  std::int64_t sum = 0;
  bone.voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick& grades) {
    const FillBricks::Brick* fill = bone.fill.brick(coord);
    if (fill == nullptr) {
      sum += value(FillBricks::kWhole) * (GradeBricks::kVoxels - std::ranges::count(grades, 0));
      return;
    }
    for (std::size_t i = 0; i < grades.size(); ++i) sum += grades[i] != 0 ? value((*fill)[i]) : 0;
  });
  return sum;
}

}  // namespace

std::int64_t BoneView::count_bone() const {
  return sum_over_bone(*this, [](std::uint16_t value) { return std::int64_t{value != 0 ? 1 : 0}; });
}

double BoneView::bone_mm3() const {
  // In 1/65535 of a voxel: integers, so that the order of summation does not matter.
  const std::int64_t sum = sum_over_bone(*this, [](std::uint16_t value) { return std::int64_t{value}; });
  return static_cast<double>(sum) / FillBricks::kWhole * voxmap.grid.voxel_mm3();
}

VoxelBox bone_extent(const Voxmap& voxmap) {
  VoxelBox out{voxmap.grid.dims, Vec3i::Constant(-1)};
  voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick& grades) {
    const Vec3i first = GradeBricks::kSide * coord;
    if (out.contains(first) && out.contains(first + Vec3i::Constant(GradeBricks::kSide - 1))) return;
    for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
      if (grades[static_cast<std::size_t>(offset)] == 0) continue;
      const Vec3i voxel = BrickLattice::voxel_at(coord, offset);
      out.first = out.first.cwiseMin(voxel);
      out.last = out.last.cwiseMax(voxel);
    }
  });
  return out;
}

std::vector<Vec3i> bricks_near_bone(const GradeBricks& grades) {
  const BrickLattice wider{grades.brick_dims() + Vec3i::Constant(2)};
  std::vector<bool> near(wider.count(), false);
  grades.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick&) {
    for (int z = 0; z < 3; ++z) {
      for (int y = 0; y < 3; ++y) {
        const std::size_t row = wider.index(coord + Vec3i(0, y, z));
        for (std::size_t x = 0; x < 3; ++x) near[row + x] = true;
      }
    }
  });
  std::vector<Vec3i> out;
  for (std::size_t i = 0; i < near.size(); ++i) {
    if (near[i]) out.emplace_back(wider.coord(i) - Vec3i::Ones());
  }
  return out;
}

bool partly_filled(const FillBricks& fill) {
  bool part = false;
  fill.for_each_brick([&part](const Vec3i&, const FillBricks::Brick& brick) {
    part = part || std::any_of(brick.begin(), brick.end(),
                               [](std::uint16_t value) { return value != 0 && value != FillBricks::kWhole; });
  });
  return part;
}

std::vector<std::uint8_t> dense_remaining_grades(const BoneView& bone) {
  std::vector<std::uint8_t> out(static_cast<std::size_t>(bone.voxmap.grid.size()), 0);
  for_each_bone_voxel(bone, [&](const Vec3i& voxel, std::uint8_t grade, std::uint16_t fill) {
    if (fill != 0) out[static_cast<std::size_t>(bone.voxmap.grid.index(voxel))] = grade;
  });
  return out;
}

std::vector<std::uint16_t> dense_fill(const BoneView& bone) {
  std::vector<std::uint16_t> out(static_cast<std::size_t>(bone.voxmap.grid.size()), FillBricks::kWhole);
  bone.fill.for_each_brick([&](const Vec3i& coord, const FillBricks::Brick& fill) {
    for (int offset = 0; offset < FillBricks::kVoxels; ++offset) {
      const Vec3i voxel = BrickLattice::voxel_at(coord, offset);
      if (!bone.voxmap.grid.contains(voxel)) continue;
      out[static_cast<std::size_t>(bone.voxmap.grid.index(voxel))] = fill[static_cast<std::size_t>(offset)];
    }
  });
  return out;
}

}  // namespace reamsim
