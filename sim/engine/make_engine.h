// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>

#include "sim/device/opencl.h"
#include "sim/engine/common/engine.h"
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

/// The engines with a dense array of voxels (`direct`, `octree`, `implicit`).
std::unique_ptr<Engine> make_dense_engine(const cl::Device& device, const Scenario& scenario, const BoneView& bone,
                                          const Tool& tool);

/// The reference of all engines, in plain C++ without OpenCL.
std::unique_ptr<Engine> make_serial_engine(const Scenario& scenario, const BoneView& bone, const Tool& tool);

/// An engine whose batches have the force basis as well (`output.force_basis`). `engine` does everything else, and its
/// results are the same as alone. It must be `exact`, or one that removes touched voxels whole. `tool` and the voxmap
/// must outlive it.
std::unique_ptr<Engine> make_basis_engine(std::unique_ptr<Engine> engine, const Scenario& scenario,
                                          const BoneView& bone, const Tool& tool);

}  // namespace reamsim
