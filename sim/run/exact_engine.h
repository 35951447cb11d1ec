#pragma once

#include <cstddef>
#include <memory>

#include "sim/device/opencl.h"
#include "sim/run/engine.h"

namespace reamsim {

/// `erosion: exact` over bricks, on the device that the scenario names. Throws InputError when the bone does not fit.
std::unique_ptr<Engine> make_exact_engine(const Scenario& scenario, const Voxmap& voxmap, const Tool& tool);

/// Device memory that make_exact_engine() would take at first, bytes; cut bricks take 1 KiB more each.
std::size_t exact_engine_bytes(const Scenario& scenario, const Voxmap& voxmap, const Tool& tool);

}  // namespace reamsim
