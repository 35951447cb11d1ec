// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "sim/device/opencl.h"
#include "sim/engine/common/engine.h"

namespace reamsim {

/// Buffer sizes of `bricked`, which tests reduce. Results do not depend on them.
struct BrickedLimits {
  std::size_t largest_pool = SIZE_MAX;   ///< bytes of one buffer of bricks
  std::size_t removed_room = 1'000'000;  ///< records in a batch's list of removed voxels; one substep always fits
};

/// The `bricked` engine on `device`. Throws InputError when the bone does not fit.
std::unique_ptr<Engine> make_bricked_engine(const cl::Device& device, const Scenario& scenario, const BoneView& bone,
                                            const Tool& tool, const BrickedLimits& limits = {});

/// Device memory that make_bricked_engine() would take, bytes.
std::size_t bricked_engine_bytes(const Scenario& scenario, const BoneView& bone, const Tool& tool);

}  // namespace reamsim
