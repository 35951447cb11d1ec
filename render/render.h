#pragma once

#include <functional>
#include <string>
#include <vector>

#include "render/finished_run.h"
#include "sim/base/report.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

class Photographer;

/// Called after each picture: (done, total, file).
using PictureProgress = std::function<void(int, int, const std::string&)>;

/// Over how much of the tool's travel forces are averaged before they are shown, mm: a voxel, because voxels that go
/// whole make spikes of single frames; nothing where they are clipped, because a mean would only smear contact's ends.
double averaged_travel_mm(const CuttingSettings& cutting, double voxel_mm);

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
/// last; the first camera of the settings goes without a suffix. Cameras: see camera_names() in render/camera.h, and
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

/// Draws DIR/forces.csv with gnuplot: DIR/forces (against time), DIR/plots/forces_depth and DIR/plots/energy, each as
/// .png, .svg, .pdf and the script .gp. `mean_travel_mm` is the travel over which the means are taken that stand before
/// the single frames; 0: the frames alone.
/// Throws InputError when forces.csv is missing or damaged, RunError when gnuplot is missing or fails (with its words).
void write_force_plots(const std::string& dir, double mean_travel_mm);

/// Draws DIR/depth_map.csv as DIR/depth_map.png, with the directions that DIR/reamed.vdb knows. `depth_max_mm` ends the
/// legend; 0: the greatest depth does. No picture when nothing was reamed, or the run wrote no map.
/// Throws InputError when a file is damaged, RunError when the picture cannot be written.
void write_depth_picture(const std::string& dir, double depth_max_mm);

}  // namespace reamsim
