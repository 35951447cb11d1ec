// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <map>
#include <string>
#include <utility>

#include "sim/device/opencl.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// The devices of engines that run one after another: each is opened, and its kernels are compiled, once.
class EngineDevices {
 public:
  /// The device that the scenario asks for. Throws InputError (no such device, a work-group too large for it) or
  /// RunError (no OpenCL).
  cl::Device of(const EngineSettings& engine);

 private:
  std::map<std::pair<std::string, int>, cl::Device> opened_;  ///< by name and compute units as the scenario has them
};

}  // namespace reamsim
