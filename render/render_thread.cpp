#include "render/render_thread.h"

#include <algorithm>
#include <exception>
#include <utility>

#include "render/frame_schedule.h"
#include "render/pictures/renderer.h"
#include "sim/bone/voxmap/lattice.h"

namespace reamsim {
namespace {

/// What frames may take until next() takes them: this fraction of the machine's memory, and at most so much.
constexpr double kWaitingFraction = 1.0 / 16;
constexpr double kMostWaiting_bytes = 1e9;

}  // namespace

/// One pass through the run.
class RenderThread::Pass {
 public:
  Pass(RenderThread& thread, const RunView& view, const PictureOptions& options)
      : thread_(thread), view_(view), schedule_(view, options) {}

  void render_all() {
    thread_.wait_for_snapshot(view_.frames().front());
    Renderer renderer(view_);
    thread_.warning_ = renderer.warning();
    by_each(renderer, RenderedFrame::Kind::before, schedule_.halves);
    if (schedule_.along_the_run()) {
      for (const std::int64_t frame : view_.frames()) along_the_run(renderer, frame);
    }
    thread_.wait_for_snapshot(view_.frames().back());
    renderer.advance_to_last();
    if (schedule_.stills) by_each(renderer, RenderedFrame::Kind::after, schedule_.cameras);
    by_each(renderer, RenderedFrame::Kind::after_half, schedule_.halves);
    by_each(renderer, RenderedFrame::Kind::turntable, schedule_.turntable);
  }

 private:
  void along_the_run(Renderer& renderer, std::int64_t frame) {
    thread_.wait_for_snapshot(frame);
    renderer.advance_to(frame);
    const std::optional<Rigid> tool = view_.tool_at(frame);
    if (std::ranges::binary_search(schedule_.still_frames, frame)) {
      by_each(renderer, RenderedFrame::Kind::frame, schedule_.cameras, frame, tool);
    }
    if (std::ranges::binary_search(schedule_.sheet_frames, frame)) {
      by_each(renderer, RenderedFrame::Kind::sheet, {*schedule_.sheet}, frame, tool);
    }
    if (schedule_.film) by_each(renderer, RenderedFrame::Kind::film, {*schedule_.film}, frame, tool);
  }

  void by_each(Renderer& renderer, RenderedFrame::Kind kind, const std::vector<Camera>& cameras, std::int64_t frame = 0,
               const std::optional<Rigid>& tool = {}) {
    for (std::size_t i = 0; i < cameras.size(); ++i) {
      PixelImage image = renderer.render(cameras[i], tool, kind == RenderedFrame::Kind::film);
      if (!thread_.queue_.push({kind, i, frame, renderer.deepest_mm(), std::move(image)})) throw Stopped();
    }
  }

  RenderThread& thread_;
  const RunView& view_;
  FrameSchedule schedule_;
};

RenderThread::RenderThread(const RunData& run, const PictureOptions& options)
    : queue_(static_cast<std::size_t>(std::min(kMostWaiting_bytes, kWaitingFraction * machine_memory_bytes()))),
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
    if (count_pictures(options, view.frames()) > 0) Pass(*this, view, options).render_all();
    queue_.end(nullptr);
  } catch (const Stopped&) {
    queue_.end(nullptr);
  } catch (...) {
    queue_.end(std::current_exception());
  }
}

}  // namespace reamsim
