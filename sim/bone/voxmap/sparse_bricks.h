// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "sim/base/geometry.h"

namespace reamsim {

/// The bricks (8×8×8 voxels) that cover a lattice of voxels. Those at its upper borders may extend beyond it. Brick
/// (i,j,k) has the index i + nx·(j + ny·k).
struct BrickLattice {
  static constexpr int kSide = 8;
  static constexpr int kVoxels = kSide * kSide * kSide;

  Vec3i dims = Vec3i::Zero();  ///< bricks along each axis: ceil(voxels/8)

  static BrickLattice over(const Vec3i& voxels) { return {(voxels.array() + (kSide - 1)) / kSide}; }

  /// The brick that contains a voxel. Rounds down for negative coordinates as well.
  static Vec3i brick_of(const Vec3i& voxel) { return {voxel.x() >> 3, voxel.y() >> 3, voxel.z() >> 3}; }
  /// Voxel (x,y,z) of a brick has the offset x + 8·(y + 8·z).
  static int offset_of(const Vec3i& voxel) {
    return (voxel.x() & 7) + kSide * ((voxel.y() & 7) + kSide * (voxel.z() & 7));
  }
  static Vec3i voxel_at(const Vec3i& brick, int offset) {
    return kSide * brick + Vec3i(offset & 7, (offset >> 3) & 7, offset >> 6);
  }

  [[nodiscard]] std::size_t count() const { return index({0, 0, dims.z()}); }
  [[nodiscard]] std::size_t index(const Vec3i& brick) const { return index_in(dims, brick); }
  [[nodiscard]] Vec3i coord(std::size_t index) const { return cell_at(dims, index); }
  [[nodiscard]] bool contains(const Vec3i& brick) const { return contains_cell(dims, brick); }
};

/// One value per voxel of a lattice, stored in bricks of 8×8×8 voxels. A brick whose voxels are all `kAbsent` is not
/// stored. The last bricks may extend beyond the lattice. Copies share memory until one of them changes.
template <class T, T kAbsent>
class SparseBricks {
 public:
  static constexpr int kSide = BrickLattice::kSide;
  static constexpr int kVoxels = BrickLattice::kVoxels;
  using Brick = std::array<T, kVoxels>;

  SparseBricks() = default;
  /// All voxels are absent. `dims`: voxels along each axis.
  explicit SparseBricks(const Vec3i& dims) : lattice_(BrickLattice::over(dims)), slot_of_brick_(lattice_.count(), -1) {}

  [[nodiscard]] T get(const Vec3i& voxel) const {
    const Brick* brick = this->brick(BrickLattice::brick_of(voxel));
    return brick == nullptr ? kAbsent : (*brick)[static_cast<std::size_t>(BrickLattice::offset_of(voxel))];
  }

  /// Returns whether the value changed.
  bool set(const Vec3i& voxel, T value) {
    std::int32_t& slot = slot_of_brick_[lattice_.index(BrickLattice::brick_of(voxel))];
    if (slot < 0) {
      if (value == kAbsent) return false;
      slot = take_slot();
    }
    const auto offset = static_cast<std::size_t>(BrickLattice::offset_of(voxel));
    if (std::as_const(*this).stored(slot)[offset] == value) return false;
    Brick& brick = stored(slot);
    brick[offset] = value;
    if (value == kAbsent && brick == kAllAbsent) free_slot(slot);
    return true;
  }

  /// Replaces a brick; coordinates in bricks. Returns whether it changed.
  bool put(const Vec3i& brick_coord, const Brick& brick) {
    std::int32_t& slot = slot_of_brick_[lattice_.index(brick_coord)];
    const bool absent = brick == kAllAbsent;
    if (slot < 0 ? absent : std::as_const(*this).stored(slot) == brick) return false;
    if (absent) {
      free_slot(slot);
      return true;
    }
    if (slot < 0) slot = take_slot();
    stored(slot) = brick;
    return true;
  }

  /// Bricks along each axis.
  [[nodiscard]] Vec3i brick_dims() const { return lattice_.dims; }
  [[nodiscard]] const BrickLattice& lattice() const { return lattice_; }
  [[nodiscard]] std::size_t stored_bricks() const { return used_ - free_.size(); }
  /// nullptr where all voxels are absent.
  [[nodiscard]] const Brick* brick(const Vec3i& brick_coord) const {
    const std::int32_t slot = slot_of_brick_[lattice_.index(brick_coord)];
    return slot < 0 ? nullptr : &stored(slot);
  }

  /// Calls visit(brick coordinates, brick) for every stored brick, x fastest.
  template <class Visit>
  void for_each_brick(const Visit& visit) const {
    if (used_ == 0) return;
    for (std::size_t i = 0; i < slot_of_brick_.size(); ++i) {
      if (slot_of_brick_[i] >= 0) visit(lattice_.coord(i), stored(slot_of_brick_[i]));
    }
  }
  /// Coordinates of the stored bricks, x fastest.
  [[nodiscard]] std::vector<Vec3i> stored_coords() const {
    std::vector<Vec3i> out;
    out.reserve(stored_bricks());
    for_each_brick([&out](const Vec3i& coord, const Brick&) { out.push_back(coord); });
    return out;
  }
  /// Voxels that are not absent.
  [[nodiscard]] std::int64_t count() const {
    std::int64_t out = 0;
    for_each_brick(
        [&out](const Vec3i&, const Brick& brick) { out += kVoxels - std::count(brick.begin(), brick.end(), kAbsent); });
    return out;
  }
  [[nodiscard]] std::size_t bytes() const {
    return slot_of_brick_.size() * sizeof(std::int32_t) + used_ * sizeof(Brick);
  }

