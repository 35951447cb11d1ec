#pragma once

#include <cstddef>

#include "sim/bone/voxmap.h"
#include "sim/collide/device_batch.h"
#include "sim/device/opencl.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// What a dense engine is going to keep on the device, planned before any of it is taken.
struct DensePlan {
  std::size_t voxels = 0;
  std::size_t unreamed = 0;  ///< voxels that are bone, gone or not
  std::size_t points = 0;    ///< of the shell
  bool fill = false;         ///< 16 bits a voxel beside the bone; without it every voxel is whole or gone
  std::size_t contacts = 0;  ///< most voxels that one substep can touch: room of the contact list
  std::size_t removed = 0;   ///< room of the list of removed voxels of a batch

  [[nodiscard]] DeviceBatch::RemovedList removed_list() const { return {1, removed, contacts, unreamed}; }
  /// Bytes in all, and in the largest single allocation.
  [[nodiscard]] std::size_t bytes() const;
  [[nodiscard]] std::size_t largest_bytes() const;
};

DensePlan plan_dense(const Voxmap& voxmap, const Tool& tool, bool wear);

/// Throws InputError that says what would fit, unless the plan fits the device: 2^32 voxels (they are numbered in 32
/// bits), the device's memory and its largest allocation.
void require_fit(const DensePlan& plan, const cl::DeviceInfo& device, double voxel_mm);

}  // namespace reamsim
