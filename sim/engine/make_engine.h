// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>

#include "sim/device/opencl.h"
#include "sim/engine/common/engines.h"
#include "sim/scenario/scenario.h"
#include "sim/tool/tool.h"

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

/// The engine that the scenario asks for. Throws InputError (no such device, bone too large) or RunError (no OpenCL, a
/// kernel that does not build). `devices`: opened before, or to be opened for later engines as well.
std::unique_ptr<Engine> make_engine_on(EngineDevices& devices, const Scenario& scenario, const BoneView& bone,
                                       const Tool& tool);
/// The same on a device of its own.
std::unique_ptr<Engine> make_engine(const Scenario& scenario, const BoneView& bone, const Tool& tool);

}  // namespace reamsim
