#pragma once

#include <functional>
#include <string>
#include <vector>

#include "render/pictures/finished_run.h"
#include "sim/base/report.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

class Photographer;

/// Called after each picture: (done, total, file).
using PictureProgress = std::function<void(int, int, const std::string&)>;

/// Throws RunError, saying what to install, where the settings want a film and there is no ffmpeg to write it: to be
/// asked before work is put into a run.
void require_film_program(const RenderSettings& settings);

/// Which of the pictures are made.
struct PictureChoice {
  bool film = true;            ///< of the run, where the settings want films; the turntable's goes by its pictures
  bool stills = true;          ///< reamed.png and frames/; what else there is, the settings say
  std::string plain_camera{};  ///< the camera whose files have no suffix; "": the first of the settings
};

/// Makes the pictures of a run from its results alone: DIR/scenario.yaml is not needed; DIR/reamed.vdb (density of the
/// unreamed bone, and the frame G in its metadata), DIR/snapshots/ (bricks per picture, tool.stl) and DIR/forces.csv
/// are. Writes DIR/frames/NNNNNN[_camera].png for every snapshot and DIR/reamed[_camera].png, without the tool, for the
/// last; the first camera of the settings goes without a suffix. Cameras: see render/gl/camera.h, and
/// the user's own. What else the settings say: DIR/before_after[_camera].png, DIR/contact_sheet.png,
/// DIR/turntable/NNN.png, and films of the frames and the turntable, DIR/reamed.mp4 and DIR/turntable.mp4 (or .webp,
/// .apng). `mean_travel_mm`: forces that pictures name are means over so much of the tool's travel; 0: single frames.
/// `report`, where given, gets a warning when the wanted context was not to be had and the other one was used.
/// Throws InputError when a result is missing or damaged or a camera is unknown, RunError when a picture cannot be made
/// or written.
void render_pictures(const FinishedRun& run, const RenderSettings& settings, double mean_travel_mm,
                     const PictureProgress& progress, Report* report = nullptr, const PictureChoice& choice = {});
/// The same, with photographs that were begun with the same settings and choice while the run went on.
void render_pictures(const FinishedRun& run, const RenderSettings& settings, double mean_travel_mm,
                     const PictureProgress& progress, Report* report, const PictureChoice& choice,
                     Photographer& photographer);

}  // namespace reamsim
