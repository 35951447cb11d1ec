// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#include "render/render.h"

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

void RenderThread::render(const RunView& view, const std::vector<Shot>& shots) {
  using Kind = Shot::Kind;
  wait_for_snapshot(view.frames().front());
  Renderer renderer(view);
  warning_ = renderer.warning();
  context_ = renderer.context();
  std::int64_t state = -1;
  for (const Shot& shot : shots) {
    wait_for_snapshot(shot.frame);
    if (shot.kind != Kind::before && shot.frame != state) renderer.advance_to(state = shot.frame);
    RenderedFrame out{shot, renderer.deepest_mm()};
    std::optional<PlacedTool> tool;
    if (shot.kind == Kind::frame || shot.kind == Kind::sheet || shot.kind == Kind::film) {
      tool = view.tool_at(shot.frame);
    }
    out.image = renderer.render(shot.camera, tool, shot.kind == Kind::film);
    const bool numbered = shot.kind != Kind::sheet && !(tool && shot.camera.shows_tool);
    if (numbered) out.contours = renderer.contours(shot.camera);
    if (!queue_.push(std::move(out))) throw Stopped();
  }
}

void RenderThread::work(const RunData& run, const PictureOptions& options) {
  try {
    const RunView view(run, options.settings);
    if (count_pictures(options, view.frames(), run.contact()) > 0) render(view, shots_of(view, options));
    queue_.finish(nullptr);
  } catch (const Stopped&) {
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
  const PageLayout page = view.page();
  const std::vector<std::string> names = camera_names(settings);
  std::vector<Camera> cameras, halves, cell, film, turntable;
  for (const std::string& name : names) {
    cameras.push_back(view.camera(name, page.view_width_px, page.height_px));
    if (settings.before_after) halves.push_back(half_camera(view, name));
  }
  std::vector<std::int64_t> stills, cells;
  if (options.stills) stills = still_frames(view.frames(), settings, view.run().contact());
  if (settings.contact_sheet) {
    cells = ContactSheet::frames_on(view);
    cell = {ContactSheet::cell_camera(view, names.front())};
  }
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
    if (std::ranges::binary_search(stills, frame)) add(Kind::frame, frame, cameras);
    if (std::ranges::binary_search(cells, frame)) add(Kind::sheet, frame, cell);
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

}  // namespace reamsim
