#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "render/frame_queue.h"
#include "render/pictures/run_view.h"

namespace reamsim {

/// Renders the frames of a run's pictures on a separate thread, each as soon as its snapshot is written. Another thread
/// draws the labels later, because they need the log. Pauses while the frames that wait for next() take a sixteenth of
/// the machine's memory or a gigabyte.
class RenderThread {
 public:
  RenderThread(const RunData& run, const PictureOptions& options);
  /// Stops the thread, even before the end of the run.
  ~RenderThread();
  RenderThread(const RenderThread&) = delete;
  RenderThread& operator=(const RenderThread&) = delete;

  /// Call it when all snapshots up to and including that of this frame are on disk.
  void snapshots_written(std::int64_t frame);
  /// Waits for the next frame, in the order of the run and at each state in the order of RenderedFrame::Kind; nullopt
  /// after the last. Throws what rendering threw: InputError, RunError, bad_alloc.
  std::optional<RenderedFrame> next() { return queue_.pop(); }
  /// After next() has returned: a warning where another graphics context than the requested is used; else empty.
  [[nodiscard]] const std::string& warning() const { return warning_; }

 private:
  class Pass;
  struct Stopped {};  ///< thrown to stop the thread; never leaves it

  void work(const RunData& run, const PictureOptions& options);
  void wait_for_snapshot(std::int64_t frame);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::int64_t written_ = -1;
  bool stop_ = false;
  FrameQueue queue_;
  std::string warning_;
  std::thread thread_;  ///< last, because it uses the other members
};

}  // namespace reamsim
