#pragma once

#include "sim/device/opencl.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// The device that the scenario asks for. Throws InputError (no such device, a work-group too large for it) or RunError
/// (no OpenCL).
cl::DeviceInfo device_for(const EngineSettings& engine);

}  // namespace reamsim
