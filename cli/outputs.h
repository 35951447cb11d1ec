#pragma once

#include "cli/console.h"
#include "render/photographer.h"
#include "render/pictures/finished_run.h"
#include "render/plots/plots.h"
#include "render/render.h"

namespace reamsim {

/// What is to be made of a finished run.
struct Outputs {
  RenderSettings settings;
  PictureChoice choice{};
  double mean_travel_mm = 0;  ///< over which shown forces are means; see averaged_travel_mm()
  bool pictures = true;       ///< those of `settings` and `choice`
  bool force_plots = true;    ///< the forces against time, and the depth map
  bool all_plots = true;      ///< forces over depth, energy, density of what was removed
  bool torque_spectrum = true;
  bool meshes = true;
  Photographer* photographer = nullptr;  ///< who has begun with the pictures, if anybody has
};

/// Makes them, with progress on the console. Plots and meshes are made beside the pictures, on a thread of their own:
/// they keep one core busy, and drawing leaves one idle between its frames. `report` gets what all of them warn of.
/// Throws InputError when a result is missing or damaged, RunError when something cannot be made or written, and
/// Interrupted; always after both threads have ended.
void make_outputs(const FinishedRun& run, const Outputs& outputs, Report& report, const Console& console);

}  // namespace reamsim
