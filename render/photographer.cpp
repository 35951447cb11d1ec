#include "render/photographer.h"

#include <algorithm>
#include <exception>
#include <thread>
#include <utility>

#include "render/picture_list.h"
#include "render/pictures/photo_queue.h"
#include "render/pictures/studio.h"
#include "sim/bone/voxmap/lattice.h"

namespace reamsim {
namespace {

/// The share of the machine's memory that photographs may take until somebody takes them, and the most.
constexpr double kWaitingShare = 1.0 / 16;
constexpr double kMostWaiting_bytes = 1e9;

/// Thrown where a photographer is to stop; never leaves its thread.
struct Stopped {};

/// What is in front of the thread: it goes once through the run.
class Session {
 public:
  Session(const RunView& view, const PictureChoice& choice, SnapshotFeed& snapshots, PhotoQueue& queue)
      : view_(view), list_(view, choice), snapshots_(snapshots), queue_(queue) {}

  /// `warning` gets the studio's, before the first photograph is handed on.
  void take_all(std::string& warning) {
    if (list_.pictures(view_) == 0) return;
    wait_for(view_.frames().front());
    Studio studio(view_);
    warning = studio.warning();
    for (std::size_t i = 0; i < list_.halves.size(); ++i) {
      hand_on(studio, {.of = Photo::Of::before, .camera = i, .image = studio.photograph(list_.halves[i], {})});
    }
    if (list_.along_the_run()) {
      for (const std::int64_t frame : view_.frames()) along_the_run(studio, frame);
    }
    wait_for(view_.frames().back());
    studio.advance_to_last();
    last_state(studio);
  }

 private:
  void wait_for(std::int64_t frame) {
    if (!snapshots_.wait_for(frame)) throw Stopped();
  }

  void hand_on(const Studio& studio, Photo photo) {
    photo.deepest_mm = studio.deepest_mm();
    if (!queue_.push(std::move(photo))) throw Stopped();
  }

  void along_the_run(Studio& studio, std::int64_t frame) {
    wait_for(frame);
    studio.advance_to(frame);
    const std::optional<Rigid> tool = view_.tool_at(frame);
    if (std::ranges::binary_search(list_.still_frames, frame)) {
      for (std::size_t i = 0; i < list_.cameras.size(); ++i) {
        hand_on(
            studio,
            {.of = Photo::Of::frame, .camera = i, .frame = frame, .image = studio.photograph(list_.cameras[i], tool)});
      }
    }
    if (std::ranges::binary_search(list_.sheet_frames, frame)) {
      hand_on(studio, {.of = Photo::Of::sheet, .frame = frame, .image = studio.photograph(*list_.sheet, tool)});
    }
    if (list_.film) {
      hand_on(studio, {.of = Photo::Of::film, .frame = frame, .image = studio.film_frame(*list_.film, tool)});
    }
  }

  void last_state(Studio& studio) {
    const auto take = [&](Photo::Of of, const std::vector<Camera>& cameras) {
      for (std::size_t i = 0; i < cameras.size(); ++i) {
        hand_on(studio, {.of = of, .camera = i, .image = studio.photograph(cameras[i], {})});
      }
    };
    if (list_.stills) take(Photo::Of::after, list_.cameras);
    take(Photo::Of::after_half, list_.halves);
    take(Photo::Of::turntable, list_.turntable);
  }

  const RunView& view_;
  PictureList list_;
  SnapshotFeed& snapshots_;
  PhotoQueue& queue_;
};

}  // namespace

class Photographer::Thread {
 public:
  Thread(PlannedRun run, RenderSettings settings, PictureChoice choice, SnapshotFeed& snapshots)
      : snapshots_(snapshots),
        thread_([this, run = std::move(run), settings = std::move(settings), choice = std::move(choice)] {
          work(run, settings, choice);
        }) {}
  ~Thread() {
    snapshots_.abandon();
    queue_.close();
    thread_.join();
  }
  Thread(const Thread&) = delete;
  Thread& operator=(const Thread&) = delete;

  std::optional<Photo> next() { return queue_.pop(); }
  [[nodiscard]] const std::string& warning() const { return warning_; }

 private:
  void work(const PlannedRun& run, const RenderSettings& settings, const PictureChoice& choice) {
    try {
      const RunView view(run, settings);
      Session(view, choice, snapshots_, queue_).take_all(warning_);
      queue_.end(nullptr);
    } catch (const Stopped&) {
      queue_.end(nullptr);
    } catch (...) {
      queue_.end(std::current_exception());
    }
  }

  SnapshotFeed& snapshots_;
  PhotoQueue queue_{static_cast<std::size_t>(std::min(kMostWaiting_bytes, kWaitingShare* machine_memory_bytes()))};
  std::string warning_;
  std::thread thread_;  ///< last, because it uses the others
};

Photographer::Photographer(const PlannedRun& run, const RenderSettings& settings, const PictureChoice& choice,
                           SnapshotFeed& snapshots)
    : thread_(std::make_unique<Thread>(run, settings, choice, snapshots)) {}

Photographer::~Photographer() = default;

std::optional<Photo> Photographer::next() {
  return thread_->next();
}

const std::string& Photographer::warning() const {
  return thread_->warning();
}

}  // namespace reamsim
