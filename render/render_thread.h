// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "render/pictures/run_view.h"
#include "sim/scenario/picture_frames.h"

namespace reamsim {

/// One rendered frame of a run, without labels.
struct RenderedFrame {
  enum class Kind {
    before,      ///< left half of a before/after picture; by camera
    frame,       ///< a frame of the run; by camera
    sheet,       ///< a cell of the contact sheet
    film,        ///< a frame of the film
    after,       ///< the final state; by camera
    after_half,  ///< right half of a before/after picture; by camera
    turntable,   ///< the final state; by turn
  };
  Kind kind;
  std::size_t camera = 0;               ///< index in FrameSchedule, or of the turn
  std::int64_t frame = 0;               ///< of the run
  double deepest_mm = 0;                ///< of the state
  std::vector<SeenContour> contours{};  ///< that get their numbers: none where the tool may hide them
  PixelImage image;
};

/// A bounded queue of rendered frames between two threads. Thread-safe.
class FrameQueue {
 public:
  /// Holds up to `max_bytes` of images, and at least one.
  explicit FrameQueue(std::size_t max_bytes) : max_bytes_(max_bytes) {}

  /// Waits for room. Returns false after close().
  bool push(RenderedFrame frame);
  /// Ends the sequence. pop() throws `error`, if not null, once the queue is empty.
  void finish(std::exception_ptr error);
  /// Waits for the next frame; none after the last.
  std::optional<RenderedFrame> pop();
  /// Rejects further frames.
  void close();

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<RenderedFrame> frames_;
  std::size_t bytes_ = 0;
  std::size_t max_bytes_;
  bool finished_ = false;
  bool closed_ = false;
  std::exception_ptr error_;
};

/// Renders all frames of a run's pictures on its own thread, as soon as their snapshots are written. Labels need the
/// log and are drawn later by another thread. Pauses while the frames that wait for next() occupy a sixteenth of the
/// machine's memory, or a gigabyte.
class RenderThread {
 public:
  RenderThread(const RunData& run, const PictureOptions& options);
  /// Stops the thread.
  ~RenderThread();
  RenderThread(const RenderThread&) = delete;
  RenderThread& operator=(const RenderThread&) = delete;

  /// Announces that the snapshots up to this frame are on disk.
  void snapshots_written(std::int64_t frame);
  /// Waits for the next frame, ordered by state and by RenderedFrame::Kind; none after the last. Throws the exceptions
  /// of rendering: InputError, RunError, bad_alloc.
  std::optional<RenderedFrame> next() { return queue_.pop(); }
  /// After next() has returned: a warning if the requested graphics context is not available; else empty.
  [[nodiscard]] const std::string& warning() const { return warning_; }
  /// After next() has returned: what renders (OffscreenContext::description()).
  [[nodiscard]] const std::string& context() const { return context_; }

 private:
  class Pass;
  struct Stopped {};  ///< thrown, and caught, within the thread to stop it

  void work(const RunData& run, const PictureOptions& options);
  void wait_for_snapshot(std::int64_t frame);

  std::mutex mutex_;
  std::condition_variable changed_;
  std::int64_t written_ = -1;
  bool stop_ = false;
  FrameQueue queue_;
  std::string warning_;
  std::string context_;
  std::thread thread_;  ///< last member, because it uses the others
};

/// Which frames of a run are rendered, and by which cameras.
struct FrameSchedule {
  /// Throws InputError for an invalid camera.
  FrameSchedule(const RunView& view, const PictureOptions& options);

  [[nodiscard]] bool renders_during_run() const { return !still_frames.empty() || !sheet_frames.empty() || film; }
  std::vector<std::string> names;          ///< of the cameras; the user's are last
  bool stills = false;                     ///< pictures of frames and of the final state
  std::vector<Camera> cameras;             ///< of the stills
  std::vector<std::int64_t> still_frames;  ///< ascending
  std::vector<Camera> halves;              ///< of before/after pictures; may be empty
  std::optional<Camera> sheet;             ///< of the contact sheet's cells
  std::vector<std::int64_t> sheet_frames;  ///< ascending
  std::optional<Camera> film;
  std::vector<Camera> turntable;
};

/// The number of pictures of a run with these snapshots and this contact, counting each frame of a film.
int count_pictures(const PictureOptions& options, const std::vector<std::int64_t>& frames, const FrameSpans& contact);

}  // namespace reamsim
