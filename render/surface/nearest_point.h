// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Geometry>
#include <unsupported/Eigen/BVH>
#include <vector>

namespace reamsim {

/// Distance to the nearest of some points.
class NearestPoint {
 public:
  /// At least one point.
  explicit NearestPoint(const std::vector<Eigen::Vector3d>& points);

  [[nodiscard]] double distance(const Eigen::Vector3d& from) const;

 private:
  struct Query;

  Eigen::KdBVH<double, 3, Eigen::Vector3d> tree_;
};

}  // namespace reamsim
