// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "render/film/film.h"
#include "render/pictures/run_view.h"
#include "sim/base/error.h"
#include "sim/scenario/picture_frames.h"

namespace reamsim {

/// One picture of a state of a run.
struct Shot {
  enum class Kind {
    before,      ///< left half of a before/after picture
    frame,       ///< a frame of the run
    sheet,       ///< a cell of the contact sheet
    film,        ///< a frame of the film
    after,       ///< the final state
    after_half,  ///< right half of a before/after picture
    turntable,   ///< the final state, turned
  };
  Kind kind;
  std::int64_t frame = 0;  ///< of the run
  Camera camera{};
};

/// A shot as rendered, without labels.
struct RenderedFrame : Shot {
  double deepest_mm = 0;                ///< of the state
  std::vector<SeenContour> contours{};  ///< that get their numbers: none where the tool may hide them
  PixelImage image{};
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

/// Renders a run's pictures on its own thread, as soon as their snapshots are written, without labels, which need the
/// log. Pauses while the frames that wait for next() occupy a sixteenth of the machine's memory, or a gigabyte.
class RenderThread {
 public:
  RenderThread(const RunData& run, const PictureOptions& options);
  /// Stops the thread.
  ~RenderThread();
  RenderThread(const RenderThread&) = delete;
  RenderThread& operator=(const RenderThread&) = delete;

  /// Announces that the snapshots up to this frame are on disk.
  void snapshots_written(std::int64_t frame);
  /// Waits for the next frame, by state and Shot::Kind; none after the last. Throws InputError, RunError, bad_alloc.
  std::optional<RenderedFrame> next() { return queue_.pop(); }
  /// After next() has returned: a warning if the requested graphics context is not available; else empty.
  [[nodiscard]] const std::string& warning() const { return warning_; }
  /// After next() has returned: what renders (OffscreenContext::description()).
  [[nodiscard]] const std::string& context() const { return context_; }

 private:
  struct Stopped {};  ///< thrown, and caught, within the thread to stop it

  void work(const RunData& run, const PictureOptions& options);
  void render(const RunView& view, const std::vector<Shot>& shots);
  void wait_for_snapshot(std::int64_t frame);

  std::atomic<std::int64_t> written_ = -1;  ///< frame of the last snapshot on disk
  std::atomic<bool> stop_ = false;
  FrameQueue queue_;
  std::string warning_;
  std::string context_;
  std::thread thread_;  ///< last member, because it uses the others
};

/// What is rendered of a run, in the order of the states. Throws InputError for an invalid camera.
std::vector<Shot> shots_of(const RunView& view, const PictureOptions& options);

/// The names of the cameras, the user's last.
std::vector<std::string> camera_names(const RenderSettings& settings);

/// The number of pictures of a run with these snapshots and this contact, counting each frame of a film.
int count_pictures(const PictureOptions& options, const std::vector<std::int64_t>& frames, const FrameSpans& contact);

/// Called after each picture: (done, total, file).
using PictureProgress = std::function<void(int, int, const std::string&)>;

/// Makes the pictures of a run, as the options say: DIR/frames/NNNNNN[_camera].png, DIR/reamed[_camera].png (the final
/// state without the tool), DIR/before_after[_camera].png, DIR/contact_sheet.png, DIR/turntable/NNN.png, and the films
/// DIR/reamed.mp4 and DIR/turntable.mp4 (or .webp, .apng). `report` gets RenderThread::warning(), and one when a
/// picture of the final state looks empty. `thread` renders the same run with the same options. Returns its context().
/// Throws InputError (a result missing or damaged, a camera unknown), RunError (a picture cannot be made or written).
std::string render_pictures(const RunData& run, const PictureOptions& options,
                            const PictureProgress& progress = nullptr, Diagnostics* report = nullptr,
                            RenderThread* thread = nullptr);

}  // namespace reamsim
