// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <algorithm>
#include <filesystem>
#include <future>
#include <limits>

#include "render/film/film.h"
#include "render/pictures/composites.h"
#include "render/render.h"
#include "render/render_thread.h"
#include "sim/base/error.h"
#include "sim/base/text.h"

namespace reamsim {
namespace {

/// Writes pictures on another thread, and reports progress.
class PngWriter {
 public:
  PngWriter(PictureProgress progress, int total) : progress_(std::move(progress)), total_(total) {}

  void write(const std::string& path, PixelImage image) {
    finish();
    path_ = path;
    writing_ = std::async(std::launch::async, [path, image = std::move(image)]() mutable { write_png(path, image); });
  }

  /// Waits for the current picture; throws the exceptions of writing it.
  void finish() {
    if (!writing_.valid()) return;
    writing_.get();
    count(path_);
  }

  /// Counts a picture.
  void count(const std::string& path) {
    if (progress_) progress_(++done_, total_, path);
  }

 private:
  PictureProgress progress_;
  int total_;
  int done_ = 0;
  std::string path_;
  std::future<void> writing_;
};

/// Composes the pictures of a run from its rendered frames, in their order.
class PictureComposer {
 public:
  PictureComposer(const RunData& run, const PictureOptions& options, const PictureProgress& progress)
      : dir_(run.dir()),
        view_(run, options.settings),
        schedule_(view_, options),
        camera_without_suffix_(options.camera_without_suffix.empty() ? schedule_.names.front()
                                                                     : options.camera_without_suffix),
        captions_(run.log(), options.mean_travel_mm, options.settings.force_arrow),
        before_(schedule_.halves.size()),
        writer_(progress, count_pictures(options, view_.frames(), run.contact())) {
    std::filesystem::create_directories(dir_ + "/frames");
    if (!schedule_.turntable.empty()) make_turntable_folder();
    if (schedule_.sheet) sheet_.emplace(view_, *schedule_.sheet);
    if (schedule_.film) film_.emplace(film_path("reamed"), view_, captions_, *schedule_.film);
  }

  /// Without the pictures that a longer turntable left behind the last one of this.
  void make_turntable_folder() const {
    std::filesystem::create_directories(dir_ + "/turntable");
    for (std::size_t i = schedule_.turntable.size(); std::filesystem::remove(turntable_path(i)); ++i) {
    }
  }

  [[nodiscard]] std::string turntable_path(std::size_t place) const {
    return fmt::format("{}/turntable/{:03}.png", dir_, place);
  }

  void add(RenderedFrame frame) {
    switch (frame.kind) {
      case RenderedFrame::Kind::before:
        before_[frame.camera] = std::move(frame.image);
        break;
      case RenderedFrame::Kind::frame:
        add_frame(std::move(frame));
        break;
      case RenderedFrame::Kind::sheet:
        sheet_->add(std::move(frame.image), row_of(frame.frame));
        if (frame.frame == schedule_.sheet_frames.back()) writer_.write(dir_ + "/contact_sheet.png", sheet_->finish());
        break;
      case RenderedFrame::Kind::film:
        add_film_frame(std::move(frame));
        break;
      case RenderedFrame::Kind::after:
        add_after(std::move(frame));
        break;
      case RenderedFrame::Kind::after_half:
        writer_.write(dir_ + "/before_after" + suffix(frame.camera) + ".png",
                      before_and_after(view_, schedule_.halves[frame.camera], before_[frame.camera], frame.image,
                                       captions_.after(frame.deepest_mm), frame.contours));
        break;
      case RenderedFrame::Kind::turntable:
        add_turn(std::move(frame));
        break;
    }
  }

  void finish() { writer_.finish(); }

  /// One of each picture of the final state that looks empty.
  [[nodiscard]] const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  [[nodiscard]] const ForceRow& row_of(std::int64_t frame) const {
    return captions_.log().at(frame, dir_ + "/forces.csv");
  }

  void add_frame(RenderedFrame frame) {
    const Camera& camera = schedule_.cameras[frame.camera];
    const ForceRow& row = row_of(frame.frame);
    Labels labels = view_.labels(camera, view_.tool_at(frame.frame));
    labels.values = captions_.at(row);
    labels.force = captions_.arrow(row);
    labels.contours = std::move(frame.contours);
    writer_.write(fmt::format("{}/frames/{:06}{}.png", dir_, frame.frame, suffix(frame.camera)),
                  page_with(std::move(frame.image), camera, labels));
  }

