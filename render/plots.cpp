#include <sstream>
#include <string>

#include "render/force_log.h"
#include "render/gnuplot.h"
#include "render/render.h"

namespace reamsim {

namespace embedded {
extern const char* const plot_script;
}

namespace {

/// A gnuplot data block with the means over a voxel of travel, thinned to what a plot can show.
std::string mean_block(const ForceLog& log, double travel_mm) {
  constexpr std::size_t kMostPoints = 2000;
  const std::size_t step = 1 + log.rows.size() / kMostPoints;
  std::ostringstream out;
  out << "# Means over the last " << travel_mm
      << " mm of travel (0: every frame for itself): time (s), axial force (N), spin torque (N·mm)\n"
      << "travel_mm = " << travel_mm << "\n$mean << END\n";
  for (std::size_t i = 0; i < log.rows.size(); i += step) {
    const ForceRow& row = log.rows[i];
    // A mean stands in the middle of the frames that it is over.
    const double middle_s = log.rows[i - row.layer_frames / 2].time_s;
    out << middle_s << ',' << row.layer_axial_force_n << ',' << row.layer_spin_torque_nmm << '\n';
  }
  out << "END\n\n";
  return out.str();
}

}  // namespace

double averaged_travel_mm(const CuttingSettings& cutting, double voxel_mm) {
  return cutting.erosion == "exact" ? 0 : voxel_mm;
}

void write_force_plots(const std::string& dir, double mean_travel_mm) {
  ForceLog log = read_force_log(dir + "/forces.csv");
  add_layer_means(log, mean_travel_mm);
  run_gnuplot(dir, "forces.gp", mean_block(log, mean_travel_mm) + embedded::plot_script, {"forces.png", "forces.svg"});
}

}  // namespace reamsim
