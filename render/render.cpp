// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/render.h"

#include <fmt/core.h>
#include <filesystem>
#include <future>
#include <limits>
#include <map>
#include <utility>

#include "render/pictures/figures.h"
#include "render/pictures/renderer.h"

namespace reamsim {

namespace {

/// Limits of the memory for waiting frames: a fraction of the machine's memory, and an absolute one.
constexpr double kWaitingFraction = 1.0 / 16;
constexpr double kMaxWaiting_bytes = 1e9;

std::size_t bytes_of(const RenderedFrame& frame) {
  return frame.image.pixels.size() * sizeof(frame.image.pixels[0]);
}

}  // namespace

bool FrameQueue::push(RenderedFrame frame) {
  const std::size_t size = bytes_of(frame);
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return closed_ || frames_.empty() || bytes_ + size <= max_bytes_; });
  if (closed_) return false;
  bytes_ += size;
  frames_.push_back(std::move(frame));
  changed_.notify_all();
  return true;
}

void FrameQueue::finish(std::exception_ptr error) {
  const std::lock_guard lock(mutex_);
  finished_ = true;
  error_ = std::move(error);
  changed_.notify_all();
}

std::optional<RenderedFrame> FrameQueue::pop() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return finished_ || !frames_.empty(); });
  if (frames_.empty()) {
    if (error_) std::rethrow_exception(error_);
    return std::nullopt;
  }
  RenderedFrame out = std::move(frames_.front());
  frames_.pop_front();
  bytes_ -= bytes_of(out);
  changed_.notify_all();
  return out;
}

void FrameQueue::close() {
  const std::lock_guard lock(mutex_);
  closed_ = true;
  changed_.notify_all();
}

RenderThread::RenderThread(const RunData& run, const PictureOptions& options)
    : queue_(static_cast<std::size_t>(std::min(kMaxWaiting_bytes, kWaitingFraction * machine_memory_bytes()))),
      thread_([this, run, options] { work(run, options); }) {}

RenderThread::~RenderThread() {
  stop_ = true;
  snapshots_written(std::numeric_limits<std::int64_t>::max());  // wakes the thread
  queue_.close();
  thread_.join();
}

void RenderThread::snapshots_written(std::int64_t frame) {
  written_ = std::max(written_.load(), frame);
  written_.notify_all();
}

bool RenderThread::wait_for_snapshot(std::int64_t frame) {
  for (std::int64_t written = written_; written < frame; written = written_) written_.wait(written);
  return !stop_;
}

void RenderThread::render(const RunView& view, const std::vector<Shot>& shots) {
  using Kind = Shot::Kind;
  if (!wait_for_snapshot(view.frames().front())) return;
  Renderer renderer(view);
  warning_ = renderer.warning();
  context_ = renderer.context();
  std::int64_t state = -1;
  for (const Shot& shot : shots) {
    if (!wait_for_snapshot(shot.frame)) return;
    if (shot.kind != Kind::before && shot.frame != state) renderer.advance_to(state = shot.frame);
    RenderedFrame out{shot, renderer.deepest_mm()};
    std::optional<PlacedTool> tool;
    const bool along_run = shot.kind == Kind::frame || shot.kind == Kind::sheet || shot.kind == Kind::film;
    if (along_run) tool = view.tool_at(shot.frame);
    // By samples in final pictures, and where the user asks for the smoothest edges.
    // The filter finds edges by brightness, which transparent pixels lack.
    const RenderSettings& settings = view.settings();
    const bool fast = settings.supersampling == 1 && settings.background != Background::transparent;
    const bool filtered = shot.kind == Kind::film || ((shot.kind == Kind::frame || shot.kind == Kind::sheet) && fast);
    out.image = renderer.render(shot.camera, tool, filtered);
    const bool numbered = shot.kind != Kind::sheet && !(tool && shot.camera.shows_tool);
    if (numbered) out.contours = renderer.contours(shot.camera);
    if (!queue_.push(std::move(out))) return;
  }
}

void RenderThread::work(const RunData& run, const PictureOptions& options) {
  try {
    const RunView view(run, options.settings);
    if (count_pictures(options, view.frames(), run.contact()) > 0) render(view, shots_of(view, options));
    queue_.finish(nullptr);
  } catch (...) {
    queue_.finish(std::current_exception());
  }
}

std::vector<std::string> camera_names(const RenderSettings& settings) {
  std::vector<std::string> names = names_of(settings.cameras);
  for (const UserCamera& own : settings.user_cameras) names.push_back(own.name);
  return names;
}

