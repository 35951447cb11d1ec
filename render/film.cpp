// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/render.h"

#include <sys/socket.h>
#include <unistd.h>
#include <algorithm>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <limits>
#include <utility>

#include "render/pictures/canvas.h"
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
  // Reproducible by a fixed number of threads; fast to seek in by a key frame per second; players guess no colours.
  return "-vf scale=out_color_matrix=bt709:out_range=tv,format=yuv420p -c:v libx264 -preset medium -crf 18 -g " +
         std::to_string(frames_per_s) +
         " -threads 4 -color_range tv -colorspace bt709 -color_primaries bt709 -color_trc bt709 -movflags +faststart"
         " -f mp4";
}

/// Rounds down to an even number, at least 2.
int even_px(int px) {
  return std::max(2, px / 2 * 2);
}

}  // namespace

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
  std::string line = messages.substr(0, 300);
  std::ranges::replace(line, '\n', ' ');
  throw RunError(path_ + ": ffmpeg failed: " + line);
}

void FilmEncoder::wait() {
  close_fd(pictures_fd_);
  if (succeeded(wait_for(std::exchange(child_, -1)))) return;
  const std::string messages = messages_.contents();
  fail(messages.empty() ? "exited without an error message" : messages);
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
    if (sent <= 0) {
      wait();
      fail("no message");
    }
    bytes += sent;
    remaining -= static_cast<std::size_t>(sent);
  }
}

void FilmEncoder::finish() {
  wait();
  std::error_code error;
  if (std::filesystem::file_size(partial_path_, error) == 0 || error) fail("wrote no file");
  std::filesystem::rename(partial_path_, path_, error);
  if (error) throw RunError(path_ + ": cannot be written (" + error.message() + ")");
}

namespace {

// Lengths in pixels of a film 1080 high.
constexpr double kLeft = 96;
constexpr double kRight = 34;
constexpr double kTop = 84;
constexpr double kBetween = 108;
constexpr double kBottom = 96;
constexpr double kTitle = 24;
constexpr double kNumber = 19;

constexpr Rgba kGrid{0.86, 0.87, 0.89, 1};
constexpr double kPaleOpacity = 0.28;

Rgba rgba_of(std::uint32_t rgb, double opacity) {
  return {(rgb >> 16 & 255) / 255.0, (rgb >> 8 & 255) / 255.0, (rgb & 255) / 255.0, opacity};
}

/// Background of transparent pictures.
constexpr std::uint32_t kBackground_rgb = 0xffffff;
constexpr double kPanelFraction = 0.36;
/// Smaller panels would be illegible.
constexpr int kMinPanel_px = 200;

/// The layout of the bone's part of a film.
PageLayout page_of(const FilmLayout& film) {
  return page_layout(static_cast<int>(film.bone.width), static_cast<int>(film.bone.height));
}

}  // namespace

ForcePanel::ForcePanel(const ForceLog& log, int width_px, int height_px, double unit)
    : log_(log),
      unit_(unit),
      first_s_(log.rows.front().time_s),
      last_s_(std::max(log.rows.back().time_s, log.rows.front().time_s + 1e-6)),
      background_(plain_image(width_px, height_px, kColumnRgb)) {
  const std::string mean = log.mean_travel_mm > 0 ? "mean " : "";
  // Blue and vermilion of Okabe and Ito (2008), as in the plots: safe for colour-blind readers.
  curves_.push_back(
      {mean + "axial force", "N", [](const ForceRow& row) { return row.layer_axial_force_n; }, 1, 0x0072b2, {}});
  curves_.push_back(
      {mean + "spin torque", "N·mm", [](const ForceRow& row) { return row.layer_spin_torque_nmm; }, 0, 0xd55e00, {}});
  if (log.rows.back().push) {
    curves_.push_back(
        {"feed rate", "mm/s", [](const ForceRow& row) { return row.push ? row.push->feed_mm_s : 0; }, 2, 0x009e73, {}});
  }
  const auto curves = static_cast<double>(curves_.size());
  const double height = (height_px - (kTop + (curves - 1) * kBetween + kBottom) * unit) / curves;
  double y = kTop * unit;
  const Canvas canvas(background_);
  for (Curve& curve : curves_) {
    curve.title.front() = static_cast<char>(std::toupper(static_cast<unsigned char>(curve.title.front())));
    curve.box = {kLeft * unit, y, width_px - (kLeft + kRight) * unit, height};
    y += height + kBetween * unit;
    compute_envelope(curve);
    draw_frame(canvas, curve);
  }
  draw_time_axis(canvas);
  for (const Curve& curve : curves_) draw_curve(canvas, curve, curve.low.size(), kPaleOpacity);
  canvas.finish();
}