  void add_film_frame(RenderedFrame frame) {
    film_->add(std::move(frame.image), row_of(frame.frame));
    writer_.count(film_path("reamed"));
    if (frame.frame == view_.frames().back()) film_->finish();
  }

  void add_after(RenderedFrame frame) {
    const Camera& camera = schedule_.cameras[frame.camera];
    Labels labels = view_.labels(camera, std::nullopt);
    labels.title = "After reaming";
    labels.values = captions_.after(frame.deepest_mm);
    labels.contours = std::move(frame.contours);
    const std::string name = "reamed" + suffix(frame.camera) + ".png";
    if (frame.image.has_plain_rows()) {
      warnings_.push_back(
          fmt::format("{} looks empty: move position_mm of the camera {} out of the bone, aim target_mm at the bone, "
                      "or use a larger fov_deg or width_mm",
                      name, camera.name));
    }
    writer_.write(dir_ + "/" + name, page_with(std::move(frame.image), camera, labels));
  }

  void add_turn(RenderedFrame frame) {
    const Camera& camera = schedule_.turntable[frame.camera];
    PixelImage picture = page_with(std::move(frame.image), camera, view_.labels(camera, std::nullopt));
    if (view_.settings().film != FilmFormat::none) {
      if (!turntable_film_) turntable_film_.emplace(film_path("turntable"), view_.settings());
      PixelImage page = plain_image(picture.width_px, picture.height_px, 0xffffff);
      page.paste(picture, 0, 0);
      turntable_film_->add(page);
      if (frame.camera + 1 == schedule_.turntable.size()) turntable_film_->finish();
    }
    writer_.write(turntable_path(frame.camera), std::move(picture));
  }

  [[nodiscard]] PixelImage page_with(PixelImage view, const Camera& camera, const Labels& labels) const {
    return labelled_page(std::move(view), view_.page(), camera, labels, view_.settings().background);
  }

  [[nodiscard]] std::string film_path(const std::string& name) const {
    return dir_ + "/" + name + film_extension(view_.settings().film);
  }

  [[nodiscard]] std::string suffix(std::size_t camera) const {
    const std::string& name = schedule_.names[camera];
    return name == camera_without_suffix_ ? std::string() : "_" + name;
  }

  std::string dir_;
  RunView view_;
  FrameSchedule schedule_;
  std::string camera_without_suffix_;
  Captions captions_;
  std::vector<PixelImage> before_;
  std::optional<ContactSheet> sheet_;
  std::optional<Film> film_;
  std::optional<FilmEncoder> turntable_film_;
  std::vector<std::string> warnings_;
  PngWriter writer_;
};

}  // namespace

void require_film_program(const RenderSettings& settings) {
  if (settings.enabled && settings.film != FilmFormat::none) require_encoder(settings.film);
}

std::string render_pictures(const RunData& run, const PictureOptions& options, const PictureProgress& progress,
                            Diagnostics* report, RenderThread* thread) {
  if (options.settings.cameras.empty() && options.settings.user_cameras.empty()) {
    throw InputError({}, "render.cameras", "found none", "expected at least one camera");
  }
  require_film_program(options.settings);
  std::optional<RenderThread> own_thread;
  if (thread == nullptr) {
    thread = &own_thread.emplace(run, options);
    thread->snapshots_written(std::numeric_limits<std::int64_t>::max());
  }
  try {
    PictureComposer composer(run, options, progress);
    std::optional<RenderedFrame> frame = thread->next();
    if (report != nullptr && !thread->warning().empty()) report->warn(thread->warning());
    for (; frame; frame = thread->next()) composer.add(std::move(*frame));
    composer.finish();
    if (report != nullptr) {
      for (const std::string& warning : composer.warnings()) report->warn(warning);
    }
    return thread->context();
  } catch (const std::filesystem::filesystem_error& error) {
    throw RunError(run.dir() + ": " + error.code().message());
  } catch (const std::bad_alloc&) {
    throw RunError(run.dir() + ": not enough memory for the pictures; use smaller pictures or larger voxels");
  }
}

}  // namespace reamsim
