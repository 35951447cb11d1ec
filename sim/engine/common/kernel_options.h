// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <string>

#include "sim/engine/common/device_bricks.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// How the kernels over bricks run; the results do not depend on it.
struct KernelOptions {
  KernelShape shape =
      KernelShape::cpu;  ///< not `automatic`: a work-item that does much, in vectors, or many that do little
  std::size_t work_group = 1;
  bool culling = true;  ///< pass over cells that cannot touch; off only to prove that it changes nothing
};

/// What the tuning leaves open is chosen for the device.
KernelOptions choose_options(const cl::DeviceInfo& info, const EngineTuning& tuning);

/// Work-items that fill the device with a cut: on a CPU few that take many bricks each, on a GPU many groups.
std::size_t cut_items(const cl::DeviceInfo& info, const KernelOptions& options);

/// Options that kernels over bricks are compiled with, and those of the cuts.
std::string kernel_defines(const BrickLayout& layout, KernelShape shape);
std::string cut_defines(const BrickLayout& layout, KernelShape shape);

}  // namespace reamsim
