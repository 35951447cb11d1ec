// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "kernels/window.h"
#include "sim/base/geometry.h"

namespace reamsim {

/// Windows of frames whose motion is smooth, for `erosion: exact` (kernels/window.h). They depend on the motion alone:
/// a window is one of frames 64k … 64k + 63, or of their halves, quarters or eighths, and the same in every batch.
class MotionWindows {
 public:
  /// The substep of a frame, or nullopt where it has none or several.
  using ArgsOfFrame = std::function<std::optional<SubstepArgs>(std::int64_t frame)>;

  /// `last`: frame of the motion; `tool_box`: T, mm.
  MotionWindows(ArgsOfFrame args_of, std::int64_t last, const Aabb& tool_box);

  /// The window of a frame (≥ 1); nullptr where the motion is not smooth, or too fast.
  std::shared_ptr<const MotionWindow> of(std::int64_t frame);

 private:
  void plan(std::int64_t block);
  void split(std::int64_t first, std::int64_t end);

  ArgsOfFrame args_of_;
  std::int64_t last_;
  Aabb tool_box_;
  std::int64_t block_ = -1;                                   ///< the planned one
  std::vector<std::optional<SubstepArgs>> args_;              ///< of its frames
  std::vector<std::shared_ptr<const MotionWindow>> windows_;  ///< of its frames
};

}  // namespace reamsim
