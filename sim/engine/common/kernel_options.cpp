// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/engine/common/kernel_options.h"

#include <algorithm>

namespace reamsim {

KernelOptions choose_options(const cl::DeviceInfo& info, const EngineTuning& tuning) {
  KernelOptions options;
  const bool gpu =
      tuning.kernel_shape == KernelShape::gpu || (tuning.kernel_shape == KernelShape::automatic && info.gpu);
  options.shape = gpu ? KernelShape::gpu : KernelShape::cpu;
  // On a CPU every work-item is long, and PoCL hands whole groups to threads; on a GPU a cell has some hundred points.
  const std::size_t wanted = tuning.work_group_size > 0 ? static_cast<std::size_t>(tuning.work_group_size)
                             : gpu                      ? 128
                                                        : 1;
  options.work_group = std::min(wanted, info.max_work_group);
  options.culling = tuning.culling;
  return options;
}

std::size_t cut_items(const cl::DeviceInfo& info, const KernelOptions& options) {
  constexpr std::size_t kItemsPerCore = 8, kGroupsPerUnit = 32;
  return info.compute_units * (options.shape == KernelShape::cpu ? kItemsPerCore : kGroupsPerUnit * options.work_group);
}

std::string kernel_defines(const BrickLayout& layout, KernelShape shape) {
  return layout.defines() + (shape == KernelShape::cpu ? " -DRS_CPU_SHAPE" : "");
}

std::string cut_defines(const BrickLayout& layout, KernelShape shape) {
  return kernel_defines(layout, shape) + (shape == KernelShape::cpu ? " -DRS_LANES=16" : "");
}

}  // namespace reamsim
