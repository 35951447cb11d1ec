// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "render/pictures/run_view.h"
#include "sim/scenario/picture_frames.h"

namespace reamsim {

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
