#pragma once

#include <functional>
#include <string>

#include "render/pictures/run_view.h"
#include "sim/base/report.h"

namespace reamsim {

class RenderThread;

/// Called after each picture: (done, total, file).
using PictureProgress = std::function<void(int, int, const std::string&)>;

/// Throws RunError, with what to install, where the settings ask for a film that no ffmpeg can write. For an early
/// check.
void require_film_program(const RenderSettings& settings);

/// Makes the pictures of a run from its results: DIR/reamed.vdb (density of the unreamed bone; frame G in its
/// metadata), DIR/snapshots/ (bricks per picture, tool.stl) and DIR/forces.csv. Writes DIR/frames/NNNNNN[_camera].png
/// for every snapshot, and DIR/reamed[_camera].png without the tool for the last; pictures of the first camera have no
/// suffix. Depending on the settings also DIR/before_after[_camera].png, DIR/contact_sheet.png, DIR/turntable/NNN.png,
/// and films of the frames and the turntable, DIR/reamed.mp4 and DIR/turntable.mp4 (or .webp, .apng). `report`: gets a
/// warning when another context than the requested is used. `thread`: renders the same run with the same options
/// already. Throws InputError when a result is missing or damaged or a camera is unknown, RunError when a picture
/// cannot be made or written.
void render_pictures(const RunData& run, const PictureOptions& options, const PictureProgress& progress = nullptr,
                     Report* report = nullptr, RenderThread* thread = nullptr);

}  // namespace reamsim
