#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/bone/voxmap/voxmap.h"
#include "sim/mesh/triangle_mesh.h"
#include "sim/motion/bounded_path.h"
#include "sim/predict/swept_bone.h"
#include "sim/record/force_log.h"
#include "sim/scenario/picture_frames.h"

namespace reamsim {

struct ViewTarget;
class UnreamedSurface;

/// The inputs of rendering a run besides its snapshots. All are known before the simulation and immutable.
struct RunInputs {
  std::string dir;  ///< folder of the results
  std::shared_ptr<const Voxmap> voxmap;
  FillBricks fill;            ///< at the start of the run
  bool whole_voxels = false;  ///< the run removes voxels as a whole
  std::optional<GlenoidFrame> glenoid;
  BodySide side = BodySide::unknown;
  std::vector<std::int64_t> frames;       ///< with a snapshot, ascending
  std::vector<std::int64_t> pose_frames;  ///< frames of `poses`, ascending; they include `frames`
  std::vector<ToolPose> poses;            ///< of every frame, or of those that RunPath chooses
  TriangleMesh tool;                      ///< T, mm

  /// The pose in a frame, or the first one before it.
  [[nodiscard]] const ToolPose& pose_at(std::int64_t frame) const;
};

/// Chooses the poses of a long run that pictures need, in bounded memory and one pass (sim/motion/bounded_path.h).
class RunPath {
 public:
  /// Voxmap, frames with a snapshot and tool of `run` are set.
  explicit RunPath(const RunInputs& run);
  void add(const ToolPose& pose, std::int64_t frame) { path_.add(pose, static_cast<std::size_t>(frame)); }
  /// Sets the poses of `run`.
  void give(RunInputs& run);

 private:
  BoundedPath path_;
};

/// The data of a run for pictures, meshes and the report, read or computed once on first use. Copies share it, and any
/// thread may use it. Converts from the path of a results folder.
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

  [[nodiscard]] const std::string& dir() const;
  // These throw InputError when a file is missing or damaged, or the tool sweeps no volume.
  [[nodiscard]] const RunInputs& inputs() const;
  [[nodiscard]] const Voxmap& voxmap() const { return *inputs().voxmap; }
  [[nodiscard]] const UnreamedSurface& unreamed() const;
  [[nodiscard]] const ViewTarget& target() const;
  /// The frames in which the tool is expected to touch bone; none if it never does.
  [[nodiscard]] const std::optional<FrameSpan>& contact() const;
  // These also throw std::logic_error before the run has ended.
  [[nodiscard]] const FillBricks& last_fill() const;
  /// With the means over a voxel of travel where the run removes voxels as a whole; decimated for a long run, with the
  /// rows of all snapshots.
  [[nodiscard]] const ForceLog& log() const;
  /// The log's row of a frame.
  [[nodiscard]] const ForceRow& row_of(std::int64_t frame) const;

 private:
  struct Outcome;
  struct Prediction;
  struct State;

  static Outcome read_outcome(const std::string& dir);
  static Prediction predict_outcome(const RunInputs& inputs);
  [[nodiscard]] const Outcome& outcome() const;

  std::shared_ptr<State> state_;
};

/// The fill after the snapshot of a frame, which must be the first snapshot; of a run without a folder the fill at its
/// start. Throws InputError.
FillBricks fill_at(const RunInputs& run, std::int64_t frame);
/// The bone after a run, predicted from the swept volume of its tool. Throws InputError when that has none.
PredictedBone predict_bone(const RunInputs& run);
/// The tool in DIR/snapshots/tool.stl.
TriangleMesh read_tool(const std::string& dir);

}  // namespace reamsim
