#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "render/pictures/run_view.h"

namespace reamsim {

/// Which frames of a run are rendered, and by which cameras.
struct FrameSchedule {
  /// Throws InputError where a camera cannot be made.
  FrameSchedule(const RunView& view, const PictureOptions& options);

  [[nodiscard]] bool along_the_run() const { return !still_frames.empty() || !sheet_frames.empty() || film; }
  std::vector<std::string> names;          ///< of the cameras, the user's last
  bool stills = false;                     ///< of the run's frames and of its last state
  std::vector<Camera> cameras;             ///< of the stills
  std::vector<std::int64_t> still_frames;  ///< ascending
  std::vector<Camera> halves;              ///< of pictures of before and after; none where those are not wanted
  std::optional<Camera> sheet;             ///< of the contact sheet's cells
  std::vector<std::int64_t> sheet_frames;  ///< ascending
  std::optional<Camera> film;
  std::vector<Camera> turntable;
};

/// How many pictures are made of a run with these snapshots, each frame of a film counted.
int count_pictures(const PictureOptions& options, const std::vector<std::int64_t>& frames);

}  // namespace reamsim
