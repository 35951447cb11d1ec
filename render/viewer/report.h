// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "render/pictures/run_view.h"

namespace reamsim {

/// Writes DIR/report.html: a self-contained page of a run. Reads from DIR summary.json, scenario.yaml, forces.csv,
/// reamed.vdb and snapshots/, and where present reamed*.png, frames/, depth_map.png, segmentation.png, forces.png and
/// verification.json. Deterministic. `options`: those of the pictures. Throws InputError when a result is missing or
/// damaged, RunError when the page cannot be written.
void write_report(const RunData& run, const PictureOptions& options);

}  // namespace reamsim
