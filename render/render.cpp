#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <future>
#include <limits>

#include "render/film/encoder.h"
#include "render/film/film.h"
#include "render/photographer.h"
#include "render/picture_list.h"
#include "render/pictures/before_after.h"
#include "render/pictures/captions.h"
#include "render/pictures/contact_sheet.h"
#include "render/pictures/results.h"
#include "render/render.h"
#include "sim/base/error.h"

namespace reamsim {
namespace {

/// Writes pictures while the next one is drawn, and counts them.
class PictureWriter {
 public:
  PictureWriter(PictureProgress progress, int total) : progress_(std::move(progress)), total_(total) {}

  void write(const std::string& path, PixelImage image) {
    finish();
    path_ = path;
    writing_ = std::async(std::launch::async, [path, image = std::move(image)]() mutable { write_png(path, image); });
  }

  /// Waits for the picture that is being compressed; throws what writing it threw.
  void finish() {
    if (!writing_.valid()) return;
    writing_.get();
    count(path_);
  }

  /// A picture that went elsewhere.
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

/// Makes the pictures of a run from its photographs, in the order in which they come.
class PictureMaker {
 public:
  PictureMaker(const FinishedRun& run, const RenderSettings& settings, const PictureChoice& choice,
               double mean_travel_mm, const PictureProgress& progress)
      : dir_(run.dir()),
        results_(run.results()),
        view_(run.planned(), settings),
        list_(view_, choice),
        plain_camera_(choice.plain_camera.empty() ? list_.names.front() : choice.plain_camera),
        captions_(results_.log, mean_travel_mm, settings.force_arrow),
        widest_(captions_.widest()),
        before_(list_.halves.size()),
        writer_(progress, list_.pictures(view_)) {
    std::filesystem::create_directories(dir_ + "/frames");
    if (!list_.turntable.empty()) std::filesystem::create_directories(dir_ + "/turntable");
    if (list_.sheet) sheet_.emplace(view_, *list_.sheet);
    if (list_.film) film_.emplace(film_path("reamed"), view_, captions_, *list_.film);
  }

  void take(Photo photo) {
    switch (photo.of) {
      case Photo::Of::before:
        before_[photo.camera] = std::move(photo.image);
        break;
      case Photo::Of::frame:
        frame(std::move(photo));
        break;
      case Photo::Of::sheet:
        sheet_->add(std::move(photo.image), row_of(photo.frame));
        if (photo.frame == list_.sheet_frames.back()) writer_.write(dir_ + "/contact_sheet.png", sheet_->finish());
        break;
      case Photo::Of::film:
        film_frame(std::move(photo));
        break;
      case Photo::Of::after:
        after(std::move(photo));
        break;
      case Photo::Of::after_half:
        writer_.write(dir_ + "/before_after" + suffix(photo.camera) + ".png",
                      before_and_after(view_, list_.halves[photo.camera], before_[photo.camera], photo.image,
                                       captions_.after(photo.deepest_mm)));
        break;
      case Photo::Of::turntable:
        turntable(std::move(photo));
        break;
    }
  }

  void finish() { writer_.finish(); }

 private:
  [[nodiscard]] const ForceRow& row_of(std::int64_t frame) const {
    return captions_.log().at(frame, results_.log_path);
  }

  void frame(Photo photo) {
    const Camera& camera = list_.cameras[photo.camera];
    const ForceRow& row = row_of(photo.frame);
    Labels labels = view_.labels(camera, view_.tool_at(photo.frame));
    labels.values = captions_.at(row);
    labels.force = captions_.arrow(row);
    labels.widest_value = widest_;
    draw_labels(photo.image, camera, labels);
    writer_.write(dir_ + "/frames/" + numbered("%06lld", photo.frame) + suffix(photo.camera) + ".png",
                  std::move(photo.image));
  }

  void film_frame(Photo photo) {
    film_->add(std::move(photo.image), row_of(photo.frame));
    writer_.count(film_path("reamed"));
    if (photo.frame == view_.frames().back()) film_->finish();
  }

