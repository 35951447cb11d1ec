#include "sim/bone/voxmap/fill_bricks.h"

#include <algorithm>

namespace reamsim {

FillBricks::FillBricks(const Vec3i& dims) : lattice_(BrickLattice::over(dims)) {
  slot_of_brick_.assign(lattice_.count(), -1);
}

std::uint16_t FillBricks::get(const Vec3i& voxel) const {
  const Brick* stored = brick(BrickLattice::brick_of(voxel));
  return stored == nullptr ? kWhole : (*stored)[static_cast<std::size_t>(offset_in_brick(voxel))];
}

void FillBricks::set(const Vec3i& voxel, std::uint16_t fill) {
  const std::size_t index = lattice_.index(BrickLattice::brick_of(voxel));
  if (slot_of_brick_[index] < 0 && fill == kWhole) return;
  std::uint16_t& stored = bricks_[take_slot(index)][static_cast<std::size_t>(offset_in_brick(voxel))];
  if (stored == fill) return;
  stored = fill;
  note_change(index);
}

void FillBricks::put(const Vec3i& brick_coord, const Brick& brick) {
  const std::size_t index = lattice_.index(brick_coord);
  Brick& stored = bricks_[take_slot(index)];
  if (stored == brick) return;
  stored = brick;
  note_change(index);
}

void FillBricks::reserve(std::size_t bricks) {
  bricks_.reserve(bricks_.size() + bricks);
  is_changed_.reserve(is_changed_.size() + bricks);
}

std::size_t FillBricks::take_slot(std::size_t index) {
  std::int32_t& slot = slot_of_brick_[index];
  if (slot < 0) {
    slot = static_cast<std::int32_t>(bricks_.size());
    bricks_.emplace_back().fill(kWhole);
    is_changed_.push_back(0);
  }
  return static_cast<std::size_t>(slot);
}

void FillBricks::note_change(std::size_t index) {
  std::uint8_t& changed = is_changed_[static_cast<std::size_t>(slot_of_brick_[index])];
  if (changed == 0) changed_.push_back(index);
  changed = 1;
}

const FillBricks::Brick* FillBricks::brick(const Vec3i& brick_coord) const {
  const std::int32_t slot = slot_of_brick_[lattice_.index(brick_coord)];
  return slot < 0 ? nullptr : &bricks_[static_cast<std::size_t>(slot)];
}

std::vector<Vec3i> FillBricks::take_changed() {
  std::sort(changed_.begin(), changed_.end());
  std::vector<Vec3i> out;
  out.reserve(changed_.size());
  for (const std::size_t index : changed_) {
    is_changed_[static_cast<std::size_t>(slot_of_brick_[index])] = 0;
    out.push_back(lattice_.coord(index));
  }
  changed_.clear();
  return out;
}

std::size_t FillBricks::bytes() const {
  return slot_of_brick_.size() * sizeof(std::int32_t) + bricks_.size() * sizeof(Brick);
}

}  // namespace reamsim
