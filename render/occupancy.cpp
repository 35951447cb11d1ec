#include "render/occupancy.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace reamsim {

Occupancy::Occupancy(const Voxmap& voxmap, State state)
    : voxmap_(voxmap),
      state_(state),
      brick_dims_((voxmap.grid.dims.array() + FillBricks::kSide - 1) / FillBricks::kSide) {
  kinds_.resize(static_cast<std::size_t>(brick_dims_.x()) * brick_dims_.y() * brick_dims_.z());
  tbb::parallel_for(0, brick_dims_.z(), [this](int z) {
    for (int y = 0; y < brick_dims_.y(); ++y) {
      for (int x = 0; x < brick_dims_.x(); ++x) kinds_[brick_index({x, y, z})] = look_at({x, y, z});
    }
  });
}

void Occupancy::update(const std::vector<Vec3i>& bricks) {
  for (const Vec3i& brick : bricks) kinds_[brick_index(brick)] = look_at(brick);
}

Occupancy::Kind Occupancy::kind(const Vec3i& brick) const {
  const bool inside = (brick.array() >= 0).all() && (brick.array() < brick_dims_.array()).all();
  return inside ? kinds_[brick_index(brick)] : Kind::kEmpty;
}

std::size_t Occupancy::brick_index(const Vec3i& brick) const {
  return static_cast<std::size_t>(brick.x()) +
         static_cast<std::size_t>(brick_dims_.x()) *
             (static_cast<std::size_t>(brick.y()) + static_cast<std::size_t>(brick_dims_.y()) * brick.z());
}

Occupancy::Kind Occupancy::look_at(const Vec3i& brick) const {
  const VoxelGrid& grid = voxmap_.grid;
  const FillBricks::Brick* fill = state_ == State::kCurrent ? voxmap_.fill.brick(brick) : nullptr;
  const Vec3i lower = brick * FillBricks::kSide;
  const Vec3i upper = (lower.array() + FillBricks::kSide).min(grid.dims.array());
  // A brick that sticks out of the lattice has air in it.
  bool any_air = ((upper - lower).array() < FillBricks::kSide).any();
  bool any_bone = false;
  for (int z = lower.z(); z < upper.z(); ++z) {
    for (int y = lower.y(); y < upper.y(); ++y) {
      for (int x = lower.x(); x < upper.x(); ++x) {
        const bool bone = voxmap_.grade[static_cast<std::size_t>(grid.index(x, y, z))] != 0;
        const int left = bone && fill ? (*fill)[FillBricks::offset_in_brick({x, y, z})] : FillBricks::kWhole;
        any_bone |= bone && left > 0;
        any_air |= !bone || left < FillBricks::kWhole;
      }
    }
    if (any_air && any_bone) return Kind::kMixed;
  }
  return any_bone ? Kind::kFull : Kind::kEmpty;
}

void Occupancy::gather(const Vec3i& lower, int side, float* out) const {
  const VoxelGrid& grid = voxmap_.grid;
  std::fill(out, out + static_cast<std::ptrdiff_t>(side) * side * side, 0.0F);
  const Vec3i from = lower.cwiseMax(0);
  const Vec3i to = (lower.array() + side).min(grid.dims.array());
  constexpr float kShare = 1.0F / FillBricks::kWhole;
  for (int z = from.z(); z < to.z(); ++z) {
    for (int y = from.y(); y < to.y(); ++y) {
      const std::uint8_t* grades = voxmap_.grade.data() + grid.index(0, y, z);
      float* row = out + side * ((y - lower.y()) + side * (z - lower.z())) - lower.x();
      for (int x = from.x(); x < to.x();) {
        const int end = std::min(to.x(), (x | (FillBricks::kSide - 1)) + 1);
        const FillBricks::Brick* fill =
            state_ == State::kCurrent ? voxmap_.fill.brick(Vec3i(x, y, z) / FillBricks::kSide) : nullptr;
        for (; x < end; ++x) {
          if (grades[x] == 0) continue;
          row[x] = fill ? kShare * static_cast<float>((*fill)[FillBricks::offset_in_brick({x, y, z})]) : 1.0F;
        }
      }
    }
  }
}

}  // namespace reamsim
