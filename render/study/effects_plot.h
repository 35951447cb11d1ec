// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "sim/study/main_effects.h"

namespace reamsim {

/// Parameters and results of one figure.
inline constexpr std::size_t kMostParametersOfFigure = 6, kMostResultsOfFigure = 8;

/// Writes DIR/effects.csv, a row for each group of runs of each parameter and result: `parameter`, `result`, `level`
/// ("" for intervals), `from`, `to`, `runs`, `mean`, `sd`, `explained`; and draws DIR/effects .png, .svg and .pdf by
/// the script effects.gp: the parameters that explain most, and the first results. `effects` must not be empty. Throws
/// RunError when a file cannot be written, or gnuplot is missing or fails.
void write_main_effects(const std::string& dir, const MainEffects& effects);

}  // namespace reamsim
