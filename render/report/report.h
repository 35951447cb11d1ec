#pragma once

#include "render/pictures/run_view.h"

namespace reamsim {

/// Writes DIR/report.html: one page that holds a whole run and loads nothing from anywhere else. Made from what lies in
/// DIR alone: summary.json, scenario.yaml, forces.csv, reamed.vdb, snapshots/, depth_map.png, segmentation.png and
/// forces.png, the pictures reamed*.png and frames/, and verification.json where somebody put one there; pictures that
/// are missing are left out. The same results give the same bytes. `options`: as the pictures were made. Throws
/// InputError when a result is missing or damaged, RunError when the page cannot be written.
void write_report(const RunData& run, const PictureOptions& options);

}  // namespace reamsim
