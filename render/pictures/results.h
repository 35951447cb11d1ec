#pragma once

#include <memory>
#include <optional>
#include <string>

#include "render/pictures/run_plan.h"
#include "sim/base/geometry.h"
#include "sim/bone/voxmap/voxmap.h"
#include "sim/record/force_log.h"

namespace reamsim {

/// What a run left in its folder, as far as pictures need it, beside its plan.
struct RunResults {
  std::shared_ptr<const Voxmap> bone;
  FillBricks fill;      ///< that the run leaves
  double bone_mm3 = 0;  ///< what that fill leaves
  ForceLog log;
  std::string log_path;

  /// The log's row of a frame. Throws InputError when the log is shorter.
  [[nodiscard]] const ForceRow& row_of(std::int64_t frame) const { return log.at(frame, log_path); }
};

/// What DIR/reamed.vdb says of the bone's directions.
struct Anatomy {
  std::optional<GlenoidFrame> glenoid;
  BodySide side = BodySide::unknown;  ///< as in RunPlan
};
/// Reads metadata only. Throws InputError when it is missing or damaged.
Anatomy read_anatomy(const std::string& dir);

/// Reads DIR/forces.csv, of a run whose last bone is at hand. Throws InputError when it is missing or damaged.
RunResults read_results(const std::string& dir, std::shared_ptr<const Voxmap> bone, FillBricks fill);
/// The same with the bone of DIR/reamed.vdb.
RunResults read_results(const std::string& dir);

/// Finds out what the plan was: from DIR/reamed.vdb (of which `results` has the grids; with `bone_from_glenoid`, 16
/// numbers row by row, `bone_side` and `erosion` in the metadata of `density`, all optional), DIR/snapshots/ and the
/// log. Throws InputError when something is missing or damaged.
RunPlan read_plan(const std::string& dir, const RunResults& results);

/// The file in `dir` that the tool is read from, and its mesh.
std::string tool_path(const std::string& dir);
TriangleMesh read_tool(const std::string& dir);

}  // namespace reamsim
