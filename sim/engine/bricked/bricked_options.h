#pragma once

#include <cstddef>
#include <string>

#include "sim/engine/bricked/bricked_state.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// How the kernels over bricks run; the results do not depend on it.
struct BrickedOptions {
  KernelShape shape = KernelShape::cpu;
  std::size_t work_group = 1;
  bool culling = true;  ///< pass over cells that cannot touch; off only to prove that it changes nothing
};

/// What the settings leave open is chosen for the device.
BrickedOptions choose_options(const cl::DeviceInfo& info, const EngineSettings& engine);

/// Work-items that fill the device with a cut: on a CPU few that take many bricks each, on a GPU many groups.
std::size_t cut_items(const cl::DeviceInfo& info, const BrickedOptions& options);

/// Options that the cuts' kernels are compiled with.
std::string cut_defines(const BrickPools& layout, KernelShape shape);

}  // namespace reamsim
