#pragma once

#include <memory>
#include <optional>
#include <string>

#include "render/pictures/photo_queue.h"
#include "render/pictures/planned_run.h"
#include "render/pictures/snapshot_feed.h"
#include "render/render.h"

namespace reamsim {

/// Takes all photographs that a run's pictures are made from, on a thread of its own: as soon as a snapshot is written,
/// beside the simulation. Labels need the log and are for others to draw. It goes once through the run, and stops for a
/// while where the photographs that nobody has taken from it come to a sixteenth of the machine's memory, or a
/// gigabyte.
class Photographer {
 public:
  /// Begins. `snapshots` outlives it.
  Photographer(const PlannedRun& run, const RenderSettings& settings, const PictureChoice& choice,
               SnapshotFeed& snapshots);
  /// Stops, if need be in the midst of the run.
  ~Photographer();
  Photographer(const Photographer&) = delete;
  Photographer& operator=(const Photographer&) = delete;

  /// The next photograph, in the order of frames, and at each frame in that of Photo::Of; none after the last. Throws
  /// what taking it threw: InputError, RunError, bad_alloc.
  std::optional<Photo> next();
  /// Once next() has returned: says that the wanted graphics context was not to be had and the other one is used; else
  /// empty.
  [[nodiscard]] const std::string& warning() const;

 private:
  class Thread;

  std::unique_ptr<Thread> thread_;
};

}  // namespace reamsim
