// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <unsupported/Eigen/BVH>
#include <vector>

namespace reamsim {

/// Distance to the nearest of some points.
class NearestPoint {
 public:
  /// At least one point.
  explicit NearestPoint(const std::vector<Eigen::Vector3d>& points)
      : NearestPoint(points, {points.begin(), points.end()}) {}

  [[nodiscard]] double distance(const Eigen::Vector3d& from) const {
    Query query{from};
    return std::sqrt(Eigen::BVMinimize(tree_, query));
  }

 private:
  using Tree = Eigen::KdBVH<double, 3, Eigen::Vector3d>;
  using Boxes = std::vector<Eigen::AlignedBox3d>;
  /// For Eigen::BVMinimize: the squared distance to a point, and its lower bound in a box.
  struct Query {
    using Scalar = double;
    Eigen::Vector3d from;

    double minimumOnVolume(const Tree::Volume& box) const { return box.squaredExteriorDistance(from); }
    double minimumOnObject(const Eigen::Vector3d& point) const { return (point - from).squaredNorm(); }
  };

  NearestPoint(const std::vector<Eigen::Vector3d>& points, const Boxes& boxes)
      : tree_(points.begin(), points.end(), boxes.begin(), boxes.end()) {}

  Tree tree_;
};

}  // namespace reamsim
