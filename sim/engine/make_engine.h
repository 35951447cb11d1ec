#pragma once

#include <memory>

#include "sim/engine/common/engine.h"

namespace reamsim {

/// The engine that the scenario asks for. Throws InputError (no such device, bone too large) or RunError (no OpenCL, a
/// kernel that does not build).
std::unique_ptr<Engine> make_engine(const Scenario& scenario, const BoneView& bone, const Tool& tool);

}  // namespace reamsim
