#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/camera.h"
#include "render/finished_run.h"
#include "render/force_log.h"
#include "render/overlay.h"
#include "render/render.h"

namespace reamsim {

/// A run's results before the cameras. It shows the last state first, which says how far the depth legend must go; then
/// it goes through the snapshots from the first.
class Studio {
 public:
  /// Shows the last state, to which the run's fill returns when the studio closes. `report`, where given, gets the
  /// warning of make_context(). Throws as render_pictures() does.
  Studio(const FinishedRun& run, const RenderSettings& settings, double mean_travel_mm, Report* report);
  ~Studio();

  /// Back to the bone before the first snapshot.
  void rewind();
  /// Puts the next snapshot's bricks into the bone, and shows that.
  void advance_to(std::int64_t frame);

  /// A camera by its name: one of camera_names() or the user's. Throws InputError.
  [[nodiscard]] Camera camera(const std::string& name, int width_px, int height_px) const;
  /// The same a little closer, for pictures without labels of their own; a user's camera stays as it is.
  [[nodiscard]] Camera closer_camera(const std::string& name, int width_px, int height_px) const;

  /// What the camera sees now, without labels. `tool`, where given: its pose with the spin.
  [[nodiscard]] PixelImage photograph(const Camera& camera, const std::optional<Rigid>& tool);
  /// The same for a film: in half the time, its edges smoothed afterwards and not by several samples per pixel.
  [[nodiscard]] PixelImage film_frame(const Camera& camera, const std::optional<Rigid>& tool);
  /// The labels that each picture of this camera has: legends and directions; and the tool's outline, face on.
  [[nodiscard]] Labels labels(const Camera& camera, const std::optional<Rigid>& tool) const;

  /// The bone's force on the tool, from the tool's tip; none where the settings want none or there is next to none.
  [[nodiscard]] std::optional<ForceArrow> force_arrow(const ForceRow& row) const;
  /// The tool's pose in a row of the log; none where the settings want none.
  [[nodiscard]] std::optional<Rigid> tool_at(const ForceRow& row) const;
  /// The log's row of a frame that has a snapshot. Throws InputError when the log is shorter.
  [[nodiscard]] const ForceRow& row_of(std::int64_t frame) const;
  [[nodiscard]] const ForceLog& log() const;
  /// Those that have a snapshot, ascending.
  [[nodiscard]] const std::vector<std::int64_t>& frames() const;
  [[nodiscard]] const Subject& subject() const;
  [[nodiscard]] const RenderSettings& settings() const;
  /// Depth of the last state, mm.
  [[nodiscard]] double deepest_mm() const;
  /// Stands before the names of forces that are means.
  [[nodiscard]] const std::string& mean() const;

 private:
  struct Set;

  [[nodiscard]] PixelImage draw(const Camera& camera, const std::optional<Rigid>& tool, bool for_film);

  std::unique_ptr<Set> set_;  ///< keeps OpenVDB and OpenGL out of this header
};

}  // namespace reamsim
