#pragma once

#include <memory>

#include "sim/engine/common/engine.h"

namespace reamsim {

/// The OpenCL engine that keeps the bone in a dense array, on the device that the scenario names.
std::unique_ptr<Engine> make_dense_engine(const Scenario& scenario, const BoneView& bone, const Tool& tool);

}  // namespace reamsim
