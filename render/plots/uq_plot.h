// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>
#include <vector>

namespace reamsim {

/// What one input changes of an output.
struct TornadoRow {
  std::string input;
  double low = 0;   ///< mean of the output in the lowest fifth of the input
  double high = 0;  ///< and in the highest
};

/// The peaks of an uncertainty analysis.
struct TornadoPlot {
  std::vector<TornadoRow> rows;  ///< drawn by decreasing effect, the greatest ten
  double mean = 0;               ///< of all samples
};

/// Draws DIR/uq .png, .svg and .pdf by the script uq.gp: bands over time from DIR/uq.csv, and the effects of the
/// inputs. Throws RunError when gnuplot is missing or fails.
void write_uq_plot(const std::string& dir, const TornadoPlot& axial_force, const TornadoPlot& spin_torque);

}  // namespace reamsim
