// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/study/fit_forces.h"

namespace reamsim {

/// What shows that a measured column has another sign or unit than forces.csv, which standard errors do not show:
/// columns that the fitted law explains worse than their mean, and constants that a scenario would refuse.
std::vector<std::string> fit_warnings(const ForceFit& fit);

}  // namespace reamsim
