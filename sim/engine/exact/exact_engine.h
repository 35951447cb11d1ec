// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <memory>

#include "sim/device/opencl.h"
#include "sim/engine/common/engine.h"

namespace reamsim {

/// Bounds of what a run does to the bone's bricks.
struct ExactForecast {
  std::size_t partial = 0;  ///< bricks that are partly removed or that the tool reaches: a page of fill each
  std::size_t listed = 0;   ///< bricks that the tool's surface can intersect in one visit
};

/// `erosion: exact` over bricks. Throws InputError when the bone does not fit.
std::unique_ptr<Engine> make_exact_engine(const cl::Device& device, const Scenario& scenario, const BoneView& bone,
                                          const Tool& tool);

/// Bound of the engine's device memory, bytes.
std::size_t exact_engine_bytes(const BoneView& bone, const Tool& tool, const ExactForecast& forecast);

}  // namespace reamsim
