#pragma once

#include <memory>

#include "sim/engine/common/engine.h"

namespace reamsim {

/// The reference of every detector in plain C++; it starts no OpenCL.
std::unique_ptr<Engine> make_serial_engine(const Scenario& scenario, const BoneView& bone, const Tool& tool);

}  // namespace reamsim