  /// The same lattice and the same values.
  bool operator==(const SparseBricks& other) const {
    if (lattice_.dims != other.lattice_.dims || stored_bricks() != other.stored_bricks()) return false;
    for (std::size_t i = 0; i < slot_of_brick_.size(); ++i) {
      const std::int32_t slot = slot_of_brick_[i], its = other.slot_of_brick_[i];
      if ((slot < 0) != (its < 0)) return false;
      if (slot >= 0 && stored(slot) != other.stored(its)) return false;
    }
    return true;
  }

 private:
  // Pages: a growing vector would need twice the memory while it reallocates, and copies share unchanged ones.
  static constexpr std::size_t kPageBricks = (std::size_t{1} << 18) / sizeof(Brick);
  using Page = std::vector<Brick>;

  static constexpr Brick kAllAbsent = [] {
    Brick brick{};
    brick.fill(kAbsent);
    return brick;
  }();
  [[nodiscard]] const Brick& stored(std::int32_t slot) const {
    const auto at = static_cast<std::size_t>(slot);
    return (*pages_[at / kPageBricks])[at % kPageBricks];
  }
  Brick& stored(std::int32_t slot) {
    const auto at = static_cast<std::size_t>(slot);
    return own(pages_[at / kPageBricks])[at % kPageBricks];
  }

  /// The page, after copying it where another object has it too.
  static Page& own(std::shared_ptr<Page>& page) {
    if (page.use_count() > 1) {
      auto copy = std::make_shared<Page>();
      copy->reserve(kPageBricks);
      *copy = *page;
      page = std::move(copy);
    }
    return *page;
  }

  std::int32_t take_slot() {
    if (!free_.empty()) {
      const std::int32_t slot = free_.back();
      free_.pop_back();
      stored(slot).fill(kAbsent);
      return slot;
    }
    if (used_ % kPageBricks == 0) pages_.emplace_back(std::make_shared<Page>())->reserve(kPageBricks);
    own(pages_.back()).emplace_back().fill(kAbsent);
    return static_cast<std::int32_t>(used_++);
  }
  void free_slot(std::int32_t& slot) {
    if (slot >= 0) free_.push_back(slot);
    slot = -1;
  }

  BrickLattice lattice_;
  std::vector<std::int32_t> slot_of_brick_;  // -1: all absent
  std::vector<std::shared_ptr<Page>> pages_;
  std::size_t used_ = 0;            // slots in the pages
  std::vector<std::int32_t> free_;  // slots whose brick became absent
};

/// The grade of each voxel, 0 = air (DensityMapping).
using GradeBricks = SparseBricks<std::uint8_t, 0>;

/// The fill of each voxel, in units of 1/65535. Records which bricks change.
class FillBricks : private SparseBricks<std::uint16_t, 65535> {
 public:
  using Bricks = SparseBricks<std::uint16_t, 65535>;
  using Bricks::Brick, Bricks::kSide, Bricks::kVoxels;
  using Bricks::bytes, Bricks::for_each_brick;
  using Bricks::get, Bricks::brick, Bricks::brick_dims, Bricks::lattice, Bricks::stored_bricks;
  static constexpr std::uint16_t kWhole = 65535;

  FillBricks() = default;
  /// All voxels are whole. `dims`: voxels along each axis.
  explicit FillBricks(const Vec3i& dims) : Bricks(dims) {}

  void set(const Vec3i& voxel, std::uint16_t fill) {
    if (Bricks::set(voxel, fill)) mark_changed(BrickLattice::brick_of(voxel));
  }
  /// Coordinates in bricks.
  void put(const Vec3i& brick_coord, const Brick& brick) {
    if (Bricks::put(brick_coord, brick)) mark_changed(brick_coord);
  }

  /// The bricks that changed since the last take_changed().
  [[nodiscard]] std::vector<Vec3i> changed() const {
    std::vector<Vec3i> out;
    out.reserve(changed_.size());
    for (const std::size_t index : changed_) out.push_back(lattice().coord(index));
    return out;
  }
  /// Records that a brick has changed; coordinates in bricks.
  void mark_changed(const Vec3i& brick_coord) {
    const std::size_t index = lattice().index(brick_coord);
    if (is_changed_.empty()) is_changed_.resize(lattice().count());
    if (!is_changed_[index]) changed_.push_back(index);
    is_changed_[index] = true;
  }
  /// Returns the bricks that changed since the last call, x fastest, and resets the record.
  std::vector<Vec3i> take_changed() {
    std::sort(changed_.begin(), changed_.end());
    std::vector<Vec3i> out = changed();
    for (const std::size_t index : std::exchange(changed_, {})) is_changed_[index] = false;
    return out;
  }

 private:
  std::vector<bool> is_changed_;      // by brick; empty before the first change
  std::vector<std::size_t> changed_;  // indices of bricks
};

/// The bricks in which two fills of a lattice may differ, x fastest.
inline std::vector<Vec3i> differing_bricks(const FillBricks& a, const FillBricks& b) {
  std::vector<Vec3i> out;
  for (std::size_t i = 0; i < a.lattice().count(); ++i) {
    const Vec3i coord = a.lattice().coord(i);
    const FillBricks::Brick *in_a = a.brick(coord), *in_b = b.brick(coord);
    if (in_a != in_b && (in_a == nullptr || in_b == nullptr || *in_a != *in_b)) out.push_back(coord);
  }
  return out;
}

}  // namespace reamsim
