#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <future>
#include <memory>

#include "render/before_after.h"
#include "render/contact_sheet.h"
#include "render/encoder.h"
#include "render/film.h"
#include "render/fixed_text.h"
#include "render/picture_frames.h"
#include "render/render.h"
#include "render/studio.h"
#include "sim/base/error.h"

namespace reamsim {
namespace {

using Values = std::vector<std::pair<std::string, std::string>>;

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

/// Makes all pictures of one run.
class PictureMaker {
 public:
  PictureMaker(const FinishedRun& run, const RenderSettings& settings, const PictureChoice& choice,
               double mean_travel_mm, const PictureProgress& progress, Report* report)
      : dir_(run.dir()),
        settings_(settings),
        choice_(choice),
        names_(settings.cameras),
        studio_(run, settings, mean_travel_mm, report),
        stills_(still_frames(studio_.frames(), settings)),
        writer_(progress, 0) {
    for (const UserCamera& own : settings.user_cameras) names_.push_back(own.name);
    for (const std::string& name : names_)
      cameras_.push_back(studio_.camera(name, settings.width_px, settings.height_px));
    writer_ = PictureWriter(progress, count());
  }

  void run() {
    final_pictures();
    turntable();
    const bool all_frames = choice_.stills || settings_.contact_sheet || films_run();
    if (all_frames || settings_.before_after) frame_by_frame(all_frames);
    writer_.finish();
  }

 private:
  [[nodiscard]] int count() const {
    const std::size_t frames = studio_.frames().size();
    std::size_t sum = cameras_.size() * ((choice_.stills ? 1 + stills_.size() : 0) + (settings_.before_after ? 1 : 0));
    sum += static_cast<std::size_t>(settings_.turntable_pictures);
    return static_cast<int>(sum + (settings_.contact_sheet ? 1 : 0) + (films_run() ? frames : 0));
  }

  [[nodiscard]] bool films_run() const { return choice_.film && settings_.film != "none"; }

  void final_pictures() {
    const Values values = final_values();
    if (choice_.stills) {
      for (const Camera& camera : cameras_) {
        PixelImage image = studio_.photograph(camera, std::nullopt);
        Labels labels = studio_.labels(camera, std::nullopt);
        labels.title = "After reaming";
        labels.values = values;
        draw_labels(image, camera, labels);
        writer_.write(dir_ + "/reamed" + suffix(camera.name) + ".png", std::move(image));
      }
    }
    if (!settings_.before_after) return;
    for (const std::string& name : names_) before_after_.emplace_back(studio_, name, values);
  }

  void turntable() {
    const int pictures = settings_.turntable_pictures;
    if (pictures == 0) return;
    std::filesystem::create_directories(dir_ + "/turntable");
    std::unique_ptr<FilmEncoder> film;
    if (settings_.film != "none") film = std::make_unique<FilmEncoder>(film_path("turntable"), settings_);
    for (int i = 0; i < pictures; ++i) {
      const double turn = static_cast<double>(i) / pictures;
      const Camera camera = make_turntable_camera(studio_.subject(), turn, settings_.width_px, settings_.height_px);
      PixelImage image = studio_.photograph(camera, std::nullopt);
      draw_labels(image, camera, studio_.labels(camera, std::nullopt));
      if (film) {
        PixelImage frame = plain_image(image.width_px, image.height_px, 0xffffff);
        frame.paste(image, 0, 0);
        film->add(frame);
      }
      writer_.write(dir_ + "/turntable/" + numbered("%03lld", i) + ".png", std::move(image));
    }
    if (film) film->finish();
  }

  /// Once through the run, for everything that follows it. `all`: to its end.
  void frame_by_frame(bool all) {
    std::optional<ContactSheet> sheet;
    std::optional<Film> film;
    if (settings_.contact_sheet) sheet.emplace(studio_, names_.front());
    if (films_run()) film.emplace(film_path("reamed"), studio_, names_.front());
    studio_.rewind();
    for (const std::int64_t frame : studio_.frames()) {
      studio_.advance_to(frame);
      before_after_pictures();
      if (!all) break;
      if (choice_.stills && std::ranges::binary_search(stills_, frame)) frame_pictures(frame);
      if (sheet) sheet->add(studio_, frame);
      if (!film) continue;
      film->add(studio_, studio_.row_of(frame));
      writer_.count(film_path("reamed"));
    }
    if (sheet) writer_.write(dir_ + "/contact_sheet.png", sheet->finish(studio_));
    if (film) film->finish();
  }

