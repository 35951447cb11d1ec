#pragma once

#include <optional>
#include <string>

#include "render/gl/camera.h"
#include "render/pictures/overlay.h"
#include "render/pictures/run_data.h"
#include "sim/scenario/scenario.h"

namespace reamsim {

/// Which pictures of a run are made, and how.
struct PictureOptions {
  RenderSettings settings{};
  /// Forces that pictures, plots and the report name are means over so much of the tool's travel; 0: single frames. See
  /// averaged_travel_mm().
  double mean_travel_mm = 0;
  bool film = true;                 ///< of the run, where the settings want films; the turntable's goes by its pictures
  bool stills = true;               ///< reamed.png and frames/; what else there is, the settings say
  std::string camera_without_suffix{};  ///< whose files have no suffix; "": the first of the settings
};

/// What is the same in every picture of a run, and known before the first: what is looked at, by which cameras, and how
/// far the legends go. Never changes, and so may be asked by several threads.
class RunView {
 public:
  /// Throws as RunData does.
  RunView(const RunData& run, const RenderSettings& settings);

  /// A camera by its name: a CameraView's or the user's. Throws InputError.
  [[nodiscard]] Camera camera(const std::string& name, int width_px, int height_px) const;
  /// The same a little closer, for pictures without labels of their own; a user's camera stays as it is.
  [[nodiscard]] Camera closer_camera(const std::string& name, int width_px, int height_px) const;
  /// The tool's pose in a frame, with the spin; none where the settings want no tool.
  [[nodiscard]] std::optional<Rigid> tool_at(std::int64_t frame) const;
  /// The labels that each picture of this camera has: legends and directions; and the tool's outline, face on.
  [[nodiscard]] Labels labels(const Camera& camera, const std::optional<Rigid>& tool) const;

  [[nodiscard]] const RunData& run() const { return run_; }
  [[nodiscard]] const RenderSettings& settings() const { return settings_; }
  [[nodiscard]] const Scale& depth_scale() const { return depth_scale_; }
  [[nodiscard]] const Scale& density_scale() const { return density_scale_; }
  /// Those that have a snapshot, ascending.
  [[nodiscard]] const std::vector<std::int64_t>& frames() const { return run_.inputs().frames; }

 private:
  RunData run_;
  RenderSettings settings_;
  Scale depth_scale_;
  Scale density_scale_;  ///< the same for every bone, so that pictures of different bones compare
};

/// The legend of a run's depths: it ends at `depth_max_mm`, or, where that is 0, just above the greatest predicted
/// depth.
Scale depth_scale(const RunData& run, double depth_max_mm);

}  // namespace reamsim
