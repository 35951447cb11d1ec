// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>

#include "sim/engine/common/engine.h"
#include "sim/engine/common/engine_device.h"

namespace reamsim {

/// The engine that the scenario asks for. Throws InputError (no such device, bone too large) or RunError (no OpenCL, a
/// kernel that does not build). `devices`: opened before, or to be opened for later engines as well.
std::unique_ptr<Engine> make_engine_on(EngineDevices& devices, const Scenario& scenario, const BoneView& bone,
                                       const Tool& tool);
/// The same on a device of its own.
std::unique_ptr<Engine> make_engine(const Scenario& scenario, const BoneView& bone, const Tool& tool);

}  // namespace reamsim
