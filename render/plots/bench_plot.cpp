// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/plots/plots.h"

#include <algorithm>
#include <set>
#include <sstream>

namespace reamsim {
namespace {

/// Okabe and Ito's colours, safe for colour-blind readers.
constexpr const char* kColors[] = {"#009e73", "#0072b2", "#56b4e9", "#d55e00", "#e69f00", "#8c4f86", "#404040"};

std::vector<std::string> programs_of(const BenchPlot& plot) {
  std::vector<std::string> programs;
  for (const auto& point : plot.severe) {
    if (std::find(programs.begin(), programs.end(), point.program) == programs.end()) programs.push_back(point.program);
  }
  return programs;
}

std::string data_of(const BenchPlot& plot) {
  const auto programs = programs_of(plot);
  const auto number = [&](const std::string& program) {
    return std::find(programs.begin(), programs.end(), program) - programs.begin() + 1;
  };
  std::ostringstream out;
  out << "# program, voxmap, shell, ms, the paper's ms\n$severe << END\n";
  std::set<int> voxmaps;
  for (const auto& point : plot.severe) {
    voxmaps.insert(point.voxmap);
    out << number(point.program) << ' ' << point.voxmap << ' ' << point.shell << ' ' << point.ms << ' '
        << (point.paper_ms ? (std::ostringstream() << *point.paper_ms).str() : "NaN") << '\n';
  }
  out << "END\n# program, VOI in % of the tool's box, ms with VOI, ms without\n$voi << END\n";
  for (const auto& point : plot.voi) {
    out << number(point.program) << ' ' << point.percent << ' ' << point.with_ms << ' ' << point.without_ms << '\n';
  }
  if (plot.voi.empty()) out << "0 0 NaN NaN\n";
  out << "END\nprograms = " << programs.size() << "\narray name[" << std::max<std::size_t>(1, programs.size())
      << "]\narray color[" << std::max<std::size_t>(1, programs.size()) << "]\n";
  for (std::size_t i = 0; i < programs.size(); ++i) {
    out << "name[" << i + 1 << "] = " << gnuplot_string(programs[i]) << "\ncolor[" << i + 1 << "] = \""
        << kColors[i % std::size(kColors)] << "\"\n";
  }
  out << "voxmaps = \"";
  for (const int voxmap : voxmaps) out << voxmap << ' ';
  out << "\"\nhas_voi = " << (plot.voi.empty() ? 0 : 1) << "\ndevice = " << gnuplot_string(plot.device) << "\n\n";
  return out.str();
}

}  // namespace

void write_bench_plot(const std::string& dir, const BenchPlot& plot) {
  run_gnuplot(dir, "bench.gp", data_of(plot) + embedded::script_bench, {"bench.png", "bench.svg"});
}

}  // namespace reamsim
