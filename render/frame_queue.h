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
    before,      ///< left half of a before/after picture
    frame,       ///< a frame of the run
    sheet,       ///< a cell of the contact sheet
    film,        ///< a frame of the film
    after,       ///< the last state
    after_half,  ///< right half of a before/after picture
    turntable,   ///< the last state
  };
  Kind kind;
  std::size_t camera = 0;  ///< index into the cameras of this kind in FrameSchedule
  std::int64_t frame = 0;  ///< of the run
  double deepest_mm = 0;   ///< greatest depth that it shows
  PixelImage image;
};

/// A queue of rendered frames between two threads. All members are thread-safe.
class FrameQueue {
 public:
  /// Holds images of at most this size in total, or one image.
  explicit FrameQueue(std::size_t most_bytes) : most_bytes_(most_bytes) {}

  /// Waits for space. Returns false after close().
  bool push(RenderedFrame frame);
  /// Marks the end. pop() throws `error`, where not null, once the queue is empty.
  void end(std::exception_ptr error);
  /// Waits for the next frame; nullopt after the last.
  std::optional<RenderedFrame> pop();
  /// Rejects further frames.
  void close();

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<RenderedFrame> frames_;
  std::size_t bytes_ = 0;
  std::size_t most_bytes_;
  bool ended_ = false;
  bool closed_ = false;
  std::exception_ptr error_;
};

}  // namespace reamsim
