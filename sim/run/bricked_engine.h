#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "sim/device/opencl.h"
#include "sim/run/engine.h"

namespace reamsim {

/// The default engine: `bricked` on `info`, no buffer of bricks larger than `largest_pool` bytes. Throws InputError when
/// the bone does not fit.
std::unique_ptr<Engine> make_bricked_engine(const cl::DeviceInfo& info, const Scenario& scenario, const Voxmap& voxmap,
                                            const Tool& tool, std::size_t largest_pool = SIZE_MAX);
/// The same on the device that the scenario names.
std::unique_ptr<Engine> make_bricked_engine(const Scenario& scenario, const Voxmap& voxmap, const Tool& tool);

/// Device memory that make_bricked_engine() would take, bytes.
std::size_t bricked_engine_bytes(const Scenario& scenario, const Voxmap& voxmap, const Tool& tool);

}  // namespace reamsim