  /// At the first frame; afterwards there is nothing left to do.
  void before_after_pictures() {
    for (const BeforeAfter& pair : before_after_) {
      writer_.write(dir_ + "/before_after" + suffix(pair.camera()) + ".png", pair.finish(studio_));
    }
    before_after_.clear();
  }

  void frame_pictures(std::int64_t frame) {
    const ForceRow& row = studio_.row_of(frame);
    const std::optional<Rigid> tool = studio_.tool_at(row);
    for (const Camera& camera : cameras_) {
      PixelImage image = studio_.photograph(camera, tool);
      Labels labels = studio_.labels(camera, tool);
      labels.values = frame_values(row);
      labels.force = studio_.force_arrow(row);
      labels.widest_value = widest_value();
      draw_labels(image, camera, labels);
      writer_.write(dir_ + "/frames/" + numbered("%06lld", frame) + suffix(camera.name) + ".png", std::move(image));
    }
  }

  [[nodiscard]] Values frame_values(const ForceRow& row) const {
    return {{"time", fixed_text(row.time_s, 3) + " s"},
            {"tool depth", depth_text(row.depth_mm)},
            {studio_.mean() + "axial force", fixed_text(row.layer_axial_force_n, 1) + " N"},
            {studio_.mean() + "torque", fixed_text(row.layer_spin_torque_nmm, 0) + " N·mm"},
            {"removed", fixed_text(row.removed_mm3, 1) + " mm³"}};
  }

  /// The longest value that any picture along the run can show.
  [[nodiscard]] std::string widest_value() const {
    std::string widest;
    for (const ForceRow& row : {studio_.log().rows.back(), most_}) {
      for (const auto& [name, value] : frame_values(row)) {
        if (value.size() > widest.size()) widest = value;
      }
    }
    return widest;
  }

  [[nodiscard]] Values final_values() {
    for (const ForceRow& row : studio_.log().rows) {
      most_.layer_axial_force_n = std::max(most_.layer_axial_force_n, row.layer_axial_force_n);
      most_.layer_spin_torque_nmm = std::max(most_.layer_spin_torque_nmm, row.layer_spin_torque_nmm);
    }
    return {{"reamed depth", fixed_text(studio_.deepest_mm(), 2) + " mm"},
            {"removed", fixed_text(studio_.log().rows.back().removed_mm3, 1) + " mm³"},
            {"peak " + studio_.mean() + "force", fixed_text(most_.layer_axial_force_n, 1) + " N"},
            {"peak " + studio_.mean() + "torque", fixed_text(most_.layer_spin_torque_nmm, 0) + " N·mm"}};
  }

  [[nodiscard]] static std::string numbered(const char* format, std::int64_t number) {
    std::array<char, 32> text;
    std::snprintf(text.data(), text.size(), format, static_cast<long long>(number));
    return text.data();
  }

  [[nodiscard]] std::string film_path(const std::string& name) const {
    return dir_ + "/" + name + film_ending(film_format(settings_.film));
  }

  [[nodiscard]] std::string suffix(const std::string& camera) const {
    const std::string& plain = choice_.plain_camera.empty() ? names_.front() : choice_.plain_camera;
    return camera == plain ? std::string() : "_" + camera;
  }

  std::string dir_;
  RenderSettings settings_;
  PictureChoice choice_;
  std::vector<std::string> names_;  ///< of the cameras, the user's last
  Studio studio_;
  std::vector<std::int64_t> stills_;
  std::vector<Camera> cameras_;
  ForceRow most_;  ///< the greatest force and torque of the run
  std::vector<BeforeAfter> before_after_;
  PictureWriter writer_;
};

}  // namespace

void require_film_program(const RenderSettings& settings) {
  if (settings.enabled && settings.film != "none") require_encoder(film_format(settings.film));
}

void render_pictures(const FinishedRun& run, const RenderSettings& settings, double mean_travel_mm,
                     const PictureProgress& progress, Report* report, const PictureChoice& choice) {
  if (settings.cameras.empty() && settings.user_cameras.empty()) {
    throw InputError({}, "render.cameras", "found none", "expected at least one camera");
  }
  require_film_program(settings);
  const std::string& dir = run.dir();
  try {
    PictureMaker maker(run, settings, choice, mean_travel_mm, progress, report);
    std::filesystem::create_directories(dir + "/frames");
    maker.run();
  } catch (const std::filesystem::filesystem_error& error) {
    throw RunError(dir + ": " + error.code().message());
  } catch (const std::bad_alloc&) {
    throw RunError(dir + ": the pictures need more memory than there is");
  }
}

}  // namespace reamsim
