// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <string>

#include "render/gl/pixel_image.h"
#include "sim/base/process.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// The file extension of this format: ".mp4", ".webp", ".apng".
std::string film_extension(FilmFormat format);

/// Rounds down to an even number, at least 2.
int even_px(int px);

/// Throws RunError, with what to install, when no ffmpeg can write this format.
void require_encoder(FilmFormat format);

/// Pipes pictures to ffmpeg, which writes a film. The file gets its name when it is complete.
class FilmEncoder {
 public:
  /// Format, rate and size are the settings'; odd sizes lose a pixel, because H.264 needs even ones. `path` has the
  /// film_extension(). Throws RunError: no ffmpeg.
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

}  // namespace reamsim
