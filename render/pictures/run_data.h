// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/gl/camera.h"
#include "render/surface/solid_field.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/mesh/triangle_mesh.h"
#include "sim/record/force_log.h"
#include "sim/scenario/picture_frames.h"
#include "sim/tool/tool_path.h"

namespace reamsim {

/// A tool of a run on its path.
struct ToolPass {
  TriangleMesh tool;                        ///< T, mm
  std::vector<std::int64_t> pose_frames{};  ///< frames of `poses`, ascending; those with a snapshot are among them
  std::vector<ToolPose> poses{};            ///< of every frame, or of those that RunPath chooses
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

/// Chooses the poses of a long run that pictures need, in bounded memory and one pass (BoundedPath).
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
  std::vector<bool> used_;
};

/// The data of a run for pictures, meshes and the report, read or computed once on first use. Later copies share it,
/// and any thread may use it. Converts from the path of a results folder.
class RunData {
 public:
  /// A finished run: reads DIR/reamed.vdb (with `bone_from_glenoid`, 16 numbers row by row, `bone_side` and
  /// `erosion` in the metadata of `density`, all optional), DIR/snapshots/ and DIR/forces.csv.
  RunData(std::string dir);  // implicit
  /// A run before its start.
  explicit RunData(RunInputs inputs);

  /// Starts computing unreamed() and target() on another thread. Call it before their first use.
  void predict();
  /// Marks the run as ended with this fill and a complete forces.csv.
  void finish(FillBricks fill);

  [[nodiscard]] const std::string& dir() const { return dir_; }
  // These throw InputError when a file is missing or damaged, or the tool sweeps no volume.
  [[nodiscard]] const RunInputs& inputs() const { return inputs_.get(); }
  [[nodiscard]] const Voxmap& voxmap() const { return *inputs().voxmap; }
  [[nodiscard]] const UnreamedSurface& unreamed() const { return prediction_.get().unreamed; }
  [[nodiscard]] const ViewTarget& target() const { return prediction_.get().target; }
  /// The frames in which the tools are expected to touch bone.
  [[nodiscard]] const FrameSpans& contact() const { return prediction_.get().contact; }
  // These also throw std::logic_error before the run has ended.
  [[nodiscard]] const FillBricks& last_fill() const { return outcome().fill; }
  /// With means over a voxel of travel if voxels are removed as a whole; of a long run decimated, with all snapshots.
  [[nodiscard]] const ForceLog& log() const { return outcome().log; }
  [[nodiscard]] const ForceRow& row_of(std::int64_t frame) const { return log().at(frame, dir() + "/forces.csv"); }

 private:
  struct Outcome {
    FillBricks fill;
    ForceLog log;
    std::optional<RunInputs> inputs{};  ///< where they were read with it
  };
  struct Prediction {
    UnreamedSurface unreamed;
    ViewTarget target;
    FrameSpans contact;
  };
  static Outcome read_outcome(const std::string& dir);
  static Prediction predict_outcome(const RunInputs& inputs);
  [[nodiscard]] const Outcome& outcome() const;

  std::string dir_;
  std::shared_future<Outcome> outcome_;
  std::shared_future<RunInputs> inputs_;
  std::shared_future<Prediction> prediction_;
};

/// The fill after the first snapshot, that of `frame`; without a folder the fill at the start. Throws InputError.
FillBricks fill_at(const RunInputs& run, std::int64_t frame);
/// The tools in DIR/snapshots, without poses: tool.stl, and tool_2.stl … of later passes.
std::vector<ToolPass> read_tools(const std::string& dir);

}  // namespace reamsim
