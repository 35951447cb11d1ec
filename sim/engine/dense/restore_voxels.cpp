// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/dense/restore_voxels.h"

namespace reamsim {

namespace embedded {
extern const char* const kernel_restore_voxels;
}

VoxelRestorer::VoxelRestorer(const cl::Device& device)
    : device_(device),
      program_(device.build("restore_voxels.cl", embedded::kernel_restore_voxels)),
      bytes_(program_, "restore_bytes"),
      halves_(program_, "restore_halves"),
      words_(program_, "restore_words") {}

void VoxelRestorer::write(const std::vector<Entry>& entries, cl_mem values, cl::Kernel& kernel) {
  constexpr std::size_t kGroup = 64;
  if (entries.empty()) return;
  const auto list = cl::upload(device_, entries, "the voxels to restore");
  kernel.set_from(0, list, static_cast<cl_uint>(entries.size()), values);
  const cl::Event done = kernel.launch(device_, entries.size(), kGroup);
  device_.finish();
}

}  // namespace reamsim
