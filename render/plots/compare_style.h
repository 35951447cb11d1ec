// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "render/plots/compare.h"

namespace reamsim {

/// How the curves of a comparison look, as arrays for the gnuplot script: `shade` (colour) and `dash` (1 to 4) of each
/// run, the entries of the legend, and the colour ramp if there is one.
std::string curve_styles(const Comparison& comparison);

}  // namespace reamsim
