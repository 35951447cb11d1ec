// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "cli/sweep.h"

#include <filesystem>
#include <system_error>

#include "sim/base/error.h"
#include "sim/scenario/show.h"
#include "sim/study/uq_design.h"

namespace reamsim {

namespace {

namespace fs = std::filesystem;

[[noreturn]] void refuse(const std::string& dir, const std::string& found) {
  throw InputError({shown_path(dir), 0, 0}, "output folder", found, "choose another with -o");
}

/// Whether a study has begun to simulate in this folder.
bool holds_runs(const std::string& dir) {
  std::error_code error;
  if (!fs::exists(dir + "/study.json", error)) return false;
  if (fs::exists(dir + "/runs.csv", error)) return true;
  const bool none = fs::is_empty(dir + "/runs", error);
  return !error && !none;
}

}  // namespace

void keep_results_of_uq(const SweepOptions& options, const std::string& dir) {
  if (!holds_uq_runs(dir)) return;
  std::error_code error;
  const bool own = fs::equivalent(options.file, dir + "/runs.yaml", error);
  if (own && options.overrides.empty()) return;
  refuse(dir, "holds the results of `reamsim uq`, which this study would replace in part");
}

void keep_results_of_sweep(const std::string& dir) {
  if (holds_uq_runs(dir) || !holds_runs(dir)) return;
  refuse(dir, "holds the results of `reamsim sweep run`, which this analysis would replace in part");
}

}  // namespace reamsim