double ForcePanel::x_of(double time_s) const {
  const Box& box = curves_.front().box;
  return box.x + box.width * (time_s - first_s_) / (last_s_ - first_s_);
}

double ForcePanel::y_of(const Curve& curve, double value) const {
  return curve.box.y + curve.box.height * (curve.max - value) / (curve.max - curve.min);
}

void ForcePanel::compute_envelope(Curve& curve) const {
  const auto columns = static_cast<std::size_t>(std::max(1.0, std::ceil(curve.box.width)));
  curve.low.assign(columns, std::numeric_limits<double>::max());
  curve.high.assign(columns, std::numeric_limits<double>::lowest());
  double least = 0, most = 0;
  for (const ForceRow& row : log_.rows) {
    const double value = curve.value(row);
    const double place = (x_of(row.time_s) - curve.box.x) / curve.box.width * static_cast<double>(columns);
    const auto column = std::min(columns - 1, static_cast<std::size_t>(std::max(0.0, place)));
    curve.low[column] = std::min(curve.low[column], value);
    curve.high[column] = std::max(curve.high[column], value);
    least = std::min(least, value);
    most = std::max(most, value);
  }
  const Scale scale = scale_up_to(std::max(most, -least));
  curve.step = scale.step;
  curve.max = most > 0 || least == 0 ? scale.step * std::max(1.0, std::ceil(most / scale.step - 1e-6)) : 0;
  curve.min = scale.step * std::floor(least / scale.step + 1e-6);
}

void ForcePanel::draw_frame(const Canvas& canvas, const Curve& curve) const {
  const Box& box = curve.box;
  const int lowest = static_cast<int>(std::lround(curve.min / curve.step));
  const int highest = static_cast<int>(std::lround(curve.max / curve.step));
  const Scale numbers{curve.max, curve.step};
  for (int tick = lowest; tick <= highest; ++tick) {
    const double y = y_of(curve, tick * curve.step);
    canvas.line({box.x, y}, {box.x + box.width, y}, tick == 0 ? kFaintTextColor : kGrid, grid_px());
    const TextLine number(canvas, numbers.label(tick), kNumber * unit_);
    number.draw(box.x - 10 * unit_ - number.width, y - 0.5 * number.height, kFaintTextColor);
  }
  const TextLine title(canvas, curve.title + " (" + curve.unit + ")", kTitle * unit_, true);
  title.draw(box.x, box.y - title.height - 16 * unit_);
}

void ForcePanel::draw_time_axis(const Canvas& canvas) const {
  const Scale scale = scale_up_to(last_s_ - first_s_);
  const Box& lower = curves_.back().box;
  const double bottom = lower.y + lower.height;
  const int first = static_cast<int>(std::ceil(first_s_ / scale.step - 1e-9));
  for (int tick = first; tick * scale.step <= last_s_ + 1e-9 * scale.step; ++tick) {
    const double x = x_of(tick * scale.step);
    for (const Curve& curve : curves_) {
      canvas.line({x, curve.box.y}, {x, curve.box.y + curve.box.height}, kGrid, grid_px());
    }
    const TextLine number(canvas, scale.label(tick), kNumber * unit_);
    number.draw(x - 0.5 * number.width, bottom + 8 * unit_, kFaintTextColor);
  }
  const TextLine title(canvas, "Time (s)", kNumber * unit_);
  title.draw(lower.x + 0.5 * (lower.width - title.width), bottom + 40 * unit_);
}

