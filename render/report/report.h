#pragma once

#include "render/pictures/finished_run.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// Writes DIR/report.html: one page that holds a whole run and loads nothing from anywhere else. Made from what lies in
/// DIR alone: summary.json, scenario.yaml, forces.csv, reamed.vdb, snapshots/, depth_map.png, segmentation.png and
/// forces.png, the pictures reamed*.png and frames/, and verification.json where somebody put one there; pictures that
/// are missing are left out. The same results give the same bytes. `settings` says how the pictures were made;
/// `mean_travel_mm` as for render_pictures(). Throws InputError when a result is missing or damaged, RunError when the
/// page cannot be written.
void write_report(const FinishedRun& run, const RenderSettings& settings, double mean_travel_mm);

}  // namespace reamsim
