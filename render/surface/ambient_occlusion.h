// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <vector>

#include "render/surface/occupancy.h"

namespace reamsim {

/// Ambient occlusion of surface points from the bone fraction, averaged over a hierarchy of cells. It does not depend
/// on the view, so it does not flicker between pictures.
class AmbientOcclusion {
 public:
  explicit AmbientOcclusion(const Occupancy& occupancy);

  void update(const Occupancy& occupancy, const std::vector<Vec3i>& bricks);

  /// Ambient accessibility: 1 unoccluded, 0 fully occluded. `point` in voxel index space; unit `normal`.
  [[nodiscard]] float accessibility(const Eigen::Vector3f& point, const Eigen::Vector3f& normal) const;
  /// Bone farther than this from a point does not affect it.
  [[nodiscard]] double reach_voxels() const;

 private:
  /// Cells of `cell_voxels`³ voxels.
  struct Level {
    int cell_voxels;
    BrickLattice cells;
    std::vector<float> fractions;
    /// The fraction of a cell; 0 outside.
    [[nodiscard]] float get(const Vec3i& cell) const;
    /// Trilinear interpolation, voxel index space.
    [[nodiscard]] float sample(const Eigen::Vector3f& point) const;
  };

  /// Level and distance (voxels) at which the i-th distance is sampled.
  struct Probe {
    const Level* level;
    float offset;
  };
  [[nodiscard]] Probe probe_at(std::size_t distance) const;

  void average_brick(const Occupancy& occupancy, const Vec3i& brick);
  void average_coarse();

  double voxel_mm_;
  std::vector<Level> levels_;
};

}  // namespace reamsim
