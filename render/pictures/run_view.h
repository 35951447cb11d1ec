// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <functional>
#include <future>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "render/gl/camera.h"
#include "render/pictures/overlay.h"
#include "render/surface/bone_surface.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/mesh/triangle_mesh.h"
#include "sim/record/force_log.h"
#include "sim/scenario/scenario.h"
#include "sim/scene/swept_bone.h"
#include "sim/tool/tool_path.h"

namespace reamsim {

/// A tool of a run on its path.
struct ToolPass {
  TriangleMesh tool;               ///< T, mm
  std::vector<PathSample> path{};  ///< of every frame, or of those that RunPath chooses; with all that have a snapshot
};

/// The inputs of rendering a run besides its snapshots. All are known before the simulation and immutable.
struct RunInputs {
  std::string dir;  ///< folder of the results
  std::shared_ptr<const Voxmap> voxmap;
  FillBricks fill;            ///< at the start of the run
  bool whole_voxels = false;  ///< the run removes voxels as a whole
  std::optional<GlenoidFrame> glenoid;
  BodySide side = BodySide::unknown;
  std::vector<std::int64_t> frames;  ///< with a snapshot, ascending
  std::vector<ToolPass> passes;      ///< at least one

  /// Index of the pass of a frame.
  [[nodiscard]] std::size_t pass_at(std::int64_t frame) const;
  /// The pose in a frame, or the first one before it.
  [[nodiscard]] const ToolPose& pose_at(std::int64_t frame) const;
};

/// Chooses the poses of a long run that pictures need, in bounded memory (BoundedPath).
class RunPath {
 public:
  /// Voxmap, frames with a snapshot and tools of `run` are set.
  explicit RunPath(const RunInputs& run);
  /// `pass`: from 1. Throws InputError where the run has no tool of this pass.
  void add(const ToolPose& pose, std::int64_t frame, int pass);
  /// Sets the poses of `run`, whose passes without a frame are removed.
  void give(RunInputs& run);

 private:
  std::string dir_;
  std::vector<BoundedPath> paths_;  ///< by pass
};

/// The data of a run for pictures, meshes and the report, read or computed once on first use. Later copies share it,
/// and any thread may use it. Converts from the path of a results folder.
class RunData {
 public:
  /// A finished run: reads DIR/reamed.vdb (with `bone_from_glenoid`, 16 numbers row by row, `bone_side` and
  /// `erosion` in the metadata of `density`, all optional: without it exact), DIR/snapshots/ and DIR/forces.csv.
  RunData(std::string dir);  // implicit
  /// A run before its start.
  explicit RunData(RunInputs inputs);

  /// Starts computing unreamed() and target() on another thread. Call it before their first use.
  void predict() { predict(std::launch::async); }
  /// Marks forces.csv as complete.
  void finish_log();
  /// After finish_log(): marks the run as ended with this fill.
  void finish(FillBricks fill);

  [[nodiscard]] const std::string& dir() const { return dir_; }
  // These throw InputError when a file is missing or damaged, or the tool sweeps no volume.
  [[nodiscard]] const RunInputs& inputs() const { return inputs_.get(); }
  [[nodiscard]] const Voxmap& voxmap() const { return *inputs().voxmap; }
  [[nodiscard]] const UnreamedSurface& unreamed() const { return prediction_.get().unreamed; }
  /// The surface of the bone before the run, unreamed().before.
  [[nodiscard]] const BoneTiles& unreamed_tiles() const { return unreamed_tiles_.get(); }
  [[nodiscard]] const ViewTarget& target() const { return prediction_.get().target; }
  /// The frames in which the tools are expected to touch bone.
  [[nodiscard]] const FrameSpans& contact() const { return prediction_.get().contact; }
  // These also throw std::logic_error before the run has ended.
  [[nodiscard]] const FillBricks& last_fill() const { return ended(fill_).get(); }
  /// With means over a voxel of travel if voxels are removed as a whole; of a long run decimated, with all snapshots.
  [[nodiscard]] const ForceLog& log() const { return ended(log_).get(); }
  [[nodiscard]] const ForceRow& row_of(std::int64_t frame) const { return log().at(frame, dir() + "/forces.csv"); }

 private:
  struct Stored {
    FillBricks fill;
    ForceLog log;
    RunInputs inputs;
  };
  struct Prediction {
    UnreamedSurface unreamed;
    ViewTarget target;
    FrameSpans contact;
  };
  static std::shared_ptr<Stored> read_stored(const std::string& dir);
  static Prediction predict_outcome(const RunInputs& inputs);
  void predict(std::launch when);
  template <class Result>
  static const Result& ended(const Result& result) {
    if (!result.valid()) throw std::logic_error("the run has not ended");
    return result;
  }

  std::string dir_;
  std::shared_future<FillBricks> fill_;
  std::shared_future<ForceLog> log_;
  std::shared_future<RunInputs> inputs_;
  std::shared_future<Prediction> prediction_;
  std::shared_future<BoneTiles> unreamed_tiles_;
};

/// The fill after the first snapshot, that of `frame`; without a folder the fill at the start. Throws InputError.
FillBricks fill_at(const RunInputs& run, std::int64_t frame);
/// The tools in DIR/snapshots, without poses: tool.stl, and tool_2.stl … of later passes.
std::vector<ToolPass> read_tools(const std::string& dir);

/// Which pictures of a run are made, and how.
struct PictureOptions {
  RenderSettings settings{};
  bool film = true;                     ///< of the run, if the settings have one; the turntable has its own
  bool stills = true;                   ///< reamed.png and frames/; the settings decide on the rest
  std::string camera_without_suffix{};  ///< "": the first of the settings
  /// Gets each PNG after it is written, its path first, on another thread, one at a time.
  std::function<void(const std::string&, PixelImage&)> written{};
};

/// What all pictures of a run share and is known before the first: target, cameras and legends. Immutable.
class RunView {
 public:
  /// Throws as RunData does.
  RunView(const RunData& run, const RenderSettings& settings);

  [[nodiscard]] PageLayout page() const { return page_layout(settings_.width_px, settings_.height_px); }
  /// Of the pictures along the run.
  [[nodiscard]] PageLayout frame_page() const;
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

  /// `log` outlives it. `arrows`: draw force arrows.
  Captions(const ForceLog& log, bool arrows);

  /// Values of a picture during the run.
  [[nodiscard]] Values at(const ForceRow& row) const;
  /// Values of a picture of the final state.
  [[nodiscard]] Values after(double deepest_mm) const;
  /// The bone's force on the tool, at the tool's tip; none if negligible.
  [[nodiscard]] std::optional<ForceArrow> arrow(const ForceRow& row) const;

 private:
  const ForceLog& log_;
  std::string mean_;  ///< prefix of the names of forces: "mean " or empty
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

}  // namespace reamsim
