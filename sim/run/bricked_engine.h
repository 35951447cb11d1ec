#pragma once

#include <cstddef>
#include <memory>

#include "sim/device/opencl.h"
#include "sim/run/engine.h"

namespace reamsim {

/// The default engine: `bricked` on `info`. Throws InputError when the bone does not fit.
std::unique_ptr<Engine> make_bricked_engine(const cl::DeviceInfo& info, const Scenario& scenario, const Voxmap& voxmap,
                                            const Tool& tool);
/// The same on the device that the scenario names.
std::unique_ptr<Engine> make_bricked_engine(const Scenario& scenario, const Voxmap& voxmap, const Tool& tool);

/// Device memory that make_bricked_engine() would take, bytes.
std::size_t bricked_engine_bytes(const Scenario& scenario, const Voxmap& voxmap, const Tool& tool);

}  // namespace reamsim
