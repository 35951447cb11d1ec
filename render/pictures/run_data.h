#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/bone/voxmap/voxmap.h"
#include "sim/mesh/triangle_mesh.h"
#include "sim/motion/motion.h"
#include "sim/record/force_log.h"

namespace reamsim {

struct ViewTarget;
class UnreamedSurface;

/// What rendering a run takes beside its snapshots; all of it is known before the simulation begins, and never changes.
struct RunInputs {
  std::string dir;  ///< where the snapshots are, or will be
  std::shared_ptr<const Voxmap> voxmap;
  FillBricks fill;            ///< that the run begins with
  bool whole_voxels = false;  ///< the run removes voxels whole, not in parts
  std::optional<GlenoidFrame> glenoid;
  BodySide side = BodySide::unknown;
  std::vector<std::int64_t> frames;       ///< that have a snapshot, ascending
  std::vector<std::int64_t> pose_frames;  ///< the frames of `poses`, ascending; with all of `frames` from the first on
  std::vector<ToolPose> poses;
  TriangleMesh tool;  ///< T, mm

  /// The pose in a frame, or the first one where the frame lies before it.
  [[nodiscard]] const ToolPose& pose_at(std::int64_t frame) const;
};

/// A run as pictures, meshes and the report see it. Everything is read or computed when it is first asked for, and only
/// once. Copies share it; any thread may ask. Where one is wanted, a folder's path will do.
class RunData {
 public:
  /// Of a finished run: reads DIR/reamed.vdb (with `bone_from_glenoid`, 16 numbers row by row, `bone_side` and
  /// `erosion` in the metadata of `density`, all optional), DIR/snapshots/ and DIR/forces.csv.
  RunData(std::string dir);  // not explicit on purpose
  /// Of a run that is about to begin.
  explicit RunData(RunInputs inputs);

  /// Begins to compute unreamed() and target() on another thread. To be called before anybody asks for them.
  void predict();
  /// The run has ended with this fill, and its forces.csv is complete.
  void finish(FillBricks fill);

  [[nodiscard]] const std::string& dir() const;
  // These throw InputError where a file is missing or damaged, or the tool sweeps no volume.
  [[nodiscard]] const RunInputs& inputs() const;
  [[nodiscard]] const Voxmap& voxmap() const { return *inputs().voxmap; }
  [[nodiscard]] const UnreamedSurface& unreamed() const;
  [[nodiscard]] const ViewTarget& target() const;
  // These also throw std::logic_error before the run has ended.
  [[nodiscard]] const FillBricks& last_fill() const;
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

/// The tool as DIR/snapshots/tool.stl has it.
TriangleMesh read_tool(const std::string& dir);

}  // namespace reamsim
