#include "sim/bone/fill_bricks.h"

namespace reamsim {

namespace {

Vec3i brick_of(const Vec3i& voxel) {
  return {voxel.x() >> 3, voxel.y() >> 3, voxel.z() >> 3};
}

}  // namespace

FillBricks::FillBricks(const Vec3i& dims) : brick_dims_((dims.array() + (kSide - 1)) / kSide) {
  const std::size_t count = static_cast<std::size_t>(brick_dims_.x()) * static_cast<std::size_t>(brick_dims_.y()) *
                            static_cast<std::size_t>(brick_dims_.z());
  slot_of_brick_.assign(count, -1);
  changed_.assign(count, 0);
}

std::size_t FillBricks::brick_index(const Vec3i& brick_coord) const {
  const auto nx = static_cast<std::size_t>(brick_dims_.x());
  const auto ny = static_cast<std::size_t>(brick_dims_.y());
  return static_cast<std::size_t>(brick_coord.x()) +
         nx * (static_cast<std::size_t>(brick_coord.y()) + ny * static_cast<std::size_t>(brick_coord.z()));
}

std::uint16_t FillBricks::get(const Vec3i& voxel) const {
  const Brick* stored = brick(brick_of(voxel));
  return stored == nullptr ? kWhole : (*stored)[static_cast<std::size_t>(offset_in_brick(voxel))];
}

void FillBricks::set(const Vec3i& voxel, std::uint16_t fill) {
  const std::size_t index = brick_index(brick_of(voxel));
  std::int32_t& slot = slot_of_brick_[index];
  if (slot < 0) {
    if (fill == kWhole) return;
    slot = static_cast<std::int32_t>(bricks_.size());
    bricks_.emplace_back().fill(kWhole);
  }
  std::uint16_t& stored = bricks_[static_cast<std::size_t>(slot)][static_cast<std::size_t>(offset_in_brick(voxel))];
  if (stored == fill) return;
  stored = fill;
  changed_[index] = 1;
}

const FillBricks::Brick* FillBricks::brick(const Vec3i& brick_coord) const {
  const std::int32_t slot = slot_of_brick_[brick_index(brick_coord)];
  return slot < 0 ? nullptr : &bricks_[static_cast<std::size_t>(slot)];
}

std::vector<Vec3i> FillBricks::take_changed() {
  std::vector<Vec3i> out;
  std::size_t index = 0;
  for (int z = 0; z < brick_dims_.z(); ++z) {
    for (int y = 0; y < brick_dims_.y(); ++y) {
      for (int x = 0; x < brick_dims_.x(); ++x, ++index) {
        if (changed_[index] == 0) continue;
        changed_[index] = 0;
        out.emplace_back(x, y, z);
      }
    }
  }
  return out;
}

}  // namespace reamsim
