#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "sim/device/opencl.h"
#include "sim/engine/common/engine.h"

namespace reamsim {

/// Bounds on buffers of `bricked`, which tests make small. Results do not depend on them.
struct BrickedLimits {
  std::size_t largest_pool = SIZE_MAX;   ///< bytes of one buffer of bricks
  std::size_t removed_room = 1'000'000;  ///< records of removed voxels that the list of a batch holds; at least what
                                         ///< one substep can make
};

/// The default engine: `bricked` on `info`. Throws InputError when the bone does not fit.
std::unique_ptr<Engine> make_bricked_engine(const cl::DeviceInfo& info, const Scenario& scenario, const BoneView& bone,
                                            const Tool& tool, const BrickedLimits& limits = {});
/// The same on the device that the scenario names.
std::unique_ptr<Engine> make_bricked_engine(const Scenario& scenario, const BoneView& bone, const Tool& tool);

/// Device memory that make_bricked_engine() would take, bytes.
std::size_t bricked_engine_bytes(const Scenario& scenario, const BoneView& bone, const Tool& tool);

}  // namespace reamsim
