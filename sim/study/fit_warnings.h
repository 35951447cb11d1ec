// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/study/fit_forces.h"

namespace reamsim {

/// What shows that a measured column has another sign or unit than forces.csv, which standard errors do not show:
/// columns that the fitted law explains worse than their mean, constants that a scenario would refuse, and specific
/// energies that are far from those of bone. `reference_density_g_cm3`: of u0.
std::vector<std::string> fit_warnings(const ForceFit& fit, double reference_density_g_cm3);

}  // namespace reamsim
