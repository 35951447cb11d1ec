#pragma once

#include <string>

#include "render/gl/pixel_image.h"
#include "sim/base/process.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// What a file of this format ends in: ".mp4", ".webp", ".apng".
std::string film_ending(FilmFormat format);

/// The largest even number up to this, and at least 2.
int even_px(int px);

/// Throws RunError, saying what to install, when there is no ffmpeg that can write this format.
void require_encoder(FilmFormat format);

/// Pipes pictures to ffmpeg, which writes them as a film. The file appears under its name when it is complete.
class FilmEncoder {
 public:
  /// Of the settings' format, rate and size, less a pixel where that is odd, because H.264 wants it even. `path` ends
  /// as film_ending() says. Throws RunError: no ffmpeg.
  FilmEncoder(const std::string& path, const RenderSettings& settings);
  /// Without finish(): stops ffmpeg, and takes away what it wrote.
  ~FilmEncoder();
  FilmEncoder(const FilmEncoder&) = delete;
  FilmEncoder& operator=(const FilmEncoder&) = delete;

  /// The next frame, a picture of the settings' size or the film's. Throws RunError with ffmpeg's words when it has
  /// ended.
  void add(const PixelImage& image);
  /// Ends the film and puts it in place. Throws RunError.
  void finish();

 private:
  /// Waits for ffmpeg. Returns what it said if it failed, "" if not.
  std::string wait();
  [[noreturn]] void fail(const std::string& words) const;

  int width_px_;
  int height_px_;
  std::string path_;
  std::string partial_path_;
  int pictures_fd_ = -1;  ///< our end of ffmpeg's standard input
  MemoryFile output_;
  pid_t child_ = -1;
};

}  // namespace reamsim
