// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <vector>

#include "render/surface/solid_field.h"
#include "sim/base/parallel.h"
#include "sim/bone/vdb/grids.h"

// Only for the source files of this folder, because OpenVDB's headers take ten seconds to compile.
namespace reamsim {

struct ScalarGrid {
  openvdb::FloatGrid::Ptr vdb;
};

/// The isosurface of `field` at `level`, in the grid's world space; with `where`, only in its active voxels.
IsoSurface extract_surface(const openvdb::FloatGrid& field, double level, openvdb::BoolGrid::ConstPtr where = nullptr);

/// A copy of the bricks `first` to `last` of a field; the background elsewhere.
openvdb::FloatGrid::Ptr bricks_of(const openvdb::FloatGrid& field, const Vec3i& first, const Vec3i& last);

/// Trilinear interpolation at a point in index space: the bytes of openvdb::tools::BoxSampler::sample(), but with one
/// look-up for all corners that are in one leaf or tile.
inline double sample(const openvdb::FloatGrid::ConstAccessor& accessor, const openvdb::Vec3d& point) {
  using Leaf = openvdb::FloatTree::LeafNodeType;
  constexpr openvdb::Int32 kLast = Leaf::DIM - 1;
  const openvdb::Coord base = openvdb::Coord::floor(point);
  const openvdb::Coord in_leaf = base & kLast;
  // Corner i is one cell further along x, y and z where bits 2, 1 and 0 of i are set.
  const int leaving = (in_leaf.x() == kLast) << 2 | (in_leaf.y() == kLast) << 1 | int{in_leaf.z() == kLast};
  const float* leaves[8] = {};
  float corners[2][2][2];
  for (int i = 0; i < 8; ++i) {
    const openvdb::Coord at = base.offsetBy(i >> 2, i >> 1 & 1, i & 1);
    float& corner = corners[i >> 2][i >> 1 & 1][i & 1];
    if ((i & leaving) == i) {
      const Leaf* leaf = accessor.probeConstLeaf(at);
      leaves[i] = leaf == nullptr ? nullptr : leaf->buffer().data();
      if (leaf == nullptr && leaving == 0) return accessor.getValue(at);
    }
    const float* leaf = leaves[i & leaving];
    corner = leaf == nullptr ? accessor.getValue(at) : leaf[Leaf::coordToOffset(at)];
  }
  return openvdb::tools::BoxSampler::trilinearInterpolation(corners, point - base.asVec3d());
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

/// Removal of material at a point of the surface.
struct Removal {
  float reamed = 0;     ///< 0…1; above ½ on the reamed face, at ½ on its edge
  float certainty = 0;  ///< that material was removed here, 0…1
};

/// Samples reaming at points of the bone's surface, in voxel index space. For one thread.
class ReamingSampler {
 public:
  /// `now`: the field of the current bone.
  ReamingSampler(const UnreamedSurface& unreamed, const ScalarGrid& now)
      : field_(unreamed.field.grid().vdb->getConstAccessor()),
        now_(now.vdb->getConstAccessor()),
        depth_grid_(*unreamed.depth->vdb),
        depth_(depth_grid_.getConstAccessor()) {}

  /// Certainty that material was removed at a point where the field of the current bone is zero, 0…1: that of the
  /// unreamed bone is zero where none was removed, and falls to −½ inside.
  [[nodiscard]] float fraction(const openvdb::Vec3d& voxel) const { return certainty(-sample(field_, voxel)); }
  /// The fraction of removed material, smoothed as the fields are; 0 away from it.
  [[nodiscard]] double removed(const openvdb::Vec3d& voxel) const {
    return sample(now_, voxel) - sample(field_, voxel);
  }
  /// The point of the current surface, where the field is zero, next to a point near it.
  [[nodiscard]] openvdb::Vec3d on_surface(openvdb::Vec3d voxel) const {
    constexpr int kSteps = 2;       // Newton's
    constexpr double kMaxStep = 1;  // in gradients of the field
    const auto value = [&](const openvdb::Vec3d& at) { return sample(now_, at); };
    for (int step = 0; step < kSteps; ++step) {
      const openvdb::Vec3d slope = central_difference(value, voxel, 0.5);
      voxel -= slope * std::clamp(value(voxel) / std::max(slope.lengthSqr(), 1e-4), -kMaxStep, kMaxStep);
    }
    return voxel;
  }
  /// Removal at a point of the current surface. The edge of the reamed face is where the removed fraction is
  /// kEdge_voxels times its gradient: at the edge of a wedge of angle α that was removed from a flat bone, a Gaussian
  /// of one voxel makes the fraction α/2π and its gradient 2 sin(α/2)/√(8π), whose ratio is 0.80 to 0.89 for 0 to 90°.
  [[nodiscard]] Removal removal(const openvdb::Vec3d& voxel) const {
    const double fraction = removed(voxel);
    const auto at = [&](const openvdb::Vec3d& p) { return removed(p); };
    const double gradient = 0.5 * central_difference(at, voxel, 1).length();
    const double edge = 0.5 * fraction / (kEdge_voxels * std::max(gradient, 1e-6));
    return {static_cast<float>(std::clamp(edge, 0.0, 1.0)), certainty(fraction)};
  }
  /// Depth below the unreamed surface. `point_mm`: voxel index space times voxel_mm.
  [[nodiscard]] float depth_mm(const openvdb::Vec3d& point_mm) const {
    return static_cast<float>(std::max(0.0, sample(depth_, depth_grid_.transform().worldToIndex(point_mm))));
  }

 private:
  static constexpr double kEdge_voxels = 0.86;

  static float certainty(double removed) {
    constexpr double kNone = 0.03;
    constexpr double kCertain = 0.13;
    return static_cast<float>(std::clamp((removed - kNone) / (kCertain - kNone), 0.0, 1.0));
  }

  openvdb::FloatGrid::ConstAccessor field_, now_;
  const openvdb::FloatGrid& depth_grid_;
  openvdb::FloatGrid::ConstAccessor depth_;
};

/// Reaming at each vertex of a surface.
struct Reaming {
  std::vector<float> reamed;     ///< as Removal
  std::vector<float> certainty;  ///< as Removal
  std::vector<float> depth_mm;   ///< below the unreamed surface; 0 where nothing was removed

  /// Smooths the voxel steps of depth and edge. `points`: vertices in voxels.
  void smooth(const Neighbours& neighbours, const std::vector<Eigen::Vector3f>& points, int depth_rounds,
              int edge_rounds) {
    if (std::ranges::all_of(reamed, [](float r) { return r == 0; })) return;
    const std::vector<float> weights = mean_value_weights(neighbours, points);
    smooth_values(neighbours, weights, certainty, depth_mm, depth_rounds);
    smooth_values(neighbours, weights, std::vector<float>(reamed.size(), 1), reamed, edge_rounds);
  }
};

/// Reaming at `count` vertices: removal_at(sampler, i), and its depth at mm(i), voxel index space times voxel_mm.
template <class RemovalAt, class Mm>
Reaming reaming_at(std::size_t count, const UnreamedSurface& unreamed, const ScalarGrid& now,
                   const RemovalAt& removal_at, const Mm& mm) {
  Reaming out{std::vector<float>(count), std::vector<float>(count), std::vector<float>(count)};
  parallel_ranges(count, 2048, [&](std::size_t begin, std::size_t end) {
    const ReamingSampler sampler(unreamed, now);
    for (std::size_t i = begin; i < end; ++i) {
      const Removal removal = removal_at(sampler, i);
      out.reamed[i] = removal.reamed;
      out.certainty[i] = removal.certainty;
      if (removal.certainty > 0) out.depth_mm[i] = sampler.depth_mm(mm(i));
    }
  });
  return out;
}

}  // namespace reamsim
