#pragma once

#include <optional>
#include <string>

#include "render/gl/camera.h"
#include "render/pictures/overlay.h"
#include "render/pictures/planned_run.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// What is the same in every picture of a run, and known before the first: what is looked at, by which cameras, and how
/// far the legends go. Never changes, and so may be asked by several threads.
class RunView {
 public:
  /// Throws as PlannedRun does.
  RunView(const PlannedRun& run, const RenderSettings& settings);

  /// A camera by its name: a CameraView's or the user's. Throws InputError.
  [[nodiscard]] Camera camera(const std::string& name, int width_px, int height_px) const;
  /// The same a little closer, for pictures without labels of their own; a user's camera stays as it is.
  [[nodiscard]] Camera closer_camera(const std::string& name, int width_px, int height_px) const;
  /// The tool's pose in a frame, with the spin; none where the settings want no tool.
  [[nodiscard]] std::optional<Rigid> tool_at(std::int64_t frame) const;
  /// The labels that each picture of this camera has: legends and directions; and the tool's outline, face on.
  [[nodiscard]] Labels labels(const Camera& camera, const std::optional<Rigid>& tool) const;

  [[nodiscard]] const PlannedRun& run() const { return run_; }
  [[nodiscard]] const RenderSettings& settings() const { return settings_; }
  [[nodiscard]] const Scale& depth_scale() const { return depth_scale_; }
  [[nodiscard]] const Scale& density_scale() const { return density_scale_; }
  /// Those that have a snapshot, ascending.
  [[nodiscard]] const std::vector<std::int64_t>& frames() const { return run_.plan().frames; }

 private:
  PlannedRun run_;
  RenderSettings settings_;
  Scale depth_scale_;
  Scale density_scale_;  ///< the same for every bone, so that pictures of different bones compare
};

/// The legend of a run's depths: it ends at `depth_max_mm`, or, where that is 0, just above the greatest depth
/// foreseen.
Scale depth_scale(const PlannedRun& run, double depth_max_mm);

}  // namespace reamsim