  void after(Photo photo) {
    const Camera& camera = list_.cameras[photo.camera];
    Labels labels = view_.labels(camera, std::nullopt);
    labels.title = "After reaming";
    labels.values = captions_.after(photo.deepest_mm);
    draw_labels(photo.image, camera, labels);
    writer_.write(dir_ + "/reamed" + suffix(photo.camera) + ".png", std::move(photo.image));
  }

  void turntable(Photo photo) {
    const Camera& camera = list_.turntable[photo.camera];
    draw_labels(photo.image, camera, view_.labels(camera, std::nullopt));
    if (view_.settings().film != FilmFormat::none) {
      if (!turntable_film_) turntable_film_.emplace(film_path("turntable"), view_.settings());
      PixelImage frame = plain_image(photo.image.width_px, photo.image.height_px, 0xffffff);
      frame.paste(photo.image, 0, 0);
      turntable_film_->add(frame);
      if (photo.camera + 1 == list_.turntable.size()) turntable_film_->finish();
    }
    writer_.write(dir_ + "/turntable/" + numbered("%03lld", static_cast<std::int64_t>(photo.camera)) + ".png",
                  std::move(photo.image));
  }

  [[nodiscard]] static std::string numbered(const char* format, std::int64_t number) {
    std::array<char, 32> text;
    std::snprintf(text.data(), text.size(), format, static_cast<long long>(number));
    return text.data();
  }

  [[nodiscard]] std::string film_path(const std::string& name) const {
    return dir_ + "/" + name + film_ending(view_.settings().film);
  }

  [[nodiscard]] std::string suffix(std::size_t camera) const {
    const std::string& name = list_.names[camera];
    return name == plain_camera_ ? std::string() : "_" + name;
  }

  std::string dir_;
  const RunResults& results_;
  RunView view_;
  PictureList list_;
  std::string plain_camera_;
  Captions captions_;
  std::string widest_;  ///< of the values in pictures along the run
  std::vector<PixelImage> before_;
  std::optional<ContactSheet> sheet_;
  std::optional<Film> film_;
  std::optional<FilmEncoder> turntable_film_;
  PictureWriter writer_;
};

void require_possible(const RenderSettings& settings) {
  if (settings.cameras.empty() && settings.user_cameras.empty()) {
    throw InputError({}, "render.cameras", "found none", "expected at least one camera");
  }
  require_film_program(settings);
}

}  // namespace

void require_film_program(const RenderSettings& settings) {
  if (settings.enabled && settings.film != FilmFormat::none) require_encoder(settings.film);
}

void render_pictures(const FinishedRun& run, const RenderSettings& settings, double mean_travel_mm,
                     const PictureProgress& progress, Report* report, const PictureChoice& choice) {
  require_possible(settings);
  SnapshotFeed snapshots;
  snapshots.reached(std::numeric_limits<std::int64_t>::max());
  Photographer photographer(run.planned(), settings, choice, snapshots);
  render_pictures(run, settings, mean_travel_mm, progress, report, choice, photographer);
}

void render_pictures(const FinishedRun& run, const RenderSettings& settings, double mean_travel_mm,
                     const PictureProgress& progress, Report* report, const PictureChoice& choice,
                     Photographer& photographer) {
  require_possible(settings);
  const std::string& dir = run.dir();
  try {
    PictureMaker maker(run, settings, choice, mean_travel_mm, progress);
    std::optional<Photo> photo = photographer.next();
    if (report != nullptr && !photographer.warning().empty()) report->warn(photographer.warning());
    for (; photo; photo = photographer.next()) maker.take(std::move(*photo));
    maker.finish();
  } catch (const std::filesystem::filesystem_error& error) {
    throw RunError(dir + ": " + error.code().message());
  } catch (const std::bad_alloc&) {
    throw RunError(dir + ": the pictures need more memory than there is");
  }
}

}  // namespace reamsim
