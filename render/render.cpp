// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include <fmt/core.h>
#include <filesystem>
#include <future>
#include <limits>
#include <map>

#include "render/pictures/composites.h"
#include "render/render.h"
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
  /// `report` gets a warning for each picture of the final state that looks empty; may be null.
  PictureComposer(const RunData& run, const PictureOptions& options, const PictureProgress& progress,
                  Diagnostics* report)
      : dir_(run.dir()),
        view_(run, options.settings),
        camera_without_suffix_(options.camera_without_suffix.empty() ? camera_names(options.settings).front()
                                                                     : options.camera_without_suffix),
        captions_(run.log(), options.mean_travel_mm, options.settings.force_arrow),
        report_(report),
        writer_(progress, count_pictures(options, view_.frames(), run.contact())) {
    std::filesystem::create_directories(dir_ + "/frames");
    if (turns() == 0) return;
    std::filesystem::create_directories(dir_ + "/turntable");
    // Without the pictures that a longer turntable left behind the last one of this.
    for (int i = turns(); std::filesystem::remove(turntable_path(i)); ++i) {
    }
  }

  void add(RenderedFrame frame) {
    switch (frame.kind) {
      case Shot::Kind::before:
        before_[frame.camera.name] = std::move(frame.image);
        break;
      case Shot::Kind::frame:
        add_frame(frame);
        break;
      case Shot::Kind::sheet:
        if (!sheet_) sheet_.emplace(view_, frame.camera);
        sheet_->add(std::move(frame.image), row_of(frame.frame));
        if (sheet_->is_full()) writer_.write(dir_ + "/contact_sheet.png", sheet_->finish());
        break;
      case Shot::Kind::film:
        if (!film_) film_.emplace(film_path("reamed"), view_, captions_, frame.camera);
        film_->add(std::move(frame.image), row_of(frame.frame));
        writer_.count(film_path("reamed"));
        if (frame.frame == view_.frames().back()) film_->finish();
        break;
      case Shot::Kind::after:
        add_after(frame);
        break;
      case Shot::Kind::after_half:
        writer_.write(picture_path("before_after", frame),
                      before_and_after(view_, frame.camera, before_[frame.camera.name], frame.image,
                                       captions_.after(frame.deepest_mm), frame.contours));
        break;
      case Shot::Kind::turntable:
        add_turn(frame);
        break;
    }
  }

  void finish() { writer_.finish(); }

 private:
  [[nodiscard]] const ForceRow& row_of(std::int64_t frame) const {
    return captions_.log().at(frame, dir_ + "/forces.csv");
  }
  [[nodiscard]] int turns() const { return view_.settings().turntable_pictures; }
  [[nodiscard]] std::string turntable_path(int turn) const { return fmt::format("{}/turntable/{:03}.png", dir_, turn); }
  [[nodiscard]] std::string film_path(const std::string& name) const {
    return dir_ + "/" + name + "." + name_of(view_.settings().film);
  }
  [[nodiscard]] std::string picture_path(const std::string& name, const Shot& shot) const {
    const bool plain = shot.camera.name == camera_without_suffix_;
    return dir_ + "/" + name + (plain ? "" : "_" + shot.camera.name) + ".png";
  }

  /// Takes the image and the contours of the frame.
  [[nodiscard]] PixelImage labelled(RenderedFrame& frame, Labels labels) const {
    labels.contours = std::move(frame.contours);
    return labelled_page(std::move(frame.image), view_.page(), frame.camera, labels, view_.settings().background);
  }

  void add_frame(RenderedFrame& frame) {
    const ForceRow& row = row_of(frame.frame);
    Labels labels = view_.labels(frame.camera, view_.tool_at(frame.frame));
    labels.values = captions_.at(row);
    labels.force = captions_.arrow(row);
    writer_.write(picture_path(fmt::format("frames/{:06}", frame.frame), frame), labelled(frame, std::move(labels)));
  }

  void add_after(RenderedFrame& frame) {
    Labels labels = view_.labels(frame.camera, std::nullopt);
    labels.title = "After reaming";
    labels.values = captions_.after(frame.deepest_mm);
    const std::string path = picture_path("reamed", frame);
    if (report_ != nullptr && frame.image.has_plain_rows()) {
      report_->warn(path.substr(dir_.size() + 1) + " looks empty: move position_mm of the camera " + frame.camera.name +
                    " out of the bone, aim target_mm at the bone, or use a larger fov_deg or width_mm");
    }
    writer_.write(path, labelled(frame, std::move(labels)));
  }

  void add_turn(RenderedFrame& frame) {
    frame.contours.clear();
    PixelImage picture = labelled(frame, view_.labels(frame.camera, std::nullopt));
    const int turn = turn_++;
    if (view_.settings().film != FilmFormat::none) {
      if (!turntable_film_) turntable_film_.emplace(film_path("turntable"), view_.settings());
      PixelImage page = plain_image(picture.width_px, picture.height_px, 0xffffff);
      page.paste(picture, 0, 0);
      turntable_film_->add(page);
      if (turn_ == turns()) turntable_film_->finish();
    }
    writer_.write(turntable_path(turn), std::move(picture));
  }

  std::string dir_;
  RunView view_;
  std::string camera_without_suffix_;
  Captions captions_;
  Diagnostics* report_;
  std::map<std::string, PixelImage> before_;  ///< by camera
  std::optional<ContactSheet> sheet_;
  std::optional<Film> film_;
  std::optional<FilmEncoder> turntable_film_;
  int turn_ = 0;
  PngWriter writer_;
};

}  // namespace

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
    PictureComposer composer(run, options, progress, report);
    std::optional<RenderedFrame> frame = thread->next();
    if (report != nullptr && !thread->warning().empty()) report->warn(thread->warning());
    for (; frame; frame = thread->next()) composer.add(std::move(*frame));
    composer.finish();
    return thread->context();
  } catch (const std::filesystem::filesystem_error& error) {
    throw RunError(run.dir() + ": " + error.code().message());
  } catch (const std::bad_alloc&) {
    throw RunError(run.dir() + ": not enough memory for the pictures; use smaller pictures or larger voxels");
  }
}

}  // namespace reamsim
