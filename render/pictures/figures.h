// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "render/pictures/run_view.h"
#include "sim/base/error.h"
#include "sim/scan/segmentation.h"
#include "sim/scene/contact_forecast.h"

// Pictures and meshes of a run that need no OpenGL.

namespace reamsim {

/// Draws DIR/depth_map.csv as DIR/depth_map.png, if there is a map with reamed columns. `depth_max_mm` ends the legend;
/// 0: the greatest depth does. Throws InputError (damaged file), RunError (picture cannot be written).
void write_depth_picture(const RunData& run, double depth_max_mm);

/// Writes DIR/reamed.glb (depth colours up to `depth_max_mm`; 0: as in the pictures) and DIR/reamed.stl: the closed
/// surface of DIR/reamed.vdb, B, mm; or warns that no bone remains. Throws InputError (damaged result), RunError.
void write_meshes(const RunData& run, double depth_max_mm, Diagnostics& report);

/// Writes DIR/segmentation.png, if there are planes: the CT with the outline of the bone, to scale. Throws RunError.
void write_segmentation_picture(const std::string& dir, const Segmentation& segmentation);

/// What a picture of a scenario shows before it is run.
struct RunSetup {
  RunInputs inputs;  ///< without a folder: `dir` is empty
  ContactForecast contact;
  double frame_s = 0.001;
  RenderSettings settings;
};

/// Writes a PNG of bone, reamer and path: at the start, and the predicted bone at the greatest depth en face and in a
/// section; without contact three sides at the smallest distance. Returns Renderer::warning(). Throws RunError.
std::string write_setup_picture(const std::string& path, const RunSetup& setup);

/// Whether a file begins as such a picture does.
bool is_setup_picture(const std::string& path);

}  // namespace reamsim
