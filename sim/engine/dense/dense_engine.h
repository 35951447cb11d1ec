// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>

#include "sim/device/opencl.h"
#include "sim/engine/common/engine.h"

namespace reamsim {

/// The engines with a dense array of voxels (`direct`, `octree`, `implicit`).
std::unique_ptr<Engine> make_dense_engine(const cl::Device& device, const Scenario& scenario, const BoneView& bone,
                                          const Tool& tool);

}  // namespace reamsim
