#include "sim/bone/voxmap/grade_bricks.h"

#include <algorithm>

namespace reamsim {

namespace {

constexpr GradeBricks::Brick kAirBrick{};

}  // namespace

GradeBricks::GradeBricks(const Vec3i& dims) : lattice_(BrickLattice::over(dims)) {
  slot_of_brick_.assign(lattice_.count(), -1);
}

std::int32_t GradeBricks::take_slot() {
  if (!free_.empty()) {
    const std::int32_t slot = free_.back();
    free_.pop_back();
    stored(slot) = kAirBrick;
    return slot;
  }
  if (used_ % kPageBricks == 0) pages_.emplace_back().reserve(kPageBricks);
  pages_.back().push_back(kAirBrick);
  return static_cast<std::int32_t>(used_++);
}

void GradeBricks::set(const Vec3i& voxel, std::uint8_t grade) {
  std::int32_t& slot = slot_of_brick_[lattice_.index(BrickLattice::brick_of(voxel))];
  if (slot < 0) {
    if (grade == 0) return;
    slot = take_slot();
  }
  Brick& brick = stored(slot);
  std::uint8_t& old = brick[static_cast<std::size_t>(BrickLattice::offset_of(voxel))];
  const bool fell = old != 0 && grade == 0;
  old = grade;
  if (!fell || brick != kAirBrick) return;
  free_.push_back(slot);
  slot = -1;
}

void GradeBricks::put(const Vec3i& brick_coord, const Brick& brick) {
  std::int32_t& slot = slot_of_brick_[lattice_.index(brick_coord)];
  if (brick == kAirBrick) {
    if (slot >= 0) free_.push_back(slot);
    slot = -1;
    return;
  }
  if (slot < 0) slot = take_slot();
  stored(slot) = brick;
}

std::vector<Vec3i> GradeBricks::stored_coords() const {
  std::vector<Vec3i> out;
  out.reserve(stored_bricks());
  for_each_brick([&out](const Vec3i& coord, const Brick&) { out.push_back(coord); });
  return out;
}

std::vector<Vec3i> GradeBricks::coords_around() const {
  const BrickLattice wider{lattice_.dims + Vec3i::Constant(2)};
  std::vector<bool> near(wider.count(), false);
  for_each_brick([&](const Vec3i& coord, const Brick&) {
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

std::int64_t GradeBricks::count() const {
  std::int64_t out = 0;
  for_each_brick([&out](const Vec3i&, const Brick& brick) {
    out += kVoxels - std::count(brick.begin(), brick.end(), std::uint8_t{0});
  });
  return out;
}

std::size_t GradeBricks::bytes() const {
  return slot_of_brick_.size() * sizeof(std::int32_t) + used_ * sizeof(Brick);
}

bool GradeBricks::operator==(const GradeBricks& other) const {
  if (lattice_.dims != other.lattice_.dims || stored_bricks() != other.stored_bricks()) return false;
  for (std::size_t i = 0; i < slot_of_brick_.size(); ++i) {
    const std::int32_t slot = slot_of_brick_[i], its = other.slot_of_brick_[i];
    if ((slot < 0) != (its < 0)) return false;
    if (slot >= 0 && stored(slot) != other.stored(its)) return false;
  }
  return true;
}

}  // namespace reamsim
