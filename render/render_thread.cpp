// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/render_thread.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "render/film/film.h"
#include "render/pictures/composites.h"
#include "render/pictures/renderer.h"
#include "sim/bone/voxmap/voxel_grid.h"
#include "sim/scenario/picture_frames.h"

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

/// One pass through the run.
class RenderThread::Pass {
 public:
  Pass(RenderThread& thread, const RunView& view, const PictureOptions& options)
      : thread_(thread), view_(view), schedule_(view, options) {}

  void render_all() {
    thread_.wait_for_snapshot(view_.frames().front());
    Renderer renderer(view_);
    thread_.warning_ = renderer.warning();
    thread_.context_ = renderer.context();
    render_cameras(renderer, RenderedFrame::Kind::before, schedule_.halves);
    if (schedule_.renders_during_run()) {
      for (const std::int64_t frame : view_.frames()) render_frame(renderer, frame);
    }
    thread_.wait_for_snapshot(view_.frames().back());
    renderer.advance_to_last();
    if (schedule_.stills) render_cameras(renderer, RenderedFrame::Kind::after, schedule_.cameras);
    render_cameras(renderer, RenderedFrame::Kind::after_half, schedule_.halves);
    render_cameras(renderer, RenderedFrame::Kind::turntable, schedule_.turntable);
  }

 private:
  void render_frame(Renderer& renderer, std::int64_t frame) {
    thread_.wait_for_snapshot(frame);
    renderer.advance_to(frame);
    const std::optional<PlacedTool> tool = view_.tool_at(frame);
    if (std::ranges::binary_search(schedule_.still_frames, frame)) {
      render_cameras(renderer, RenderedFrame::Kind::frame, schedule_.cameras, frame, tool);
    }
    if (std::ranges::binary_search(schedule_.sheet_frames, frame)) {
      render_cameras(renderer, RenderedFrame::Kind::sheet, {*schedule_.sheet}, frame, tool);
    }
    if (schedule_.film) render_cameras(renderer, RenderedFrame::Kind::film, {*schedule_.film}, frame, tool);
  }

  void render_cameras(Renderer& renderer, RenderedFrame::Kind kind, const std::vector<Camera>& cameras,
                      std::int64_t frame = 0, const std::optional<PlacedTool>& tool = {}) {
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      PixelImage image = renderer.render(cameras[i], tool, kind == RenderedFrame::Kind::film);
      const bool numbered = kind != RenderedFrame::Kind::sheet && !(tool && cameras[i].shows_tool);
      std::vector<SeenContour> contours;
      if (numbered) contours = renderer.contours(cameras[i]);
      RenderedFrame out{kind, i, frame, renderer.deepest_mm(), std::move(contours), std::move(image)};
      if (!thread_.queue_.push(std::move(out))) throw Stopped();
    }
  }

  RenderThread& thread_;
  const RunView& view_;
  FrameSchedule schedule_;
};

RenderThread::RenderThread(const RunData& run, const PictureOptions& options)
    : queue_(static_cast<std::size_t>(std::min(kMaxWaiting_bytes, kWaitingFraction * machine_memory_bytes()))),
      thread_([this, run, options] { work(run, options); }) {}

RenderThread::~RenderThread() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  queue_.close();
  thread_.join();
}

void RenderThread::snapshots_written(std::int64_t frame) {
  {
    const std::lock_guard lock(mutex_);
    written_ = std::max(written_, frame);
  }
  changed_.notify_all();
}

void RenderThread::wait_for_snapshot(std::int64_t frame) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return stop_ || written_ >= frame; });
  if (stop_) throw Stopped();
}

void RenderThread::work(const RunData& run, const PictureOptions& options) {
  try {
    const RunView view(run, options.settings);
    if (count_pictures(options, view.frames(), run.contact()) > 0) Pass(*this, view, options).render_all();
    queue_.finish(nullptr);
  } catch (const Stopped&) {
    queue_.finish(nullptr);
  } catch (...) {
    queue_.finish(std::current_exception());
  }
}

FrameSchedule::FrameSchedule(const RunView& view, const PictureOptions& options)
    : names(names_of(view.settings().cameras)), stills(options.stills) {
  const RenderSettings& settings = view.settings();
  const PageLayout page = view.page();
  for (const UserCamera& own : settings.user_cameras) names.push_back(own.name);
  for (const std::string& name : names) {
    cameras.push_back(view.camera(name, page.view_width_px, page.height_px));
    if (settings.before_after) halves.push_back(half_camera(view, name));
  }
  if (stills) still_frames = reamsim::still_frames(view.frames(), settings, view.run().contact());
  if (settings.contact_sheet) {
    sheet_frames = ContactSheet::frames_on(view);
    sheet = ContactSheet::cell_camera(view, names.front());
  }
  if (options.film && settings.film != FilmFormat::none) film = film_camera(view, names.front());
  for (int i = 0; i < settings.turntable_pictures; ++i) {
    const double turn = static_cast<double>(i) / settings.turntable_pictures;
    turntable.push_back(make_turntable_camera(view.run().target(), turn, page.view_width_px, page.height_px));
  }
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

}  // namespace reamsim
