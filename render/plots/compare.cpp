#include "render/plots/compare.h"

#include <algorithm>
#include <cmath>

#include "render/plots/plots.h"
#include "sim/base/csv.h"
#include "sim/base/error.h"
#include "sim/base/file.h"
#include "sim/base/text.h"
#include "sim/record/force_log.h"

namespace reamsim {
namespace embedded {
extern const char* const compare_script;
}
namespace {

std::string number_cell(double value) {
  return std::isfinite(value) ? shortest_text(value) : std::string();
}

std::string metrics_csv(const std::vector<ComparedRun>& runs, const std::vector<ComparedMetric>& metrics) {
  std::string out = "metric,run,value,difference,relative_difference\n";
  for (const ComparedMetric& metric : metrics) {
    for (std::size_t i = 0; i < runs.size(); ++i) {
      out += csv_text(metric.key) + "," + csv_text(runs[i].label) + "," + number_cell(metric.values[i]) + "," +
             number_cell(metric.difference(i)) + "," + number_cell(metric.relative(i)) + "\n";
    }
  }
  return out;
}

/// Least fraction of the greatest force of a frame that counts as contact: a tooth may graze bone on the way out.
constexpr double kMinForceFraction = 0.01;

/// Writes the curves of all runs, decimated.
void write_curves(const std::string& path, const std::vector<ComparedRun>& runs) {
  constexpr std::size_t kMaxPoints = 3000;
  CsvWriter csv(path, "run,time_s,depth_mm,contact,axial_force_n,spin_torque_nmm,removed_mm3");
  for (std::size_t r = 0; r < runs.size(); ++r) {
    const ForceLog log = read_force_log(runs[r].dir + "/forces.csv", {.mean_travel_mm = runs[r].mean_travel_mm});
    double greatest_n = 0;
    for (const ForceRow& row : log.rows) greatest_n = std::max(greatest_n, std::abs(row.layer_axial_force_n));
    const std::size_t step = 1 + log.rows.size() / kMaxPoints;
    for (std::size_t i = 0; i < log.rows.size(); i += step) {
      const ForceRow& row = log.rows[i];
      const RowPoint& middle = row.layer_middle;
      const bool contact = std::abs(row.layer_axial_force_n) > kMinForceFraction * greatest_n;
      csv.row({static_cast<double>(r + 1), middle.time_s, middle.depth_mm, contact ? 1.0 : 0.0, row.layer_axial_force_n,
               row.layer_spin_torque_nmm, middle.removed_mm3});
    }
  }
  csv.close();
}

/// The number of runs and their labels for the script.
std::string labels_block(const std::vector<ComparedRun>& runs) {
  std::string out = "runs = " + std::to_string(runs.size()) + "\narray label[runs] = [";
  for (std::size_t i = 0; i < runs.size(); ++i) out += (i == 0 ? "" : ", ") + gnuplot_string(runs[i].label);
  return out + "]\n\n";
}

}  // namespace

void write_comparison(const std::string& dir, const std::vector<ComparedRun>& runs,
                      const std::vector<ComparedMetric>& metrics) {
  write_curves(dir + "/curves.csv", runs);
  write_file(dir + "/compare.csv", metrics_csv(runs, metrics));
  draw_plot(dir, "compare", labels_block(runs), embedded::compare_script);
}

}  // namespace reamsim
