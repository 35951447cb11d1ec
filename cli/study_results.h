// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

namespace reamsim {

struct SweepOptions;

// `sweep run`, `sweep collect` and `uq` write tables and pages of the same names into the folder of a study. Where one
// replaced those of the other, the rest of the folder would contradict them.

/// Throws InputError where `dir` holds an analysis of `uq`, unless the study is that of its own runs (runs.yaml).
void keep_results_of_uq(const SweepOptions& options, const std::string& dir);

/// Throws InputError where `dir` holds runs of a study that is no analysis of `uq`.
void keep_results_of_sweep(const std::string& dir);

}  // namespace reamsim
