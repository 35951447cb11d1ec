// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "tests/bench/reference/bone_memory.h"

#include "sim/base/error.h"

namespace reamsim::reference {

namespace {

Brick brick_of(const GradeBricks::Brick& grades) {
  Brick out{};
  for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
    const Vec3i voxel = BrickLattice::voxel_at(Vec3i::Zero(), offset);
    const auto place = static_cast<std::size_t>(rs_brick_offset(voxel.x(), voxel.y(), voxel.z()));
    out.grade[place] = grades[static_cast<std::size_t>(offset)];
    if (out.grade[place] != 0) out.bone[place >> 5] |= 1U << (place & 31U);
  }
  return out;
}

std::vector<rs_u64> make_bits_of_bytes() {
  std::vector<rs_u64> out(256);
  for (unsigned byte = 0; byte < 256; ++byte) {
    int at = 0;
    for (unsigned bit = 0; bit < 8; ++bit) {
      if ((byte >> bit & 1U) != 0) out[byte] |= rs_u64{bit} << (8 * at++);
    }
  }
  return out;
}

}  // namespace

const std::vector<rs_u64>& bits_of_bytes() {
  static const std::vector<rs_u64> table = make_bits_of_bytes();
  return table;
}

BoneMemory::BoneMemory(const BoneView& bone) : grid_(bone.voxmap.grid), lattice_(BrickLattice::over(grid_.dims)) {
  if (bone.fill.stored_bricks() > 0) throw RunError("the reference supports only bone of whole voxels");
  restore(bone.voxmap);
}

void BoneMemory::restore(const Voxmap& voxmap) {
  bricks_.clear();
  lattice_of_slot_.clear();
  slot_of_brick_.assign(lattice_.count(), -1);
  const Vec3i superbricks = (lattice_.dims.array() + 3) / 4;
  occupancy_.assign(2 * static_cast<std::size_t>(superbricks.cast<std::int64_t>().prod()), 0);
  bricks_.reserve(voxmap.grade.stored_bricks());
  voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick& grades) {
    const std::size_t index = lattice_.index(coord);
    slot_of_brick_[index] = static_cast<rs_i32>(bricks_.size());
    lattice_of_slot_.push_back(static_cast<rs_u32>(index));
    bricks_.push_back(brick_of(grades));
    occupy(coord);
  });
}

void BoneMemory::occupy(const Vec3i& brick) {
  const Vec3i n = (lattice_.dims.array() + 3) / 4, s = brick / 4;
  const auto word = 2 * static_cast<std::size_t>(s.x() + n.x() * (s.y() + n.y() * s.z()));
  const auto bit = static_cast<unsigned>((brick.x() & 3) | (brick.y() & 3) << 2 | (brick.z() & 3) << 4);
  occupancy_[word + (bit >> 5)] |= 1U << (bit & 31U);
}

BoneArrays BoneMemory::arrays() {
  return {bricks_.data(),
          slot_of_brick_.data(),
          lattice_of_slot_.data(),
          occupancy_.data(),
          {lattice_.dims.x(), lattice_.dims.y(), lattice_.dims.z()}};
}

std::size_t BoneMemory::bytes() const {
  return sizeof(Brick) * bricks_.size() + sizeof(rs_i32) * slot_of_brick_.size() +
         sizeof(rs_u32) * (lattice_of_slot_.size() + occupancy_.size());
}

std::int64_t voxel_index(const BoneMemory& bone, std::size_t brick, rs_i32 place) {
  const Vec3i voxel =
      RS_BRICK_SIDE * bone.lattice().coord(brick) + Vec3i(rs_offset_x(place), rs_offset_y(place), rs_offset_z(place));
  return bone.grid().index(voxel);
}

}  // namespace reamsim::reference
