// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "sim/record/verification.h"
#include "sim/verify/scene.h"

namespace reamsim::verify {

struct Report;
/// Runs a case and reports what it found.
using CaseRun = void(const Setting& setting, Report& out);

/// A scene with a closed-form solution or an invariant.
struct Case {
  const char* id = nullptr;
  CaseRun* run = nullptr;
  double seconds = 1;          ///< of the quick suite on two cores; only their ratios count
  bool of_device = false;      ///< needs an OpenCL device
  bool of_full_suite = false;  ///< not in the quick suite

  [[nodiscard]] bool belongs_to(const Setting& setting) const {
    return !(of_device && setting.device == "serial") && !(of_full_suite && setting.quick);
  }
  /// Throws InputError when there is no such device, RunError, Interrupted.
  [[nodiscard]] CaseFindings findings(const Setting& setting) const;
};

/// All cases, in the order of the report.
const std::vector<Case>& cases();

/// Runs every case that belongs to the setting. Throws as Case::findings().
Findings run_suite(const Setting& setting);

}  // namespace reamsim::verify
