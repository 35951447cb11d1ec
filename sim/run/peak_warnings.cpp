// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "sim/run/peak_warnings.h"

#include <fmt/core.h>

#include <cmath>

#include "sim/run/feed.h"

namespace reamsim {

namespace {

/// More than teeth cause that come and go within a voxel of travel.
constexpr double kRagged = 0.15;

/// The number with two digits, rounded down, as text.
std::string two_digits_below(double value) {
  const double unit = std::pow(10.0, std::floor(std::log10(value)) - 1);
  return fmt::format("{:.10g}", std::floor(value / unit) * unit);
}

/// The rounding of losses counts where the tool hardly advances in the frame of the peak force.
void warn_of_rounding(const SimulationInput& scene, const RunTotals& totals, Diagnostics& report) {
  const double enough_mm = kFirstLosses * smallest_advance_mm(scene.bone.voxmap->grid.voxel_mm);
  if (totals.peak_advance_mm == 0 || totals.peak_advance_mm >= enough_mm) return;
  report.warn(fmt::format(
      "the tool advances {:.2g} um in the frame of the peak force, near the smallest loss of a voxel: peaks "
      "of single frames are too large, while volume, energy and means are right; set "
      "motion.frame_rate_hz to {} or less",
      1000 * totals.peak_advance_mm,
      two_digits_below(scene.scenario.motion.frame_rate_hz * totals.peak_advance_mm / enough_mm)));
}

void warn_of_edges(const SimulationInput& scene, const RunTotals& totals, Diagnostics& report) {
  const double over_mean = totals.peak_axial_force_n / totals.peak_layer_axial_force_n - 1;
  if (scene.scenario.tool.spin != ToolSpin::resolved || !(over_mean > kRagged)) return;
  report.warn(
      fmt::format("the peak axial force of a single frame is {:.0f} % above the greatest mean over a voxel of "
                  "travel, {:.1f} N: a resolved edge that lies along the voxels cuts a whole row of them at "
                  "once; take forces.peak_layer_axial_force_n, or a smaller bone.voxel_mm",
                  100 * over_mean, totals.peak_layer_axial_force_n));
}

}  // namespace

void warn_of_peaks(const SimulationInput& scene, const RunTotals& totals, Diagnostics& report) {
  if (scene.scenario.cutting.erosion != ErosionMode::exact) return;
  warn_of_rounding(scene, totals, report);
  warn_of_edges(scene, totals, report);
}

}  // namespace reamsim
