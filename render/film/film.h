// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "render/gl/pixel_image.h"
#include "render/pictures/run_view.h"
#include "sim/base/process.h"

namespace reamsim {

/// To be called before a run: throws RunError, with what to install, when no ffmpeg can write the film of the settings.
void require_film_program(const RenderSettings& settings);

/// Pipes pictures to ffmpeg, which writes a film. The file gets its name when it is complete.
class FilmEncoder {
 public:
  /// Odd sizes lose a pixel, because H.264 needs even ones. Throws RunError: no ffmpeg.
  FilmEncoder(const std::string& path, const RenderSettings& settings);
  /// Without finish(): stops ffmpeg and removes its file.
  ~FilmEncoder();
  FilmEncoder(const FilmEncoder&) = delete;
  FilmEncoder& operator=(const FilmEncoder&) = delete;

  /// Adds a frame of the settings' or the film's size. Throws RunError with ffmpeg's message when it has exited.
  void add(const PixelImage& image);
  /// Completes the film and renames it. Throws RunError.
  void finish();

 private:
  /// Waits for ffmpeg. Returns its message if it failed, else "".
  std::string wait();
  [[noreturn]] void fail(const std::string& messages) const;

  int width_px_;
  int height_px_;
  std::string path_;
  std::string partial_path_;
  int pictures_fd_ = -1;  ///< our end of ffmpeg's standard input
  MemoryFile messages_;   ///< stderr of ffmpeg
  pid_t child_ = -1;
};

/// Axial force, spin torque and the feed rate of a push against time: the whole run pale, the past opaque, a cursor.
class ForcePanel {
 public:
  /// Draws the static background. `mean`: prefix of the names of averaged forces. Sizes in pixels; `unit`: pixels per
  /// pixel of a film 1080 high. `log` outlives the panel. Throws RunError.
  ForcePanel(const ForceLog& log, const std::string& mean, int width_px, int height_px, double unit);

  /// The panel at the time of a row of the log. Throws RunError.
  [[nodiscard]] PixelImage at(const ForceRow& row) const;

  /// The plot area of a curve: 0 force, 1 torque, 2 feed rate.
  [[nodiscard]] const Box& plot(int curve) const { return curves_.at(static_cast<std::size_t>(curve)).box; }
  /// Pixels from the panel's left edge.
  [[nodiscard]] double x_of(double time_s) const;

 private:
  struct Curve {
    std::string title, unit;
    double (*value)(const ForceRow&);
    int decimals;
    std::uint32_t rgb;
    Box box;
    double min = 0, max = 1, step = 0.2;  ///< of the axis
    std::vector<double> low{}, high{};    ///< extremes per column of pixels
  };

  void compute_envelope(Curve& curve) const;
  void draw_frame(const class Canvas& canvas, const Curve& curve) const;
  void draw_time_axis(const class Canvas& canvas) const;
  /// Draws the curve up to a column.
  void draw_curve(const class Canvas& canvas, const Curve& curve, std::size_t columns, double opacity) const;
  [[nodiscard]] double y_of(const Curve& curve, double value) const;

  const ForceLog& log_;
  double unit_;
  double first_s_ = 0;
  double last_s_ = 1;
  std::vector<Curve> curves_;
  PixelImage background_;
};

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
  /// `view` and `captions` outlive it. Throws RunError: no ffmpeg.
  Film(const std::string& path, const RunView& view, const Captions& captions, const Camera& camera);

  /// Adds a frame: the bone at this row of the log.
  void add(PixelImage bone, const ForceRow& row);
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
