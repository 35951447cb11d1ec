// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace reamsim::verify {

/// How a figure is compared with its expected value.
enum class Measure {
  relative,  ///< error = found/expected − 1, at most ±`tolerance`
  absolute,  ///< error = found − expected, in the unit, at most ±`tolerance`
  at_least,  ///< found ≥ expected, which is a limit and not a closed form
  at_most,   ///< found ≤ expected, likewise
  reported,  ///< for the record; never fails
};

/// One figure of a case. NaN never passes.
struct Check {
  std::string quantity;
  std::string unit;
  Measure measure = Measure::relative;
  double expected = 0;   ///< closed form or limit
  double found = 0;      ///< result of the program
  double tolerance = 0;  ///< of a relative or an absolute error
  std::string reason;    ///< for this tolerance or limit

  [[nodiscard]] double error() const { return measure == Measure::relative ? found / expected - 1 : found - expected; }
  [[nodiscard]] bool passed() const {
    if (measure == Measure::at_least) return found >= expected;
    if (measure == Measure::at_most) return found <= expected;
    if (measure == Measure::reported) return !std::isnan(found);
    return std::abs(error()) <= tolerance;
  }
};

/// One step of a refinement.
struct Level {
  double step = 0;                   ///< voxel size (mm) or frame time (s)
  double found = 0;                  ///< mean over the level's runs, in the quantity's unit
  std::optional<double> error = {};  ///< relative to the closed form; of several runs the root mean square
  int runs = 1;
};

/// Roache's grid convergence index (1994, J. Fluids Eng. 116:405): a band about the value of the finest level that
/// should contain the value at step zero.
struct GridIndex {
  double fraction = 0;          ///< of the finest value
  double safety_factor = 0;     ///< 1.25 where three levels converge monotonically, else 3
  std::optional<double> order;  ///< observed from three levels, without the closed form; none where not monotonic
};

/// A quantity under refinement, coarsest level first; each step is half of the previous one.
struct Refinement {
  std::string quantity;
  std::string unit;
  std::string step;                ///< name and unit of the step: "voxel, mm"
  std::optional<double> expected;  ///< none where there is no closed form
  std::vector<Level> levels = {};
  std::optional<double> order = {};  ///< of the error against the closed form; none without one or below rounding
  GridIndex index = {};
};

struct CaseFindings {
  std::string id;
  std::string title;
  std::string scene;  ///< what is reamed, and how
  std::string form;   ///< the closed form, or the invariant
  std::vector<Refinement> refinements;
  std::vector<Check> checks;
  double seconds = 0;

  [[nodiscard]] auto failed_checks() const { return std::ranges::count(checks, false, &Check::passed); }
  [[nodiscard]] bool passed() const { return failed_checks() == 0; }
};

/// Names and values of what the device has; the first is its name.
using Capabilities = std::vector<std::pair<std::string, std::string>>;

struct Findings {
  bool quick = false;
  Capabilities capabilities;
  std::vector<CaseFindings> cases;         ///< of the program's equations
  std::vector<CaseFindings> device_cases;  ///< of the device; none of serial
  double seconds = 0;

  [[nodiscard]] std::string device() const { return capabilities.empty() ? "" : capabilities.front().second; }
  /// Those of the program, then those of the device.
  [[nodiscard]] std::vector<CaseFindings> all_cases() const {
    std::vector<CaseFindings> all = cases;
    all.insert(all.end(), device_cases.begin(), device_cases.end());
    return all;
  }
  [[nodiscard]] int failed_checks() const {
    int failed = 0;
    for (const CaseFindings& row : all_cases()) failed += static_cast<int>(row.failed_checks());
    return failed;
  }
  [[nodiscard]] bool passed() const { return failed_checks() == 0; }
};

}  // namespace reamsim::verify
