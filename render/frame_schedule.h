#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "render/pictures/run_view.h"

namespace reamsim {

/// The frames of a run to render, and their cameras.
struct FrameSchedule {
  /// Throws InputError for an invalid camera.
  FrameSchedule(const RunView& view, const PictureOptions& options);

  [[nodiscard]] bool along_the_run() const { return !still_frames.empty() || !sheet_frames.empty() || film; }
  std::vector<std::string> names;          ///< of the cameras, user cameras last
  bool stills = false;                     ///< of the run's frames and of its last state
  std::vector<Camera> cameras;             ///< of the stills
  std::vector<std::int64_t> still_frames;  ///< ascending
  std::vector<Camera> halves;              ///< of before/after pictures; empty without them
  std::optional<Camera> sheet;             ///< of the contact sheet's cells
  std::vector<std::int64_t> sheet_frames;  ///< ascending
  std::optional<Camera> film;
  std::vector<Camera> turntable;
};

/// Number of pictures of a run with snapshots of these frames, including the frames of a film.
int count_pictures(const PictureOptions& options, const std::vector<std::int64_t>& frames);

}  // namespace reamsim
