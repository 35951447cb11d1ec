// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/device_batch.h"

#include <algorithm>
#include <bit>
#include <utility>

namespace reamsim {

DeviceBatch::DeviceBatch(const cl::Device& device, const RemovedList& removed)
    : device_(device),
      args_(device, kMaxSlots, "the substeps' arguments"),
      sums_(device, kMaxSlots, "the substeps' sums"),
      contact_count_(device, kMaxSlots, "the contact counts"),
      removed_(device, std::max<std::size_t>(1, removed.words * removed.room), "the list of removed voxels"),
      removed_words_(removed.words),
      removed_count_(device, 1, "the count of removed voxels"),
      removed_before_(device, kMaxSlots, "the counts of removed voxels"),
      room_{{static_cast<cl_uint>(removed.room), static_cast<cl_uint>(removed.per_substep)}},
      host_args_(kMaxSlots) {
  if (!removed.resumes && removed.room < removed.in_total) {
    const std::size_t substeps = removed.room / std::max<std::size_t>(1, removed.per_substep);
    slots_ = static_cast<int>(std::clamp<std::size_t>(substeps, 1, kMaxSlots));
  }
  sums_.clear(device_, kMaxSlots);
  contact_count_.clear(device_, kMaxSlots);
  removed_count_.clear(device_, 1);
}

int DeviceBatch::add(const SubstepArgs& args) {
  host_args_[static_cast<std::size_t>(used_)] = args;
  return used_++;
}

void DeviceBatch::write_args() {
  if (used_ > 0) args_.write(device_, host_args_.data(), static_cast<std::size_t>(used_), 0, false);
}

int DeviceBatch::begin(const SubstepArgs& args) {
  if (has_removed_) removed_count_.clear(device_, 1);
  has_removed_ = false;
  const int slot = add(args);
  const auto at = static_cast<std::size_t>(slot);
  args_.write(device_, &host_args_[at], 1, at, false);
  return slot;
}

void DeviceBatch::read_sums() {
  if (!host_sums_.empty()) return;
  host_sums_.resize(static_cast<std::size_t>(used_));
  if (used_ > 0) sums_.read(device_, host_sums_.data(), host_sums_.size());  // waits: the queue is in order
}

int DeviceBatch::first_waiting() {
  read_sums();
  const auto at =
      std::find_if(host_sums_.begin(), host_sums_.end(), [](const auto& sums) { return sums.contacts < 0; });
  return at == host_sums_.end() ? -1 : static_cast<int>(at - host_sums_.begin());
}

std::vector<cl_ulong> DeviceBatch::make_room(int slot) {
  // The sums of detect in `slot` remain; later slots have only the mark of waiting.
  const auto first = static_cast<std::size_t>(slot);
  host_sums_[first].contacts = 0;
  std::fill(host_sums_.begin() + slot + 1, host_sums_.end(), SubstepSums{});
  sums_.write(device_, &host_sums_[first], host_sums_.size() - first, first);
  host_sums_.clear();
  has_removed_ = true;
  const cl_uint none = 0;
  removed_before_.write(device_, &none, 1, first);
  return take_removed();
}

std::vector<SubstepSums> DeviceBatch::collect() {
  read_sums();
  const auto used = static_cast<std::size_t>(used_);
  if (used == 0) return {};
  sums_.clear(device_, used);
  contact_count_.clear(device_, used);
  used_ = 0;
  has_removed_ = true;
  return std::exchange(host_sums_, {});
}

std::vector<cl_ulong> DeviceBatch::take_removed() {
  if (!has_removed_) return {};
  cl_uint count = 0;
  removed_count_.read(device_, &count, 1);
  std::vector<cl_ulong> words(count * removed_words_);
  if (!words.empty()) removed_.read(device_, words.data(), words.size());
  removed_count_.clear(device_, 1);
  has_removed_ = false;
  return words;
}

void DeviceBatch::append_removed(const RemovedBlock& block, const VoxelGrid& grid, RemovedFrames& removed) const {
  const std::int32_t frame = host_args_[block.detail >> 3].frame;
  const Vec3i brick = BrickLattice::over(grid.dims).coord(block.brick);
  const auto first = static_cast<rs_i32>((block.detail & 7U) << 6);
  const Vec3i corner = RS_BRICK_SIDE * brick + Vec3i(rs_offset_x(first), rs_offset_y(first), rs_offset_z(first));
  const std::int64_t base = grid.index(corner);
  const std::int64_t row_step = grid.dims.x(), layer_step = row_step * grid.dims.y();
  for (rs_u64 rest = block.removed; rest != 0; rest &= rest - 1) {
    const int bit = std::countr_zero(rest);
    removed.emplace_back(base + (bit & 3) + row_step * (bit >> 2 & 3) + layer_step * (bit >> 4), frame);
  }
}

std::size_t DeviceBatch::bytes(const RemovedList& removed) {
  return sizeof(cl_ulong) * removed.words * removed.room + sizeof(cl_uint) +
         kMaxSlots * (sizeof(SubstepArgs) + sizeof(SubstepSums) + 2 * sizeof(cl_uint));
}

std::vector<StageTimes> stage_times(cl::SlotKernel& detect, cl::SlotKernel& cut) {
  const std::vector<double> detect_s = detect.take_seconds(), cut_s = cut.take_seconds();
  std::vector<StageTimes> out;
  for (std::size_t i = 0; i < cut_s.size(); ++i) out.push_back({detect_s[i], cut_s[i]});
  return out;
}

void copy_fill(const std::vector<std::uint16_t>& dense, const Voxmap& voxmap, FillBricks& fill) {
  voxmap.grade.for_each_brick([&](const Vec3i& coord, const GradeBricks::Brick& grades) {
    for (int offset = 0; offset < GradeBricks::kVoxels; ++offset) {
      if (grades[static_cast<std::size_t>(offset)] == 0) continue;
      const Vec3i voxel = BrickLattice::voxel_at(coord, offset);
      const auto remaining = dense[static_cast<std::size_t>(voxmap.grid.index(voxel))];
      if (remaining != FillBricks::kWhole) fill.set(voxel, remaining);
    }
  });
}

}  // namespace reamsim
