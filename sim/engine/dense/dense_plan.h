#pragma once

#include <cstddef>
#include <string>

#include "sim/bone/voxmap/voxmap.h"
#include "sim/device/opencl.h"
#include "sim/engine/common/device_batch.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// How a dense engine keeps its voxels; the published layouts.
enum class VoxelLayout {
  claimed_grade,  ///< direct: an 8-bit grade (the paper), and a claim bit
  flagged_hu,     ///< octree: a float HU and a collision flag of 8 bits (Zheng et al.)
  bare_grade,     ///< implicit: an 8-bit grade alone; no voxel is tested twice, so none is claimed
};

/// What a dense engine is going to keep on the device, planned before any of it is taken.
struct DensePlan {
  VoxelLayout layout = VoxelLayout::claimed_grade;
  std::size_t voxels = 0;
  std::size_t unreamed = 0;  ///< voxels that are bone, gone or not
  std::size_t points = 0;    ///< of the shell; 0 where the detector has no use for it
  bool wide_codes = false;   ///< 8 bytes a Morton code instead of 4: shells of more than 1024 cells an axis
  bool fill = false;         ///< 16 bits a voxel beside the bone; without it every voxel is whole or gone
  std::size_t contacts = 0;  ///< most voxels that one substep can touch: room of the contact list
  std::size_t removed = 0;   ///< room of the list of removed voxels of a batch

  [[nodiscard]] DeviceBatch::RemovedList removed_list() const { return {1, removed, contacts, unreamed}; }
  [[nodiscard]] std::size_t bone_bytes() const;
  [[nodiscard]] std::size_t claim_bytes() const;
  [[nodiscard]] std::size_t fill_bytes() const;
  [[nodiscard]] std::size_t shell_bytes() const;
  /// Bytes in all, and in the largest single allocation.
  [[nodiscard]] std::size_t bytes() const;
  [[nodiscard]] std::size_t largest_bytes() const;
};

/// `engine`: direct | octree | implicit.
DensePlan plan_dense(EngineKind engine, const BoneView& bone, const Tool& tool, bool wear);

/// Throws InputError that says what would fit, unless the plan fits the device: 2^32 voxels (they are numbered in 32
/// bits), the device's memory and its largest allocation.
void require_fit(const DensePlan& plan, const cl::DeviceInfo& device, double voxel_mm);

}  // namespace reamsim
