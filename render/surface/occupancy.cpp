// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/surface/occupancy.h"

#include <algorithm>

#include "sim/base/parallel.h"

namespace reamsim {

Occupancy::Occupancy(const Voxmap& voxmap, const FillBricks& fill)
    : voxmap_(voxmap), fill_(fill), bricks_{voxmap.grade.brick_dims()}, kinds_(bricks_.count(), Kind::kEmpty) {
  const std::vector<Vec3i> stored = voxmap.grade.stored_coords();
  parallel_items(stored.size(), [&](std::size_t i) { kinds_[bricks_.index(stored[i])] = classify(stored[i]); });
}

void Occupancy::update(const std::vector<Vec3i>& bricks) {
  for (const Vec3i& brick : bricks) kinds_[bricks_.index(brick)] = classify(brick);
}

Occupancy::Kind Occupancy::kind(const Vec3i& brick) const {
  return bricks_.contains(brick) ? kinds_[bricks_.index(brick)] : Kind::kEmpty;
}

Occupancy::Kind Occupancy::classify(const Vec3i& brick) const {
  const GradeBricks::Brick* grades = voxmap_.grade.brick(brick);
  if (grades == nullptr) return Kind::kEmpty;
  const FillBricks::Brick* fill = fill_.brick(brick);
  bool any_air = false;
  bool any_bone = false;
  for (std::size_t i = 0; i < grades->size(); ++i) {
    const bool bone = (*grades)[i] != 0;
    const int remaining = bone && fill != nullptr ? (*fill)[i] : FillBricks::kWhole;
    any_bone |= bone && remaining > 0;
    any_air |= !bone || remaining < FillBricks::kWhole;
    if (any_air && any_bone) return Kind::kMixed;
  }
  return any_bone ? Kind::kFull : Kind::kEmpty;
}

void Occupancy::gather(const Vec3i& lower, int side, float* out) const {
  const VoxelGrid& grid = voxmap_.grid;
  std::fill(out, out + static_cast<std::ptrdiff_t>(side) * side * side, 0.0F);
  const Vec3i from = lower.cwiseMax(0);
  const Vec3i to = (lower.array() + side).min(grid.dims.array());
  constexpr float kPerFillUnit = 1.0F / FillBricks::kWhole;
  for (int z = from.z(); z < to.z(); ++z) {
    for (int y = from.y(); y < to.y(); ++y) {
      float* row = out + side * ((y - lower.y()) + side * (z - lower.z())) - lower.x();
      for (int x = from.x(); x < to.x();) {
        const int end = std::min(to.x(), (x | (FillBricks::kSide - 1)) + 1);
        const Vec3i brick = BrickLattice::brick_of({x, y, z});
        const GradeBricks::Brick* grades = voxmap_.grade.brick(brick);
        if (grades == nullptr) {
          x = end;
          continue;
        }
        const FillBricks::Brick* fill = fill_.brick(brick);
        for (; x < end; ++x) {
          const auto offset = static_cast<std::size_t>(BrickLattice::offset_of({x, y, z}));
          if ((*grades)[offset] == 0) continue;
          row[x] = fill ? kPerFillUnit * static_cast<float>((*fill)[offset]) : 1.0F;
        }
      }
    }
  }
}

}  // namespace reamsim
