#pragma once

#include <string>
#include <vector>

namespace reamsim {

/// One of the compared runs.
struct ComparedRun {
  std::string dir;            ///< results folder
  std::string label;          ///< in legends and tables
  double mean_travel_mm = 0;  ///< tool travel over which forces are averaged; 0: single frames
};

/// A number of summary.json in all runs; NaN where missing.
struct ComparedMetric {
  std::string key;  ///< "forces.peak_force_n"
  std::vector<double> values;

  /// Run `i` minus the first one.
  [[nodiscard]] double difference(std::size_t i) const { return values[i] - values[0]; }
  /// As a fraction of the first one; NaN where that is 0.
  [[nodiscard]] double relative(std::size_t i) const;
};

/// All numbers of the runs' summary.json in file order, those of the first run first. Throws InputError: missing,
/// damaged, not the summary of a run.
std::vector<ComparedMetric> compare_summaries(const std::vector<ComparedRun>& runs);

/// Writes DIR/compare.csv with the metrics, and DIR/compare.png, .svg, .pdf and .gp: force, torque and removed volume
/// of every run against time and depth, from DIR/curves.csv. Throws InputError when a forces.csv is missing or damaged,
/// RunError when a file cannot be written or gnuplot fails.
void write_comparison(const std::string& dir, const std::vector<ComparedRun>& runs,
                      const std::vector<ComparedMetric>& metrics);

}  // namespace reamsim
