// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/bone/vdb/surface_grid.h"

#include <algorithm>
#include <memory>

#include "sim/base/parallel.h"
#include "sim/bone/vdb/grids.h"
#include "sim/bone/vdb/narrow_band.h"

namespace reamsim {

namespace {

using Leaf = openvdb::FloatTree::LeafNodeType;
static_assert(Leaf::DIM == FillBricks::kSide);

constexpr int kPadded = FillBricks::kSide + 2;

/// The occupancy (0…65535) of a brick and of a layer of one voxel around it.
class PaddedBrick {
 public:
  PaddedBrick(const BoneView& bone, const Vec3i& brick) {
    for_each_voxel(Vec3i::Constant(-1), Vec3i::Ones(),
                   [&](const Vec3i& step) { copy_from_neighbour(bone, brick, step); });
  }

  [[nodiscard]] bool empty() const { return empty_; }
  [[nodiscard]] bool whole() const { return whole_; }
  /// Weights 1-2-1 along each axis; their sum is 64.
  [[nodiscard]] float smoothed(int x, int y, int z) const {
    int sum = 0;
    for (int dz = 0; dz < 3; ++dz) {
      for (int dy = 0; dy < 3; ++dy) {
        const int row = at(x, y + dy, z + dz) + 2 * at(x + 1, y + dy, z + dz) + at(x + 2, y + dy, z + dz);
        sum += (dy == 1 ? 2 : 1) * (dz == 1 ? 2 : 1) * row;
      }
    }
    return static_cast<float>(sum) / (64.0F * FillBricks::kWhole);
  }

 private:
  /// Copies a face, an edge or a corner of the neighbour `step` bricks away, or the brick itself.
  void copy_from_neighbour(const BoneView& bone, const Vec3i& brick, const Vec3i& step) {
    const Vec3i first = step.unaryExpr([](int s) { return s < 0 ? -1 : s * FillBricks::kSide; });
    const Vec3i last = step.unaryExpr([](int s) { return s < 0 ? -1 : FillBricks::kSide + s - 1; });
    const Vec3i coord = brick + step;
    const bool inside = BrickLattice{bone.voxmap.grade.brick_dims()}.contains(coord);
    const GradeBricks::Brick* grades = inside ? bone.voxmap.grade.brick(coord) : nullptr;
    whole_ = whole_ && grades != nullptr;
    if (grades == nullptr) return;
    const FillBricks::Brick* fill = bone.fill.brick(coord);
    for_each_voxel(first, last, [&](const Vec3i& v) {
      const auto offset = static_cast<std::size_t>(BrickLattice::offset_of(v));
      const int remaining = fill == nullptr ? FillBricks::kWhole : (*fill)[offset];
      const int value = (*grades)[offset] == 0 ? 0 : remaining;
      at(v.x() + 1, v.y() + 1, v.z() + 1) = value;
      empty_ = empty_ && value == 0;
      whole_ = whole_ && value == FillBricks::kWhole;
    });
  }
  [[nodiscard]] const int& at(int x, int y, int z) const {
    return values_[static_cast<std::size_t>(x + kPadded * (y + kPadded * z))];
  }
  int& at(int x, int y, int z) { return values_[static_cast<std::size_t>(x + kPadded * (y + kPadded * z))]; }

  std::array<int, std::size_t{kPadded} * kPadded * kPadded> values_{};
  bool empty_ = true;
  bool whole_ = true;
};

openvdb::Coord leaf_corner(const Vec3i& brick) {
  return {FillBricks::kSide * brick.x(), FillBricks::kSide * brick.y(), FillBricks::kSide * brick.z()};
}

/// The smoothed occupancy of one brick: a leaf, or a constant 0 or 1. No surface lies between a constant brick and its
/// neighbours: at their common face the smoothed occupancy differs by less than a half from the constant.
struct SmoothedBrick {
  float all = 0;
  std::unique_ptr<Leaf> leaf;
};

SmoothedBrick smoothed_brick(const BoneView& bone, const Vec3i& brick) {
  const PaddedBrick padded(bone, brick);
  if (padded.empty()) return {};
  if (padded.whole()) return {1.0F, nullptr};
  auto leaf = std::make_unique<Leaf>(leaf_corner(brick), 0.0F, true);
  for_each_voxel(Vec3i::Constant(FillBricks::kSide), [&](const Vec3i& v) {
    leaf->setValueOnly(Leaf::coordToOffset({v.x(), v.y(), v.z()}), padded.smoothed(v.x(), v.y(), v.z()));
  });
  return {0, std::move(leaf)};
}

openvdb::FloatGrid::Ptr smoothed_occupancy(const BoneView& bone) {
  constexpr std::size_t kAtOnce = 1 << 16;
  const std::vector<Vec3i> bricks = bricks_near_bone(bone.voxmap.grade);
  auto grid = make_float_grid(0.0F);
  grid->setTransform(index_transform(bone.voxmap.grid));
  std::vector<SmoothedBrick> smoothed(std::min(kAtOnce, bricks.size()));
  for (std::size_t first = 0; first < bricks.size(); first += kAtOnce) {
    const std::size_t count = std::min(kAtOnce, bricks.size() - first);
    parallel_items(count, [&](std::size_t i) { smoothed[i] = smoothed_brick(bone, bricks[first + i]); });
    for (std::size_t i = 0; i < count; ++i) {
      if (smoothed[i].leaf) {
        grid->tree().addLeaf(smoothed[i].leaf.release());
      } else if (smoothed[i].all != 0) {
        // Inactive: only the leaves are searched for the surface.
        grid->tree().addTile(1, leaf_corner(bricks[first + i]), smoothed[i].all, false);
      }
    }
  }
  return grid;
}

}  // namespace

openvdb::math::Transform::Ptr index_transform(const VoxelGrid& grid) {
  auto out = openvdb::math::Transform::createLinearTransform(grid.voxel_mm);
  const Vec3 first = grid.center_mm({0, 0, 0});
  out->postTranslate(openvdb::Vec3d(first.x(), first.y(), first.z()));
  return out;
}

openvdb::FloatGrid::Ptr surface_level_set(const BoneView& bone) {
  return narrow_band(*smoothed_occupancy(bone));
}

}  // namespace reamsim
