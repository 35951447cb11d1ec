// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>
#include <string>

#include "render/film/encoder.h"
#include "render/film/force_panel.h"
#include "render/pictures/captions.h"
#include "render/pictures/run_view.h"

namespace reamsim {

/// The layout of a film: the bone, with the force panel beside it, or below it in portrait format.
struct FilmLayout {
  int width_px, height_px;  ///< of the film; even, for H.264
  Box bone, panel;          ///< whole pixels; panel.width is 0 if a plot would be illegible
  double unit;              ///< pixels per pixel of a film 1080 high
};
FilmLayout film_layout(int width_px, int height_px);
/// The camera `name` for the bone's part of the film.
Camera film_camera(const RunView& view, const std::string& name);

/// The film of a run: one frame per snapshot, with force and torque beside the bone.
class Film {
 public:
  /// Starts the film `path` with the settings' size, rate and format. Throws RunError: no ffmpeg. `view` and `captions`
  /// outlive it.
  Film(const std::string& path, const RunView& view, const Captions& captions, const Camera& camera);

  /// Adds a frame: the bone at this row of the log.
  void add(PixelImage bone, const ForceRow& row);
  /// Completes the file.
  void finish() { encoder_.finish(); }

 private:
  const RunView& view_;
  const Captions& captions_;
  FilmLayout layout_;
  Camera camera_;
  std::unique_ptr<ForcePanel> panel_;  ///< null if it would be illegible
  FilmEncoder encoder_;
};

}  // namespace reamsim
