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

/// The solid as a smooth field that is negative inside and zero on the surface: ½ − (bone fraction), the fraction
/// smoothed by a Gaussian of kSmoothing_voxels, which takes the voxels' steps away and moves a flat face by nothing.
/// In voxel index space: voxel (i,j,k) has its centre at (i,j,k).
class SolidField {
 public:
  static constexpr double kSmoothing_voxels = 1.0;

  explicit SolidField(const Occupancy& occupancy);

  /// Follows `occupancy`, which has been updated with the same bricks.
  void update(const Occupancy& occupancy, const std::vector<Vec3i>& bricks);

  [[nodiscard]] const ScalarGrid& grid() const { return *grid_; }
  /// The field at each of these points, interpolated linearly.
  [[nodiscard]] std::vector<float> at(std::span<const Vec3> points) const;

 private:
  void compute(const Occupancy& occupancy, const std::vector<Vec3i>& bricks);

  std::shared_ptr<ScalarGrid> grid_;
};

/// A surface as OpenVDB's mesher makes it.
struct IsoSurface {
  std::vector<Eigen::Vector3f> points;
  std::vector<std::uint32_t> indices;  ///< three per triangle
};

}  // namespace reamsim
