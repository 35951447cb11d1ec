// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <vector>

namespace reamsim {

/// Data of a benchmark's figure: times of severe contact by voxmap and shell, and against the VOI.
struct BenchPlot {
  struct Point {
    std::string program;
    int voxmap = 0;  ///< cells along an edge
    int shell = 0;
    double ms = 0;
    std::optional<double> paper_ms;
  };
  struct VoiPoint {
    std::string program;
    double percent = 0;  ///< of the tool's box
    double with_ms = 0;
    double without_ms = 0;
  };

  std::string device;
  std::vector<Point> severe;
  std::vector<VoiPoint> voi;
};

/// Writes bench.gp, bench.png and bench.svg into `dir`. Throws RunError when gnuplot is missing or fails.
void write_bench_plot(const std::string& dir, const BenchPlot& plot);

}  // namespace reamsim
