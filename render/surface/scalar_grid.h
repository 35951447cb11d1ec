#pragma once

#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <vector>

#include "render/surface/surface_smoothing.h"
#include "render/surface/unreamed_surface.h"
#include "sim/base/parallel.h"

// Only for the source files of this folder: OpenVDB's headers take ten seconds to compile, so no other header includes
// them.
namespace reamsim {

struct ScalarGrid {
  openvdb::FloatGrid::Ptr vdb;
};

/// The isosurface of `field` at `level`, in the grid's world space; with `where`, only in its active voxels.
IsoSurface extract_surface(const openvdb::FloatGrid& field, double level, openvdb::BoolGrid::ConstPtr where = nullptr);

inline double sample(const openvdb::FloatGrid::ConstAccessor& accessor, const openvdb::Vec3d& point) {
  return openvdb::tools::BoxSampler::sample(accessor, point);
}

/// The central differences of `value` along each axis; not divided by the step.
template <class Value>
openvdb::Vec3d central_difference(const Value& value, const openvdb::Vec3d& point, double half_step) {
  openvdb::Vec3d out;
  for (int axis = 0; axis < 3; ++axis) {
    openvdb::Vec3d step(0.0);
    step[axis] = half_step;
    out[axis] = value(point + step) - value(point - step);
  }
  return out;
}

/// Samples reaming at points of the bone's surface. For one thread.
class ReamingSampler {
 public:
  explicit ReamingSampler(const UnreamedSurface& unreamed)
      : field_(unreamed.field().vdb->getConstAccessor()),
        depth_grid_(*unreamed.depth().vdb),
        depth_(depth_grid_.getConstAccessor()) {}

  /// Certainty that material was removed here, 0…1: the field of the unreamed bone is zero where none was removed, and
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

/// Reaming at each vertex of a surface.
struct Reaming {
  std::vector<float> fraction;  ///< certainty that material was removed, 0…1
  std::vector<float> depth_mm;  ///< below the unreamed surface; 0 where nothing was removed

  /// Smooths the voxel steps of both. `points`: vertices in voxels.
  void smooth(const Neighbours& neighbours, const std::vector<Eigen::Vector3f>& points, int depth_rounds,
              int fraction_rounds) {
    if (std::ranges::all_of(fraction, [](float f) { return f == 0; })) return;
    const std::vector<float> weights = mean_value_weights(neighbours, points);
    smooth_values(neighbours, weights, fraction, depth_mm, depth_rounds);
    smooth_values(neighbours, weights, std::vector<float>(fraction.size(), 1), fraction, fraction_rounds);
  }
};

/// `voxel(i)`: where vertex i reads its fraction, voxel index space; `mm(i)`: where it reads its depth, times voxel_mm.
template <class Voxel, class Mm>
Reaming sample_reaming(std::size_t count, const UnreamedSurface& unreamed, const Voxel& voxel, const Mm& mm) {
  Reaming out{std::vector<float>(count), std::vector<float>(count)};
  parallel_ranges(count, 2048, [&](std::size_t begin, std::size_t end) {
    const ReamingSampler sampler(unreamed);
    for (std::size_t i = begin; i < end; ++i) {
      out.fraction[i] = sampler.fraction(voxel(i));
      if (out.fraction[i] > 0) out.depth_mm[i] = sampler.depth_mm(mm(i));
    }
  });
  return out;
}

}  // namespace reamsim
