// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>

#include "render/pictures/run_data.h"
#include "sim/scene/contact_forecast.h"

namespace reamsim {

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
