// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

#include "sim/study/main_effects.h"

namespace reamsim {

/// The lines of a study's table on the terminal, none wider than `width` characters: of up to twenty runs a row for
/// each, of more the means and standard deviations of the results by level of the parameters that explain most. Empty
/// where no run is done.
std::vector<std::string> study_table(const RunTable& table, const MainEffects& effects, std::size_t width);

}  // namespace reamsim
