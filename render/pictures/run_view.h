// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/pictures/overlay.h"
#include "render/pictures/run_data.h"
#include "sim/bone/voxmap/density.h"
#include "sim/scenario/scenario.h"
#include "sim/scene/swept_bone.h"

namespace reamsim {

/// Which pictures of a run are made, and how.
struct PictureOptions {
  RenderSettings settings{};
  /// Tool travel over which forces are averaged, see averaged_travel_mm(); 0: single frames.
  double mean_travel_mm = 0;
  bool film = true;                     ///< of the run, if the settings have one; the turntable has its own
  bool stills = true;                   ///< reamed.png and frames/; the settings decide on the rest
  std::string camera_without_suffix{};  ///< "": the first of the settings
};

/// What all pictures of a run share and is known before the first: target, cameras and legends. Immutable.
class RunView {
 public:
  /// Throws as RunData does.
  RunView(const RunData& run, const RenderSettings& settings);

  [[nodiscard]] PageLayout page() const { return page_layout(settings_.width_px, settings_.height_px); }
  /// A camera by name, built in or defined by the user. Throws InputError.
  [[nodiscard]] Camera camera(const std::string& name, int width_px, int height_px) const;
  /// The tool in a frame; none if the settings hide it.
  [[nodiscard]] std::optional<PlacedTool> tool_at(std::int64_t frame) const;
  /// The labels of every picture of this camera: legends, directions and, en face, the tool's outline.
  [[nodiscard]] Labels labels(const Camera& camera, const std::optional<PlacedTool>& tool) const;

  /// The frame of the depth map: the glenoid's, else the tool's at its deepest; +z is out of the bone.
  [[nodiscard]] Rigid map_from_bone() const;

  [[nodiscard]] const RunData& run() const { return run_; }
  [[nodiscard]] const RenderSettings& settings() const { return settings_; }
  [[nodiscard]] const Scale& depth_scale() const { return depth_scale_; }
  /// Equal for all bones, so that their pictures compare.
  [[nodiscard]] static Scale density_scale() { return scale_up_to(DensityMapping::kMaxDensity_g_cm3); }
  [[nodiscard]] const std::vector<std::int64_t>& frames() const { return run_.inputs().frames; }

 private:
  RunData run_;
  RenderSettings settings_;
  Scale depth_scale_;
};

/// Labels of a run's pictures from its force log. They need the complete log: the greatest force scales the arrows.
class Captions {
 public:
  using Values = std::vector<std::pair<std::string, std::string>>;  ///< name and number with unit

  /// `mean_travel_mm`: the tool's travel over which forces are averaged; 0: single frames. `arrows`: draw force arrows.
  Captions(ForceLog log, double mean_travel_mm, bool arrows);

  /// Values of a picture during the run.
  [[nodiscard]] Values at(const ForceRow& row) const;
  /// Values of a picture of the final state.
  [[nodiscard]] Values after(double deepest_mm) const;
  /// The bone's force on the tool, at the tool's tip; none if negligible.
  [[nodiscard]] std::optional<ForceArrow> arrow(const ForceRow& row) const;

  /// The log with means.
  [[nodiscard]] const ForceLog& log() const { return log_; }
  /// Prefix of the names of forces: "mean " or empty.
  [[nodiscard]] const std::string& mean() const { return mean_; }

 private:
  ForceLog log_;
  std::string mean_;
  bool arrows_;
  double max_force_n_ = 0;
};

/// The depth legend of a run: it ends at `depth_max_mm`, or, if 0, just above the greatest predicted depth.
Scale depth_scale(const RunData& run, double depth_max_mm);

/// The bone after a run, predicted from the swept volume of its tools.
struct PredictedRun {
  PredictedBone bone;
  std::size_t pass = 0;  ///< index of the last one that removes bone
  FrameSpans contact;    ///< of the passes that touch the bone
};

/// Throws InputError when a tool has no swept volume.
PredictedRun predict_run(const RunInputs& run);

/// The farthest point of the tool from its origin, mm.
double tool_reach_mm(const TriangleMesh& tool);

}  // namespace reamsim
