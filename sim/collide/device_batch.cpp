#include "sim/collide/device_batch.h"

#include <algorithm>

namespace reamsim {

DeviceBatch::DeviceBatch(const cl::Device& device, std::size_t removed_room, std::size_t removed_per_substep,
                         std::size_t removed_in_all)
    : device_(device),
      args_(device, kMaxSlots, "the substeps' arguments"),
      sums_(device, kMaxSlots, "the substeps' sums"),
      contact_count_(device, kMaxSlots, "the contact counts"),
      removed_(device, std::max<std::size_t>(1, removed_room), "the list of removed voxels"),
      removed_count_(device, 1, "the count of removed voxels"),
      host_args_(kMaxSlots) {
  if (removed_room < removed_in_all) {
    const std::size_t substeps = removed_room / std::max<std::size_t>(1, removed_per_substep);
    slots_ = static_cast<int>(std::clamp<std::size_t>(substeps, 1, kMaxSlots));
  }
  clear(kMaxSlots);
}

int DeviceBatch::begin(const SubstepArgs& args) {
  const int slot = used_++;
  const auto at = static_cast<std::size_t>(slot);
  host_args_[at] = args;
  args_.write(device_, &host_args_[at], 1, at, false);
  return slot;
}

DeviceBatch::Results DeviceBatch::collect() {
  device_.finish();
  Results results;
  if (used_ == 0) return results;
  const auto used = static_cast<std::size_t>(used_);
  results.sums.resize(used);
  sums_.read(device_, results.sums.data(), used);
  cl_uint removed_count = 0;
  removed_count_.read(device_, &removed_count, 1);
  results.removed.resize(removed_count);
  if (removed_count > 0) removed_.read(device_, results.removed.data(), removed_count);
  clear(used);
  used_ = 0;
  return results;
}

std::size_t DeviceBatch::bytes(std::size_t removed_room) {
  return sizeof(RemovedVoxel) * removed_room + sizeof(cl_uint) +
         kMaxSlots * (sizeof(SubstepArgs) + sizeof(SubstepSums) + sizeof(cl_uint));
}

void DeviceBatch::clear(std::size_t slots) {
  sums_.clear(device_, slots);
  contact_count_.clear(device_, slots);
  removed_count_.clear(device_, 1);
}

}  // namespace reamsim
