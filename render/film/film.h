#pragma once

#include <memory>
#include <string>

#include "render/film/encoder.h"
#include "render/film/force_panel.h"
#include "render/pictures/captions.h"
#include "render/pictures/run_view.h"

namespace reamsim {

/// How a film's picture is parted: the bone, and the force plots beside it, or below it where the film stands upright.
struct FilmLayout {
  int width_px, height_px;  ///< of the film; even, as H.264 wants them
  Box bone, panel;          ///< whole pixels; panel.width is 0 where a plot could not be read
  double unit;              ///< pixels per pixel of a film 1080 high
};
FilmLayout film_layout(int width_px, int height_px);
/// The camera called `name`, for the bone's part of the film.
Camera film_camera(const RunView& view, const std::string& name);

/// The film of a run: a frame per snapshot, with force and torque running beside the bone.
class Film {
 public:
  /// Starts `path`, of the settings' size, rate and format, seen by `camera`. Throws RunError: no ffmpeg. `view` and
  /// `captions` outlive it.
  Film(const std::string& path, const RunView& view, const Captions& captions, const Camera& camera);

  /// The next frame: the bone at this row of the log.
  void add(PixelImage bone, const ForceRow& row);
  /// Puts the file in place.
  void finish();

 private:
  const RunView& view_;
  const Captions& captions_;
  FilmLayout layout_;
  Camera camera_;
  std::string widest_value_;
  std::unique_ptr<ForcePanel> panel_;  ///< none where it could not be read
  FilmEncoder encoder_;
};

}  // namespace reamsim
