// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>

#include "render/pictures/run_data.h"
#include "sim/base/error.h"
#include "sim/scan/segmentation.h"
#include "sim/scene/contact_forecast.h"

// Pictures and meshes of a run that need no OpenGL.

namespace reamsim {

/// Draws DIR/depth_map.csv as DIR/depth_map.png. `depth_max_mm` ends the legend; 0: the greatest depth does. Does
/// nothing when nothing was reamed or the run wrote no map. Throws InputError when a file is damaged, RunError when the
/// picture cannot be written.
void write_depth_picture(const RunData& run, double depth_max_mm);

/// Writes DIR/reamed.glb (depth colours up to `depth_max_mm`; 0: as in the pictures) and DIR/reamed.stl: the closed
/// surface of DIR/reamed.vdb, B, mm. When no bone remains, `report` gets a warning instead. Throws InputError when a
/// result is missing or damaged, RunError when a file cannot be written.
void write_meshes(const RunData& run, double depth_max_mm, Diagnostics& report);

/// Writes DIR/segmentation.png: three planes of the CT with the outline of the segmented bone, to scale, in the
/// radiological convention. Does nothing without planes. Throws RunError when it cannot be written.
void write_segmentation_picture(const std::string& dir, const Segmentation& segmentation);

/// What a picture of a scenario shows before it is run.
struct RunSetup {
  RunInputs inputs;  ///< without a folder: `dir` is empty
  ContactForecast contact;
  double frame_s = 0.001;
  RenderSettings settings;
};

/// Writes bone, reamer and path of a scenario as a PNG of three views. Where the tool touches bone: at the start; and
/// at the greatest depth en face and in a section, with the bone that the swept volume of the tool leaves. Where it
/// never does: from three sides at the smallest distance, with that distance. Replaces a file of this name once the
/// picture is complete. Returns a warning if the requested graphics context is not available; else "". Throws RunError.
std::string write_setup_picture(const std::string& path, const RunSetup& setup);

/// Whether a file begins as such a picture does.
bool is_setup_picture(const std::string& path);

}  // namespace reamsim
