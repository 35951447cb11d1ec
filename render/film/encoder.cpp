// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/film/film.h"

#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>

#include "sim/base/error.h"
#include "sim/base/text.h"

namespace reamsim {
namespace {

void close_fd(int& fd) {
  if (fd >= 0) close(fd);
  fd = -1;
}

/// Starts ffmpeg, which reads `in` and prints to `output`. Returns 0 or an error number.
int start_ffmpeg(std::vector<std::string> arguments, int in, const MemoryFile& output, pid_t& child) {
  arguments.insert(arguments.begin(), {"ffmpeg", "-hide_banner", "-loglevel", "error"});
  return spawn({.arguments = std::move(arguments),
                .dir = "",
                .in = in,
                .out = output.descriptor(),
                .err = output.descriptor(),
                .own_group = true},
               child);
}

std::string encoder_options(FilmFormat format, int frames_per_s) {
  if (format == FilmFormat::webp) return "-c:v libwebp_anim -quality 85 -compression_level 3 -loop 0 -f webp";
  if (format == FilmFormat::apng) return "-pix_fmt rgb24 -c:v apng -pred mixed -plays 0 -f apng";
  // A fixed number of threads makes the file reproducible. One key frame per second makes seeking fast. Without a
  // colour matrix, players guess it from the size.
  return "-vf scale=out_color_matrix=bt709:out_range=tv,format=yuv420p -c:v libx264 -preset medium -crf 18 -g " +
         std::to_string(frames_per_s) +
         " -threads 4 -color_range tv -colorspace bt709 -color_primaries bt709 -color_trc bt709 -movflags +faststart"
         " -f mp4";
}

}  // namespace

int even_px(int px) {
  return std::max(2, px / 2 * 2);
}

void require_film_program(const RenderSettings& settings) {
  const FilmFormat format = settings.film;
  if (!settings.enabled || format == FilmFormat::none) return;
  const MemoryFile output("the messages of ffmpeg");
  pid_t child = 0;
  const int error = start_ffmpeg({"-encoders"}, -1, output, child);
  if (error != 0) {
    throw RunError(std::string("a film needs ffmpeg, which cannot start (") + std::strerror(error) +
                   "): install it (apt-get install ffmpeg), or remove render.film and --film");
  }
  wait_for(child);
  const std::string encoder = format == FilmFormat::mp4    ? "libx264"
                              : format == FilmFormat::webp ? "libwebp_anim"
                                                           : "apng";
  if (output.contents().find(" " + encoder + " ") == std::string::npos) {
    throw RunError("the ffmpeg on this machine cannot write " + name_of(format) + ", because it has no encoder " +
                   encoder + ": install another ffmpeg, or choose another render.film");
  }
}

FilmEncoder::FilmEncoder(const std::string& path, const RenderSettings& settings)
    : width_px_(even_px(settings.width_px)),
      height_px_(even_px(settings.height_px)),
      path_(path),
      partial_path_(path + ".partial"),
      messages_("the messages of ffmpeg") {
  int ends[2];
  // A socket, because MSG_NOSIGNAL suppresses SIGPIPE when ffmpeg has exited.
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0) {
    throw RunError(std::string("no pipe to ffmpeg: ") + std::strerror(errno));
  }
  pictures_fd_ = ends[0];
  std::vector<std::string> options = split(
      "-f rawvideo -pixel_format bgr0 -video_size " + std::to_string(width_px_) + "x" + std::to_string(height_px_) +
          " -framerate " + std::to_string(settings.film_rate_hz) + " -i pipe:0 -an " +
          encoder_options(settings.film, settings.film_rate_hz) + " -fflags +bitexact -flags:v +bitexact -y",
      ' ');
  options.push_back("file:" + partial_path_);
  const int error = start_ffmpeg(std::move(options), ends[1], messages_, child_);
  close(ends[1]);
  if (error == 0) return;
  close_fd(pictures_fd_);
  throw RunError(std::string("ffmpeg cannot be started: ") + std::strerror(error));
}

FilmEncoder::~FilmEncoder() {
  close_fd(pictures_fd_);
  if (child_ > 0) {
    kill(child_, SIGKILL);
    wait_for(child_);
  }
  std::error_code ignored;
  std::filesystem::remove(partial_path_, ignored);
}

void FilmEncoder::fail(const std::string& messages) const {
  std::string line = messages.empty() ? "no message" : messages.substr(0, 300);
  std::ranges::replace(line, '\n', ' ');
  throw RunError(path_ + ": ffmpeg failed: " + line);
}

std::string FilmEncoder::wait() {
  close_fd(pictures_fd_);
  const int status = wait_for(child_);
  child_ = -1;
  if (succeeded(status)) return "";
  const std::string messages = messages_.contents();
  return messages.empty() ? "exited without an error message" : messages;
}

void FilmEncoder::add(const PixelImage& image) {
  if (image.width_px != width_px_ || image.height_px != height_px_) {
    PixelImage even = plain_image(width_px_, height_px_, 0);
    even.paste(image, 0, 0);
    return add(even);
  }
  const auto* bytes = reinterpret_cast<const char*>(image.pixels.data());
  std::size_t remaining = image.pixels.size() * sizeof(image.pixels.front());
  while (remaining > 0) {
    const ssize_t sent = send(pictures_fd_, bytes, remaining, MSG_NOSIGNAL);
    if (sent < 0 && errno == EINTR) continue;
    if (sent <= 0) fail(wait());
    bytes += sent;
    remaining -= static_cast<std::size_t>(sent);
  }
}

void FilmEncoder::finish() {
  const std::string messages = wait();
  if (!messages.empty()) fail(messages);
  std::error_code error;
  if (std::filesystem::file_size(partial_path_, error) == 0 || error) fail("wrote no file");
  std::filesystem::rename(partial_path_, path_, error);
  if (error) throw RunError(path_ + ": cannot be written (" + error.message() + ")");
}

}  // namespace reamsim
