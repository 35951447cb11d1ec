#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "render/force_log.h"
#include "sim/base/geometry.h"
#include "sim/bone/voxmap.h"
#include "sim/mesh/triangle_mesh.h"

namespace reamsim {

/// What a run left in its folder, as far as pictures need it.
struct RunResults {
  Voxmap voxmap;        ///< the unreamed bone's grades and the last fill
  double bone_mm3 = 0;  ///< what that fill leaves
  /// What of each voxel at the bone's surface was bone before the run; what an earlier run took away counts as whole.
  FillBricks unreamed_fill;
  std::optional<GlenoidFrame> glenoid;
  std::string side;                  ///< "left", "right", or "" where the run did not know
  std::vector<std::int64_t> frames;  ///< that have a snapshot, ascending
  ForceLog log;
  std::string log_path;
  TriangleMesh tool;  ///< T, mm
};

/// What DIR/reamed.vdb says of the bone's directions.
struct Anatomy {
  std::optional<GlenoidFrame> glenoid;
  std::string side;  ///< as in RunResults
};
/// Reads metadata only. Throws InputError when it is missing or damaged.
Anatomy read_anatomy(const std::string& dir);

/// Reads DIR/reamed.vdb (with `bone_from_glenoid`, 16 numbers row by row, and `bone_side` in the metadata of `density`,
/// both optional), DIR/snapshots/ and DIR/forces.csv. Throws InputError when one is missing or damaged.
RunResults read_results(const std::string& dir);
/// The same, of a run whose voxmap is at hand: of DIR/reamed.vdb only the metadata is read.
RunResults read_results(const std::string& dir, Voxmap voxmap);

}  // namespace reamsim
