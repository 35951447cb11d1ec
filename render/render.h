// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <algorithm>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "render/pictures/run_view.h"
#include "sim/base/error.h"
#include "sim/base/process.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// One picture of a state of a run.
struct Shot {
  enum class Kind {
    before,      ///< left half of a before/after picture
    frame,       ///< a frame of the run
    sheet,       ///< a frame of the run that only the contact sheet shows
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
  void work(const RunData& run, const PictureOptions& options);
  void render(const RunView& view, const std::vector<Shot>& shots);
  /// Returns false where the thread is to stop.
  bool wait_for_snapshot(std::int64_t frame);

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

/// To be called before a run: throws RunError, with what to install, when no ffmpeg can write the film of the settings.
void require_film_program(const RenderSettings& settings);

/// Pipes pictures to ffmpeg, which writes a film. The file gets its name when it is complete.
class FilmEncoder {
 public:
  /// Odd sizes lose a pixel, because H.264 needs even ones. Throws RunError: no ffmpeg.
  FilmEncoder(const std::string& path, const RenderSettings& settings);
  /// Without finish(): stops ffmpeg and removes its file.
  ~FilmEncoder();
  FilmEncoder(const FilmEncoder&) = delete;
  FilmEncoder& operator=(const FilmEncoder&) = delete;

  /// Adds a frame of the settings' or the film's size. Throws RunError with ffmpeg's message when it has exited.
  void add(const PixelImage& image);
  /// Completes the film and renames it. Throws RunError.
  void finish();

 private:
  /// Waits for ffmpeg. Throws RunError with its message if it failed.
  void wait();
  [[noreturn]] void fail(const std::string& messages) const;

  int width_px_;
  int height_px_;
  std::string path_;
  std::string partial_path_;
  int pictures_fd_ = -1;  ///< our end of ffmpeg's standard input
  MemoryFile messages_;   ///< stderr of ffmpeg
  pid_t child_ = -1;
};

/// Axial force, spin torque and the feed rate of a push against time: the whole run pale, the past opaque, a cursor.
class ForcePanel {
 public:
  /// Draws the static background. Sizes in pixels; `unit`: pixels per pixel of a film 1080 high. `log` outlives the
  /// panel. Throws RunError.
  ForcePanel(const ForceLog& log, int width_px, int height_px, double unit);

  /// The panel at the time of a row of the log. Throws RunError.
  [[nodiscard]] PixelImage at(const ForceRow& row) const;

  /// The plot area of a curve: 0 force, 1 torque, 2 feed rate.
  [[nodiscard]] const Box& plot(int curve) const { return curves_.at(static_cast<std::size_t>(curve)).box; }
  /// Pixels from the panel's left edge.
  [[nodiscard]] double x_of(double time_s) const;

 private:
  struct Curve {
    std::string title, unit;
    double (*value)(const ForceRow&);
    int decimals;
    std::uint32_t rgb;
    Box box;
    double min = 0, max = 1, step = 0.2;  ///< of the axis
    std::vector<double> low{}, high{};    ///< extremes per column of pixels
  };

  void compute_envelope(Curve& curve) const;
  void draw_frame(const class Canvas& canvas, const Curve& curve) const;
  void draw_time_axis(const class Canvas& canvas) const;
  /// Draws the curve up to a column.
  void draw_curve(const class Canvas& canvas, const Curve& curve, std::size_t columns, double opacity) const;
  [[nodiscard]] double y_of(const Curve& curve, double value) const;
  [[nodiscard]] double grid_px() const { return std::max(1.0, 1.2 * unit_); }  ///< width of its lines

  const ForceLog& log_;
  double unit_;
  double first_s_ = 0;
  double last_s_ = 1;
  std::vector<Curve> curves_;
  PixelImage background_;
};

/// The layout of a film: the bone, with the force panel beside it, or below it in portrait format.
struct FilmLayout {
  int width_px, height_px;  ///< of the film; even, for H.264
  Box bone, panel;          ///< whole pixels; panel.width is 0 if a plot would be illegible
  double unit;              ///< pixels per pixel of a film 1080 high
};
FilmLayout film_layout(int width_px, int height_px);
/// The camera `name` for the bone's part of the film.
Camera film_camera(const RunView& view, const std::string& name);

/// The film of a run: one frame per snapshot, with force and torque beside the bone.
class Film {
 public:
  /// `view` and `captions` outlive it. Throws RunError: no ffmpeg.
  Film(const std::string& path, const RunView& view, const Captions& captions, const Camera& camera);

  /// Adds a frame: the bone at this row of the log.
  void add(PixelImage bone, const ForceRow& row);
  void finish() { encoder_.finish(); }

 private:
  const RunView& view_;
  const Captions& captions_;
  FilmLayout layout_;
  Camera camera_;
  std::unique_ptr<ForcePanel> panel_;  ///< null if it would be illegible
  FilmEncoder encoder_;
};

}  // namespace reamsim
