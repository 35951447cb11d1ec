#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "sim/run/engine.h"

namespace reamsim {

/// The OpenCL engine on the device that the scenario names.
std::unique_ptr<Engine> make_device_engine(const Scenario& scenario, const Voxmap& voxmap, const Tool& tool);

/// Puts every fill that differs into the voxmap's bricks. `dense` has an entry per voxel; air is left alone.
void copy_fill(const std::vector<std::uint16_t>& dense, Voxmap& voxmap);

}  // namespace reamsim
