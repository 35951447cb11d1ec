#pragma once

#include <functional>
#include <string>

#include "render/pictures/run_view.h"
#include "sim/base/report.h"

namespace reamsim {

class RenderThread;

/// Called after each picture: (done, total, file).
using PictureProgress = std::function<void(int, int, const std::string&)>;

/// Throws RunError, saying what to install, where the settings want a film and there is no ffmpeg to write it: to be
/// asked before work is put into a run.
void require_film_program(const RenderSettings& settings);

/// Makes the pictures of a run from its results alone: DIR/scenario.yaml is not needed; DIR/reamed.vdb (density of the
/// unreamed bone, and the frame G in its metadata), DIR/snapshots/ (bricks per picture, tool.stl) and DIR/forces.csv
/// are. Writes DIR/frames/NNNNNN[_camera].png for every snapshot and DIR/reamed[_camera].png, without the tool, for the
/// last; the first camera of the settings goes without a suffix. Cameras: see render/gl/camera.h, and
/// the user's own. What else the settings say: DIR/before_after[_camera].png, DIR/contact_sheet.png,
/// DIR/turntable/NNN.png, and films of the frames and the turntable, DIR/reamed.mp4 and DIR/turntable.mp4 (or .webp,
/// .apng). `report`, where given, gets a warning when the requested context is not available and the other one is used.
/// `thread`, where given, has begun to render the same run with the same options while it went on.
/// Throws InputError when a result is missing or damaged or a camera is unknown, RunError when a picture cannot be made
/// or written.
void render_pictures(const RunData& run, const PictureOptions& options, const PictureProgress& progress = nullptr,
                     Report* report = nullptr, RenderThread* thread = nullptr);

}  // namespace reamsim
