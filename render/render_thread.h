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

/// Renders all frames that a run's pictures are made from on a thread of its own: as soon as a snapshot is written,
/// beside the simulation. Labels need the log and are drawn later, by another thread. It goes once through the run, and
/// pauses while the frames that wait for next() take a sixteenth of the machine's memory, or a gigabyte.
class RenderThread {
 public:
  RenderThread(const RunData& run, const PictureOptions& options);
  /// Stops it, if need be before the run's end.
  ~RenderThread();
  RenderThread(const RenderThread&) = delete;
  RenderThread& operator=(const RenderThread&) = delete;

  /// All snapshots up to and including this frame's are on disk.
  void snapshots_written(std::int64_t frame);
  /// Waits for the next frame, in the order of the run, and at each state in that of RenderedFrame::Kind; none after
  /// the last. Throws what rendering it threw: InputError, RunError, bad_alloc.
  std::optional<RenderedFrame> next() { return queue_.pop(); }
  /// Once next() has returned: says that the requested graphics context is not available and the other one is used;
  /// else empty.
  [[nodiscard]] const std::string& warning() const { return warning_; }

 private:
  class Pass;
  struct Stopped {};  ///< thrown where the thread is to stop; never leaves it

  void work(const RunData& run, const PictureOptions& options);
  void wait_for_snapshot(std::int64_t frame);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::int64_t written_ = -1;
  bool stop_ = false;
  FrameQueue queue_;
  std::string warning_;
  std::thread thread_;  ///< last, because it uses the others
};

}  // namespace reamsim
