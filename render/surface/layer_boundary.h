// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <unsupported/Eigen/BVH>

#include "render/surface/unreamed_surface.h"

namespace reamsim {

/// A tree of points, for the nearest of them.
using PointTree = Eigen::KdBVH<double, 3, Eigen::Vector3d>;

/// For Eigen::BVMinimize: the squared distance to a point, and its lower bound in a box.
struct PointDistance {
  using Scalar = double;
  Eigen::Vector3d from;

  double minimumOnVolume(const PointTree::Volume& box) const { return box.squaredExteriorDistance(from); }
  double minimumOnObject(const Eigen::Vector3d& point) const { return (point - from).squaredNorm(); }
};

/// The boundary between the layers of a bone (Voxmap::layers) in a plane: at their depth, not between voxels.
class LayerBoundary {
 public:
  /// For points in the plane through three points, in voxel index space. All must outlive this.
  LayerBoundary(const Voxmap& voxmap, const UnreamedSurface& unreamed, const Vec3& a, const Vec3& b, const Vec3& c);

  /// Whether the eight voxels nearest to a point (voxel index space) are of both layers.
  [[nodiscard]] bool near(const Vec3& point) const;
  /// The density in g/cm³ at a point by its depth, blended over `blend_voxels` across the boundary.
  [[nodiscard]] double density_at(const Vec3& point, double blend_voxels) const;

 private:
  const Voxmap& voxmap_;
  std::optional<PointTree> surface_;  ///< near the plane
};

}  // namespace reamsim