void ForcePanel::draw_curve(const Canvas& canvas, const Curve& curve, std::size_t columns, double opacity) const {
  cairo_t* c = canvas.get();
  const double step = curve.box.width / static_cast<double>(curve.low.size());
  cairo_new_path(c);
  for (std::size_t i = 0; i < columns; ++i) {
    if (curve.low[i] > curve.high[i]) continue;  // no frame in this column
    const double x = curve.box.x + (static_cast<double>(i) + 0.5) * step;
    cairo_line_to(c, x, y_of(curve, curve.low[i]));
    cairo_line_to(c, x, y_of(curve, curve.high[i]));
  }
  cairo_set_line_join(c, CAIRO_LINE_JOIN_ROUND);
  cairo_set_line_cap(c, CAIRO_LINE_CAP_ROUND);
  canvas.stroke(rgba_of(curve.rgb, opacity), std::max(1.2, 2.4 * unit_));
}

PixelImage ForcePanel::at(const ForceRow& row) const {
  PixelImage image = background_;
  const Canvas canvas(image);
  cairo_t* c = canvas.get();
  const double x = x_of(row.time_s);
  for (const Curve& curve : curves_) {
    const Box& box = curve.box;
    const double columns = (x - box.x) / box.width * static_cast<double>(curve.low.size());
    draw_curve(canvas, curve, std::min(curve.low.size(), static_cast<std::size_t>(std::max(0.0, columns)) + 1), 1);
    const double line_px = std::max(1.0, 1.6 * unit_);
    canvas.line({x, box.y}, {x, box.y + box.height}, kFaintTextColor, line_px);
    cairo_arc(c, x, y_of(curve, curve.value(row)), 7 * unit_, 0, 6.2832);
    canvas.set_color(rgba_of(curve.rgb, 1));
    cairo_fill_preserve(c);
    canvas.stroke({1, 1, 1, 1}, line_px);
    const TextLine number(canvas, fixed_text(curve.value(row), curve.decimals), kTitle * unit_, true);
    number.draw(box.x + box.width - number.width, box.y - number.height - 16 * unit_, rgba_of(curve.rgb, 1));
  }
  canvas.finish();
  return image;
}

FilmLayout film_layout(int width_px, int height_px) {
  FilmLayout out{even_px(width_px), even_px(height_px), {}, {}, 1};
  out.bone = {0, 0, static_cast<double>(out.width_px), static_cast<double>(out.height_px)};
  const bool portrait = out.height_px > out.width_px;
  const int panel_px = even_px(static_cast<int>(kPanelFraction * std::max(out.height_px, out.width_px)));
  if (std::min({panel_px, out.width_px, out.height_px}) < kMinPanel_px) return out;
  out.panel = out.bone;
  double& bone_side = portrait ? out.bone.height : out.bone.width;
  bone_side -= panel_px;
  (portrait ? out.panel.y : out.panel.x) = bone_side;
  (portrait ? out.panel.height : out.panel.width) = panel_px;
  out.unit =
      portrait ? std::min(out.width_px / 1000.0, panel_px / 620.0) : std::min(out.height_px / 1080.0, panel_px / 560.0);
  return out;
}

Camera film_camera(const RunView& view, const std::string& name) {
  const PageLayout page = page_of(film_layout(view.settings().width_px, view.settings().height_px));
  return view.camera(name, page.view_width_px, page.height_px);
}

Film::Film(const std::string& path, const RunView& view, const Captions& captions, const Camera& camera)
    : view_(view),
      captions_(captions),
      layout_(film_layout(view.settings().width_px, view.settings().height_px)),
      camera_(camera),
      encoder_(path, view.settings()) {
  if (layout_.panel.width == 0) return;
  panel_ = std::make_unique<ForcePanel>(view.run().log(), static_cast<int>(layout_.panel.width),
                                        static_cast<int>(layout_.panel.height), layout_.unit);
}

void Film::add(PixelImage bone, const ForceRow& row) {
  Labels labels = view_.labels(camera_, view_.tool_at(row.frame));
  labels.values = {{"time", fixed_text(row.time_s, 3) + " s"},
                   {"tool depth", depth_text(row.depth_mm)},
                   {"removed", fixed_text(row.removed_mm3, 1) + " mm³"}};
  labels.force = captions_.arrow(row);
  PixelImage frame = plain_image(layout_.width_px, layout_.height_px, kBackground_rgb);
  frame.paste(annotated_picture(std::move(bone), page_of(layout_), camera_, labels, view_.settings().background), 0, 0);
  if (panel_) frame.paste(panel_->at(row), static_cast<int>(layout_.panel.x), static_cast<int>(layout_.panel.y));
  encoder_.add(frame);
}

}  // namespace reamsim
