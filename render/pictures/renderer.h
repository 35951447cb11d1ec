// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "render/gl/context.h"
#include "render/gl/scene.h"
#include "render/pictures/run_view.h"

namespace reamsim {

/// Renders the states of a run in ascending order, from the first snapshot on. Only for the thread that constructed it.
class Renderer {
 public:
  /// `view` outlives it. Throws InputError (first snapshot missing or damaged), RunError (no graphics context).
  explicit Renderer(const RunView& view);

  /// Applies all snapshots up to this frame to the bone.
  void advance_to(std::int64_t frame);
  void advance_to_last() { advance_to(view_.frames().back()); }
  void show(const FillBricks& fill);

  /// The current picture without labels, and without a tool if the camera shows none. `filtered`: as in DrawCall.
  [[nodiscard]] PixelImage render(const Camera& camera, const std::optional<PlacedTool>& tool, bool filtered = false);

  /// The contour lines of the current surface as a camera sees them.
  [[nodiscard]] std::vector<SeenContour> contours(const Camera& camera) const;
  /// The greatest depth of the current surface, mm.
  [[nodiscard]] double deepest_mm() const { return tiles_.deepest_mm(); }
  /// A warning if the requested graphics context is not available and the other one is used; else empty.
  [[nodiscard]] const std::string& warning() const { return warning_; }
  [[nodiscard]] std::string context() const { return context_->description(); }

 private:
  void update_bone();

  const RunView& view_;
  std::string warning_;
  std::unique_ptr<OffscreenContext> context_;
  BoneFields fields_;
  BoneTiles tiles_;
  Scene scene_;
  std::size_t shown_ = 0;  ///< index of the snapshot
  std::vector<SurfaceLine> contours_;
};

}  // namespace reamsim
