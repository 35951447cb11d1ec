// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/engine/common/engine.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// An engine whose batches have the force basis as well (`output.force_basis`). `engine` does everything else, and its
/// results are the same as alone. It must be `exact`, or one that removes touched voxels whole. `tool` and the voxmap
/// must outlive it.
std::unique_ptr<Engine> make_basis_engine(std::unique_ptr<Engine> engine, const Scenario& scenario,
                                          const BoneView& bone, const Tool& tool);

}  // namespace reamsim
