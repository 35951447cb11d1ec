#pragma once

#include <functional>
#include <string>

#include "sim/base/report.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// Called after each picture: (done, total, file).
using PictureProgress = std::function<void(int, int, const std::string&)>;

/// Makes the pictures of a run from its results alone: DIR/scenario.yaml is not needed; DIR/reamed.vdb (density of the
/// unreamed bone, and the frame G in its metadata), DIR/snapshots/ (bricks per picture, tool.stl) and DIR/forces.csv are.
/// Writes DIR/frames/NNNNNN[_camera].png for every snapshot and DIR/reamed[_camera].png for the last.
/// Throws InputError when a result is missing or damaged, RunError when a picture cannot be made or written.
void render_pictures(const std::string& dir, const RenderSettings& settings, const PictureProgress& progress);

/// Writes DIR/forces.gp and runs gnuplot on it: DIR/forces.png, DIR/forces.svg from DIR/forces.csv.
/// Throws RunError when gnuplot is missing or fails.
void write_force_plots(const std::string& dir);

}  // namespace reamsim
