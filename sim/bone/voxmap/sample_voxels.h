// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <array>
#include <functional>
#include <limits>

#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// Sets voxels of one brick, all air before. Called from several threads at once.
using BrickSampler = std::function<void(const Vec3i& brick_coord, GradeBricks::Brick& brick)>;

/// The grades of a lattice of `dims` voxels, sampled brick by brick. The result does not depend on the threads.
GradeBricks sample_bricks(const Vec3i& dims, const BrickSampler& sample);

/// A number for each voxel of a brick and of a layer of one voxel around it; 0 where there is no brick.
template <class T>
class PaddedBrick {
 public:
  /// value(grades, fill or nullptr, offset): of a voxel of a stored brick. `fill`: may be a null pointer.
  template <class Value>
  PaddedBrick(const GradeBricks& bricks, const FillBricks* fill, const Vec3i& brick, const Value& value) {
    constexpr int kSide = BrickLattice::kSide;
    for_each_voxel(Vec3i::Constant(-1), Vec3i::Ones(), [&](const Vec3i& step) {
      const Vec3i coord = brick + step;
      const auto* grades = bricks.lattice().contains(coord) ? bricks.brick(coord) : nullptr;
      if (grades == nullptr) {
        least_ = 0;
        return;
      }
      const auto* fills = fill == nullptr ? nullptr : fill->brick(coord);
      const Vec3i low = step.unaryExpr([](int s) { return s < 0 ? kSide - 1 : 0; });
      const Vec3i high = step.unaryExpr([](int s) { return s > 0 ? 0 : kSide - 1; });
      for_each_voxel(low, high, [&](const Vec3i& voxel) {
        const T found = value(*grades, fills, static_cast<std::size_t>(BrickLattice::offset_of(voxel)));
        values_[place(voxel + kSide * step)] = found;
        least_ = std::min(least_, found);
        most_ = std::max(most_, found);
      });
    });
  }

  static constexpr int kPaddedSide = BrickLattice::kSide + 2;
  using Values = std::array<T, std::size_t{kPaddedSide} * kPaddedSide * kPaddedSide>;

  /// The index of a voxel, −1…8 along each axis.
  static std::size_t place(const Vec3i& v) {
    return static_cast<std::size_t>(v.x() + 1 + kPaddedSide * (v.y() + 1 + kPaddedSide * (v.z() + 1)));
  }
  [[nodiscard]] const Values& values() const { return values_; }
  [[nodiscard]] T least() const { return least_; }
  [[nodiscard]] T most() const { return most_; }

 private:
  Values values_{};
  T least_ = std::numeric_limits<T>::max();
  T most_ = 0;
};

/// A voxel at the surface of a bone, as the source of the bone describes it.
struct SurfaceVoxel {
  double fraction = 0;     ///< of its volume that is bone, 0…1
  std::uint8_t grade = 0;  ///< of that bone; not 0 where there is any
};

/// Describes a voxel whose grade is `grade`, 0 where its centre lies outside. Called from several threads at once.
using SurfaceSampler = std::function<SurfaceVoxel(const Vec3i& voxel, std::uint8_t grade)>;

/// Sets the fill of the voxels whose 3×3×3 neighbourhood contains bone and air; all must be whole. A voxel whose centre
/// lies just outside becomes bone with a small fill (docs/density.md, 1). Does not depend on the threads.
void set_partial_fill(const SurfaceSampler& sample, FilledVoxmap& voxmap);

}  // namespace reamsim
