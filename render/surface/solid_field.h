// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "render/surface/occupancy.h"

namespace reamsim {

/// An OpenVDB grid; scalar_grid.h defines it.
struct ScalarGrid;

/// The solid as a smooth implicit field, negative inside: ½ − (bone fraction, smoothed by a Gaussian of
/// kSmoothing_voxels). Smoothing removes voxel steps and does not displace a flat face. In voxel index space: voxel
/// (i,j,k) has its centre at (i,j,k).
class SolidField {
 public:
  static constexpr double kSmoothing_voxels = 1.0;

  explicit SolidField(const Occupancy& occupancy);

  /// Updates the field after `occupancy` was updated with the same bricks.
  void update(const Occupancy& occupancy, const std::vector<Vec3i>& bricks);

  [[nodiscard]] const ScalarGrid& grid() const { return *grid_; }
  /// The field at each of these points, interpolated linearly.
  [[nodiscard]] std::vector<float> at(std::span<const Vec3> points) const;

 private:
  void compute(const Occupancy& occupancy, const std::vector<Vec3i>& bricks);

  std::shared_ptr<ScalarGrid> grid_;
};

/// An isosurface from OpenVDB's mesher.
struct IsoSurface {
  std::vector<Eigen::Vector3f> points;
  std::vector<std::uint32_t> indices;  ///< three per triangle
};

}  // namespace reamsim
