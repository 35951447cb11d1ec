#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "render/gl/pixel_image.h"
#include "render/pictures/run_view.h"

namespace reamsim {

/// Renders the states of a run. It begins with the first snapshot, and goes forward from there. For the thread that
/// made it, which owns the graphics context.
class Renderer {
 public:
  /// `view` outlives it. Throws InputError where the first snapshot is missing or damaged, RunError without a graphics
  /// context.
  explicit Renderer(const RunView& view);
  ~Renderer();

  /// Applies all snapshots up to this frame's to the bone.
  void advance_to(std::int64_t frame);
  void advance_to_last() { advance_to(view_.frames().back()); }

  /// What the camera sees now, without labels. `tool`, where given: its pose with the spin. For a film in half the
  /// time: edges are smoothed afterwards, not by several samples per pixel.
  [[nodiscard]] PixelImage render(const Camera& camera, const std::optional<Rigid>& tool, bool for_film = false);

  /// The greatest depth of the surface now, mm.
  [[nodiscard]] double deepest_mm() const;
  /// Says that the requested graphics context is not available and the other one is used; else empty.
  [[nodiscard]] const std::string& warning() const;

 private:
  struct State;

  const RunView& view_;
  std::unique_ptr<State> state_;  ///< keeps OpenGL out of this header
};

}  // namespace reamsim
