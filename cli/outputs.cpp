#include "cli/outputs.h"

#include <future>

#include "render/pictures/depth_picture.h"
#include "render/pictures/meshes.h"
#include "render/plots/plots.h"
#include "sim/base/error.h"

namespace reamsim {

namespace {

constexpr const char* kNoSpectrum =
    "no spectrum of the torque: the tool does not spin, or touches bone for less than four turns";

void make_figures(const FinishedRun& run, const Outputs& outputs, Report& report) {
  const std::string& dir = run.dir();
  const double mean_mm = outputs.mean_travel_mm;
  if (outputs.force_plots) {
    write_force_plots(dir, mean_mm);
    write_depth_picture(dir, outputs.settings.depth_max_mm);
  }
  if (outputs.meshes) write_meshes(run, outputs.settings.depth_max_mm, report);
  if (!outputs.all_plots) return;
  write_depth_and_energy_plots(dir, mean_mm);
  write_removed_density(dir);
  if (outputs.torque_spectrum && !write_torque_spectrum(dir)) report.warn(kNoSpectrum);
}

void make_pictures(const FinishedRun& run, const Outputs& outputs, Report& report, const Console& console) {
  Progress progress(console, "render", "pictures");
  const auto tell = [&](int done, int total, const std::string&) {
    progress.update(done, total);
    if (stop_requested()) throw Interrupted();
  };
  const auto& [settings, choice, mean_mm] = std::tie(outputs.settings, outputs.choice, outputs.mean_travel_mm);
  if (outputs.photographer != nullptr) {
    render_pictures(run, settings, mean_mm, tell, &report, choice, *outputs.photographer);
  } else {
    render_pictures(run, settings, mean_mm, tell, &report, choice);
  }
  progress.finish();
}

}  // namespace

void make_outputs(const FinishedRun& run, const Outputs& outputs, Report& report, const Console& console) {
  if (outputs.pictures || outputs.meshes) static_cast<void>(run.results());  // read before two threads ask for it
  Report of_figures;
  std::future<void> figures = std::async(std::launch::async, [&] { make_figures(run, outputs, of_figures); });
  if (outputs.pictures) make_pictures(run, outputs, report, console);
  figures.get();
  report.warnings.insert(report.warnings.end(), of_figures.warnings.begin(), of_figures.warnings.end());
}

}  // namespace reamsim
