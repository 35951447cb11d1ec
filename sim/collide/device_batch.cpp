#include "sim/collide/device_batch.h"

#include <algorithm>

namespace reamsim {

DeviceBatch::DeviceBatch(const cl::Device& device, const RemovedList& removed)
    : device_(device),
      args_(device, kMaxSlots, "the substeps' arguments"),
      sums_(device, kMaxSlots, "the substeps' sums"),
      contact_count_(device, kMaxSlots, "the contact counts"),
      removed_(device, std::max<std::size_t>(1, removed.words * removed.room), "the list of removed voxels"),
      removed_words_(removed.words),
      removed_count_(device, 1, "the count of removed voxels"),
      host_args_(kMaxSlots) {
  if (removed.room < removed.in_all) {
    const std::size_t substeps = removed.room / std::max<std::size_t>(1, removed.per_substep);
    slots_ = static_cast<int>(std::clamp<std::size_t>(substeps, 1, kMaxSlots));
  }
  sums_.clear(device_, kMaxSlots);
  contact_count_.clear(device_, kMaxSlots);
  removed_count_.clear(device_, 1);
}

int DeviceBatch::begin(const SubstepArgs& args) {
  if (removed_waits_) removed_count_.clear(device_, 1);
  removed_waits_ = false;
  const int slot = used_++;
  const auto at = static_cast<std::size_t>(slot);
  host_args_[at] = args;
  args_.write(device_, &host_args_[at], 1, at, false);
  return slot;
}

std::vector<SubstepSums> DeviceBatch::collect() {
  const auto used = static_cast<std::size_t>(used_);
  std::vector<SubstepSums> sums(used);
  if (used == 0) return sums;
  sums_.read(device_, sums.data(), used);  // waits: the queue is in order
  sums_.clear(device_, used);
  contact_count_.clear(device_, used);
  used_ = 0;
  removed_waits_ = true;
  return sums;
}

std::vector<cl_ulong> DeviceBatch::take_removed() {
  if (!removed_waits_) return {};
  cl_uint count = 0;
  removed_count_.read(device_, &count, 1);
  std::vector<cl_ulong> words(count * removed_words_);
  if (!words.empty()) removed_.read(device_, words.data(), words.size());
  removed_count_.clear(device_, 1);
  removed_waits_ = false;
  return words;
}

std::size_t DeviceBatch::bytes(const RemovedList& removed) {
  return sizeof(cl_ulong) * removed.words * removed.room + sizeof(cl_uint) +
         kMaxSlots * (sizeof(SubstepArgs) + sizeof(SubstepSums) + sizeof(cl_uint));
}

}  // namespace reamsim
