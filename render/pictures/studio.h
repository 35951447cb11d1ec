#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "render/gl/pixel_image.h"
#include "render/pictures/run_view.h"

namespace reamsim {

/// A run's bone before the cameras. It opens on the first snapshot, and goes forward from there. Its pictures are to be
/// taken by the thread that opened it, which owns the graphics context.
class Studio {
 public:
  /// `view` outlives it. Throws InputError where the first snapshot is missing or damaged, RunError without a graphics
  /// context.
  explicit Studio(const RunView& view);
  ~Studio();

  /// Puts all snapshots up to this frame's into the bone, and shows that.
  void advance_to(std::int64_t frame);
  void advance_to_last() { advance_to(view_.frames().back()); }

  /// What the camera sees now, without labels. `tool`, where given: its pose with the spin.
  [[nodiscard]] PixelImage photograph(const Camera& camera, const std::optional<Rigid>& tool);
  /// The same for a film: in half the time, its edges smoothed afterwards and not by several samples per pixel.
  [[nodiscard]] PixelImage film_frame(const Camera& camera, const std::optional<Rigid>& tool);

  /// Depth of what it shows, mm.
  [[nodiscard]] double deepest_mm() const;
  /// Says that the wanted context was not to be had and the other one is used; else empty.
  [[nodiscard]] const std::string& warning() const;

 private:
  struct Set;

  [[nodiscard]] PixelImage draw(const Camera& camera, const std::optional<Rigid>& tool, bool for_film);

  const RunView& view_;
  std::unique_ptr<Set> set_;  ///< keeps OpenVDB and OpenGL out of this header
};

}  // namespace reamsim
