// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <string>

#include "render/film/film.h"
#include "render/pictures/run_view.h"
#include "sim/base/error.h"

namespace reamsim {

class RenderThread;

/// Called after each picture: (done, total, file).
using PictureProgress = std::function<void(int, int, const std::string&)>;

/// Makes the pictures of a run from DIR/reamed.vdb (density of the unreamed bone, frame G), DIR/snapshots/ (bricks per
/// picture, tool.stl) and DIR/forces.csv; DIR/scenario.yaml is not read. Writes DIR/frames/NNNNNN[_camera].png for
/// every snapshot and DIR/reamed[_camera].png of the final state without the tool; the first camera has no suffix.
/// Cameras: see render/gl/camera.h. Depending on the settings also DIR/before_after[_camera].png,
/// DIR/contact_sheet.png, DIR/turntable/NNN.png, and films of frames and turntable, DIR/reamed.mp4 and
/// DIR/turntable.mp4 (or .webp, .apng). `report` gets a warning when the requested context is not available and the
/// other one is used, and when a picture of the final state looks empty. `thread` has started to render the same run
/// with the same options. Returns what rendered (OffscreenContext::description()). Throws InputError when a result is
/// missing or damaged or a camera is unknown, RunError when a picture cannot be made or written.
std::string render_pictures(const RunData& run, const PictureOptions& options,
                            const PictureProgress& progress = nullptr, Diagnostics* report = nullptr,
                            RenderThread* thread = nullptr);

}  // namespace reamsim
