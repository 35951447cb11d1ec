// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>

#include "sim/device/opencl.h"
#include "sim/engine/common/engine.h"
#include "sim/scenario/scenario.h"
#include "sim/tool/tool.h"

namespace reamsim {

// Each engine by itself; make_engine() chooses one.

/// The engines with a dense array of voxels (`direct`, `octree`, `implicit`).
std::unique_ptr<Engine> make_dense_engine(const cl::Device& device, const Scenario& scenario, const BoneView& bone,
                                          const Tool& tool);

/// The reference of all engines, in plain C++ without OpenCL.
std::unique_ptr<Engine> make_serial_engine(const Scenario& scenario, const BoneView& bone, const Tool& tool);

/// An engine whose batches have the force basis as well (`output.force_basis`). `engine` does everything else, and its
/// results are the same as alone. It must be `exact`, or one that removes touched voxels whole. `tool` and the voxmap
/// must outlive it.
std::unique_ptr<Engine> make_basis_engine(std::unique_ptr<Engine> engine, const Scenario& scenario,
                                          const BoneView& bone, const Tool& tool);

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
