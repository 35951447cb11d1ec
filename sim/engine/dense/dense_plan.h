// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <string>

#include "sim/bone/voxmap/voxmap.h"
#include "sim/device/opencl.h"
#include "sim/engine/common/device_batch.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// Layout of the voxels of a dense engine; the published ones.
enum class VoxelLayout {
  claimed_grade,  ///< direct: an 8-bit grade (the paper), and a claim bit
  flagged_hu,     ///< octree: a float HU and a collision flag of 8 bits (Zheng et al.)
  bare_grade,     ///< implicit: an 8-bit grade alone; no voxel is tested twice
};

/// The device memory of a dense engine, planned before it is allocated.
struct DensePlan {
  VoxelLayout layout = VoxelLayout::claimed_grade;
  std::size_t voxels = 0;
  std::size_t bone_voxels = 0;  ///< voxels of bone, removed ones included
  std::size_t points = 0;       ///< of the shell; 0 for implicit
  bool wide_codes = false;      ///< 8 bytes per Morton code instead of 4: shells of more than 1024 cells per axis
  bool fill = false;            ///< 16 bits per voxel beside the grade; without it voxels are whole or removed
  std::size_t contacts = 0;     ///< size of the contact list: most voxels that one substep can touch
  std::size_t removed = 0;      ///< size of a batch's list of removed voxels

  [[nodiscard]] DeviceBatch::RemovedList removed_list() const { return {1, removed, contacts, bone_voxels}; }
  [[nodiscard]] std::size_t bone_bytes() const;
  [[nodiscard]] std::size_t claim_bytes() const;
  [[nodiscard]] std::size_t fill_bytes() const;
  [[nodiscard]] std::size_t shell_bytes() const;
  /// In total, and in the largest single allocation.
  [[nodiscard]] std::size_t bytes() const;
  [[nodiscard]] std::size_t largest_bytes() const;
};

/// `engine`: direct | octree | implicit.
DensePlan plan_dense(EngineKind engine, const BoneView& bone, const Tool& tool, bool wear);

/// Throws InputError with the voxel size that would fit, unless the plan fits: 2^32 voxels (32-bit indices), the
/// device's memory and its largest allocation.
void require_fit(const DensePlan& plan, const cl::DeviceInfo& device, double voxel_mm);

}  // namespace reamsim
