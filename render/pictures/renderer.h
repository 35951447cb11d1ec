// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "render/gl/pixel_image.h"
#include "render/pictures/contour_labels.h"
#include "render/pictures/run_view.h"

namespace reamsim {

/// Renders the states of a run in ascending order, from the first snapshot on. Only for the thread that constructed it,
/// which owns the graphics context.
class Renderer {
 public:
  /// `view` outlives it. Throws InputError when the first snapshot is missing or damaged, RunError without a graphics
  /// context.
  explicit Renderer(const RunView& view);
  ~Renderer();
  Renderer(const Renderer&) = delete;
  Renderer& operator=(const Renderer&) = delete;

  /// Applies all snapshots up to this frame to the bone.
  void advance_to(std::int64_t frame);
  void advance_to_last() { advance_to(view_.frames().back()); }
  /// Shows the bone with this fill.
  void show(const FillBricks& fill);

  /// The current picture without labels, and without a tool if the camera shows none. `for_film`: antialiasing by a
  /// filter, in half the time.
  [[nodiscard]] PixelImage render(const Camera& camera, const std::optional<PlacedTool>& tool, bool for_film = false);

  /// The contour lines of the current surface as a camera sees them.
  [[nodiscard]] std::vector<SeenContour> contours(const Camera& camera) const;
  /// The greatest depth of the current surface, mm.
  [[nodiscard]] double deepest_mm() const;
  /// A warning if the requested graphics context is not available and the other one is used; else empty.
  [[nodiscard]] const std::string& warning() const;
  /// What renders (OffscreenContext::description()).
  [[nodiscard]] std::string context() const;

 private:
  struct State;

  void update_bone();
  void update_contours();

  const RunView& view_;
  std::unique_ptr<State> state_;  ///< keeps OpenGL out of this header
};

}  // namespace reamsim
