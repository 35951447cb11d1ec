#pragma once

#include <string>
#include <vector>

namespace reamsim {

/// One of the runs that are held against each other.
struct ComparedRun {
  std::string dir;            ///< its results
  std::string label;          ///< in legends and tables
  double mean_travel_mm = 0;  ///< forces are means over so much of the tool's travel; 0: single frames
};

/// A number of summary.json in every run; NaN where a run has none.
struct ComparedMetric {
  std::string key;  ///< "forces.peak_force_n"
  std::vector<double> values;

  /// Of run `i` from the first one.
  [[nodiscard]] double difference(std::size_t i) const { return values[i] - values[0]; }
  /// As a share of the first one; NaN where that is 0.
  [[nodiscard]] double relative(std::size_t i) const;
};

/// Every number in the runs' summary.json, in the order in which they stand there; those of the first run first.
/// Throws InputError: missing, damaged, not the summary of a run.
std::vector<ComparedMetric> compare_summaries(const std::vector<ComparedRun>& runs);

/// Writes DIR/compare.csv with the metrics, and DIR/compare.png, .svg, .pdf and .gp: force, torque and removed volume
/// of every run against time and depth, from DIR/curves.csv. Throws InputError when a forces.csv is missing or damaged,
/// RunError when a file cannot be written or gnuplot fails.
void write_comparison(const std::string& dir, const std::vector<ComparedRun>& runs,
                      const std::vector<ComparedMetric>& metrics);

}  // namespace reamsim
