// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Geometry>
#include <unsupported/Eigen/BVH>

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

}  // namespace reamsim
