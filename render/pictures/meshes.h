#pragma once

#include "render/pictures/run_data.h"
#include "sim/base/report.h"

namespace reamsim {

/// Writes DIR/reamed.glb (with depth colours that end at `depth_max_mm`; 0: where those of the pictures do)
/// and DIR/reamed.stl: the surface of DIR/reamed.vdb, closed, B, mm. Where no bone is left neither is written, and
/// `report` gets a warning. Throws InputError when a result is missing or damaged, RunError when a file cannot be
/// written.
void write_meshes(const RunData& run, double depth_max_mm, Report& report);

}  // namespace reamsim
