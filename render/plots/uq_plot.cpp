// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/plots/uq_plot.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>

#include "render/plots/plots.h"

namespace reamsim {
namespace embedded {
extern const char* const uq_plot_script;
}
namespace {

constexpr std::size_t kMostInputs = 10;

/// The rows as a data block of gnuplot.
std::string block_of(const std::string& name, TornadoPlot& plot) {
  const auto effect = [](const TornadoRow& row) { return -std::abs(row.high - row.low); };
  std::ranges::stable_sort(plot.rows, {}, effect);
  plot.rows.resize(std::min(plot.rows.size(), kMostInputs));
  std::string out = "$" + name + " << END\n";
  for (std::size_t i = 0; i < plot.rows.size(); ++i) {
    const TornadoRow& row = plot.rows[i];
    out += fmt::format("{},{},{},\"{}\"\n", i + 1, row.low, row.high, row.input);
  }
  return out + "END\n";
}

/// The length of the axis.
double span_of(const TornadoPlot& plot) {
  double least = plot.mean, most = plot.mean;
  for (const TornadoRow& row : plot.rows) {
    least = std::min({least, row.low, row.high});
    most = std::max({most, row.low, row.high});
  }
  return most - least;
}

}  // namespace

void write_uq_plot(const std::string& dir, const TornadoPlot& axial_force, const TornadoPlot& spin_torque) {
  TornadoPlot axial = axial_force, torque = spin_torque;
  std::string data = block_of("axial", axial) + block_of("torque", torque);
  data += fmt::format("array rows[2] = [{}, {}]\narray mean_of[2] = [{}, {}]\narray span_of[2] = [{}, {}]\n",
                      axial.rows.size(), torque.rows.size(), axial.mean, torque.mean, span_of(axial), span_of(torque));
  draw_plot(dir, "uq", data, embedded::uq_plot_script);
}

}  // namespace reamsim
