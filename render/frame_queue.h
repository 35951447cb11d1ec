#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>

#include "render/gl/pixel_image.h"

namespace reamsim {

/// One rendered frame of a run, without labels.
struct RenderedFrame {
  enum class Kind {
    before,      ///< the left half of a picture with before and after; by camera
    frame,       ///< a frame of the run; by camera
    sheet,       ///< a cell of the contact sheet
    film,        ///< a frame of the film
    after,       ///< the last state; by camera
    after_half,  ///< the right half of a picture with before and after; by camera
    turntable,   ///< the last state; by turn
  };
  Kind kind;
  std::size_t camera = 0;  ///< which one of those in FrameSchedule, or which turn
  std::int64_t frame = 0;  ///< of the run
  double deepest_mm = 0;   ///< of what it shows
  PixelImage image;
};

/// Rendered frames on their way from one thread to another. All members may be called by any thread.
class FrameQueue {
 public:
  /// Has room for images of so many bytes, and at least for one.
  explicit FrameQueue(std::size_t most_bytes) : most_bytes_(most_bytes) {}

  /// Waits for room. Returns false after close().
  bool push(RenderedFrame frame);
  /// There will be no more. `why`, where not null, is thrown by pop() once the queue is empty.
  void end(std::exception_ptr why);
  /// Waits for the next one; none after the last.
  std::optional<RenderedFrame> pop();
  /// No more frames are accepted.
  void close();

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<RenderedFrame> frames_;
  std::size_t bytes_ = 0;
  std::size_t most_bytes_;
  bool ended_ = false;
  bool closed_ = false;
  std::exception_ptr why_;
};

}  // namespace reamsim
