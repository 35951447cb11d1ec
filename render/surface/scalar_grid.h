#pragma once

#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>

#include <algorithm>

#include "render/surface/unreamed_surface.h"

// For the source files of this folder alone: OpenVDB's headers take ten seconds to compile, so that no other header
// includes them.
namespace reamsim {

struct ScalarGrid {
  openvdb::FloatGrid::Ptr vdb;
};

/// The surface where `field` has the value `level`, in the grid's world space; with `where`, only that of its active
/// voxels.
IsoSurface extract_surface(const openvdb::FloatGrid& field, double level, openvdb::BoolGrid::ConstPtr where = nullptr);

inline double sample(const openvdb::FloatGrid::ConstAccessor& accessor, const openvdb::Vec3d& point) {
  return openvdb::tools::BoxSampler::sample(accessor, point);
}

/// What reaming did at points of the bone's surface. For one thread.
class ReamingSampler {
 public:
  explicit ReamingSampler(const UnreamedSurface& unreamed)
      : field_(unreamed.field().vdb->getConstAccessor()),
        depth_grid_(*unreamed.depth().vdb),
        depth_(depth_grid_.getConstAccessor()) {}

  /// How certain it is that material was removed here, 0…1: the field of the unreamed bone is zero where none was, and
  /// falls to −½ inside. `voxel`: voxel index space.
  [[nodiscard]] float fraction(const openvdb::Vec3d& voxel) const {
    constexpr double kNone = 0.03;
    constexpr double kCertain = 0.13;
    return static_cast<float>(std::clamp((-sample(field_, voxel) - kNone) / (kCertain - kNone), 0.0, 1.0));
  }
  /// Depth below the unreamed surface. `point_mm`: voxel index space times voxel_mm.
  [[nodiscard]] float depth_mm(const openvdb::Vec3d& point_mm) const {
    return static_cast<float>(std::max(0.0, sample(depth_, depth_grid_.transform().worldToIndex(point_mm))));
  }

 private:
  openvdb::FloatGrid::ConstAccessor field_;
  const openvdb::FloatGrid& depth_grid_;
  openvdb::FloatGrid::ConstAccessor depth_;
};

}  // namespace reamsim
