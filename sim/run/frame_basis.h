// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "sim/engine/common/force_basis.h"
#include "sim/record/results.h"
#include "sim/run/energy_balance.h"

namespace reamsim {

/// The rows of force_basis.npy of a frame, ascending grades: means of force and torque over the substeps, sums of work
/// and energies, as EnergyBalance::close() has them. `substeps`: of the batch.
std::vector<BasisRow> basis_rows(const PendingFrame& frame, const std::vector<SubstepBasis>& substeps);

}  // namespace reamsim