std::vector<Shot> shots_of(const RunView& view, const PictureOptions& options) {
  using Kind = Shot::Kind;
  const RenderSettings& settings = view.settings();
  const PageLayout page = view.page(), frame_page = view.frame_page();
  const std::vector<std::string> names = camera_names(settings);
  std::vector<Camera> cameras, frame_cameras, halves, film, turntable;
  for (const std::string& name : names) {
    cameras.push_back(view.camera(name, page.view_width_px, page.height_px));
    frame_cameras.push_back(view.camera(name, frame_page.view_width_px, frame_page.height_px));
    if (settings.before_after) halves.push_back(half_camera(view, name));
  }
  std::vector<std::int64_t> stills, cells;
  if (options.stills) stills = still_frames(view.frames(), settings, view.run().contact());
  if (settings.contact_sheet) cells = ContactSheet::frames_on(view);
  if (options.film && settings.film != FilmFormat::none) film = {film_camera(view, names.front())};
  for (int i = 0; i < settings.turntable_pictures; ++i) {
    const double turn = static_cast<double>(i) / settings.turntable_pictures;
    turntable.push_back(make_turntable_camera(view.run().target(), turn, page.view_width_px, page.height_px));
  }
  std::vector<Shot> out;
  const auto add = [&](Kind kind, std::int64_t frame, const std::vector<Camera>& by) {
    for (const Camera& camera : by) out.push_back({kind, frame, camera});
  };
  add(Kind::before, view.frames().front(), halves);
  for (const std::int64_t frame : view.frames()) {
    const bool still = std::ranges::binary_search(stills, frame);
    if (still) add(Kind::frame, frame, frame_cameras);
    if (!still && std::ranges::binary_search(cells, frame)) add(Kind::sheet, frame, {frame_cameras.front()});
    add(Kind::film, frame, film);
  }
  const std::int64_t last = view.frames().back();
  if (options.stills) add(Kind::after, last, cameras);
  add(Kind::after_half, last, halves);
  add(Kind::turntable, last, turntable);
  return out;
}

int count_pictures(const PictureOptions& options, const std::vector<std::int64_t>& frames, const FrameSpans& contact) {
  const RenderSettings& settings = options.settings;
  const std::size_t cameras = settings.cameras.size() + settings.user_cameras.size();
  std::size_t sum = options.stills ? cameras * (1 + still_frames(frames, settings, contact).size()) : 0;
  if (settings.before_after) sum += cameras;
  if (settings.contact_sheet) ++sum;
  if (options.film && settings.film != FilmFormat::none) sum += frames.size();
  return static_cast<int>(sum) + settings.turntable_pictures;
}

namespace {

/// Writes pictures on another thread, and reports progress.
class PngWriter {
 public:
  PngWriter(PictureProgress progress, int total, const PictureOptions& options)
      : progress_(std::move(progress)), total_(total), written_(options.written) {}

  void write(const std::string& path, PixelImage image) {
    finish();
    writing_ = std::async(std::launch::async, [this, path, image = std::move(image)]() mutable {
      write_png(path, image);
      if (written_) written_(path, image);
      return path;
    });
  }

  /// Waits for the current picture; throws the exceptions of writing it.
  void finish() {
    if (writing_.valid()) count(writing_.get());
  }

  /// Counts a picture.
  void count(const std::string& path) {
    if (progress_) progress_(++done_, total_, path);
  }

 private:
  PictureProgress progress_;
  int total_;
  decltype(PictureOptions::written) written_;
  int done_ = 0;
  std::future<std::string> writing_;  ///< gives the path
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
        captions_(run.log(), options.settings.force_arrow),
        report_(report),
        cells_(options.settings.contact_sheet ? ContactSheet::frames_on(view_) : std::vector<std::int64_t>()),
        writer_(progress, count_pictures(options, view_.frames(), run.contact()), options) {
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
        add_cell(frame, std::move(frame.image));
        break;
      case Shot::Kind::film:
        if (!film_) film_.emplace(film_path("reamed"), view_, captions_, frame.camera);
        film_->add(std::move(frame.image), view_.run().row_of(frame.frame));
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
    const PageLayout page = frame.kind == Shot::Kind::frame ? view_.frame_page() : view_.page();
    return annotated_picture(std::move(frame.image), page, frame.camera, labels, view_.settings().background);
  }

  void add_cell(const Shot& shot, PixelImage image) {
    if (!sheet_) sheet_.emplace(view_, shot.camera);
    sheet_->add(std::move(image), view_.run().row_of(shot.frame));
    if (sheet_->is_full()) writer_.write(dir_ + "/contact_sheet.png", sheet_->finish());
  }

  void add_frame(RenderedFrame& frame) {
    const ForceRow& row = view_.run().row_of(frame.frame);
    const bool first = frame.camera.name == camera_names(view_.settings()).front();
    if (first && std::ranges::binary_search(cells_, frame.frame)) add_cell(frame, frame.image);
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
  std::vector<std::int64_t> cells_;           ///< frames on the contact sheet
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
