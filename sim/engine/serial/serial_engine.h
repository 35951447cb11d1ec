// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>

#include "sim/engine/common/engine.h"

namespace reamsim {

/// The reference of all engines, in plain C++ without OpenCL.
std::unique_ptr<Engine> make_serial_engine(const Scenario& scenario, const BoneView& bone, const Tool& tool);

}  // namespace reamsim
