// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <vector>

#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// The bone fraction of each voxel, 0…1, with each brick (8×8×8 voxels) classified as air, bone or mixed.
class Occupancy {
 public:
  enum class Kind : std::uint8_t { kEmpty, kFull, kMixed };

  /// Both must outlive this.
  Occupancy(const Voxmap& voxmap, const FillBricks& fill);

  /// Reclassifies bricks whose fill has changed.
  void update(const std::vector<Vec3i>& bricks);

  [[nodiscard]] const Voxmap& voxmap() const { return voxmap_; }
  [[nodiscard]] Vec3i brick_dims() const { return bricks_.dims; }
  /// Outside the lattice everything is air.
  [[nodiscard]] Kind kind(const Vec3i& brick) const;
  /// Copies the fractions of the box of side³ voxels at `lower` to `out`, x fastest.
  void gather(const Vec3i& lower, int side, float* out) const;

 private:
  [[nodiscard]] Kind classify(const Vec3i& brick) const;

  const Voxmap& voxmap_;
  const FillBricks& fill_;
  BrickLattice bricks_;
  std::vector<Kind> kinds_;
};

/// The mean density in g/cm³ of the eight voxels nearest to `point` (voxel index space), weighted trilinearly and by
/// weight(voxel); 0 without bone.
template <typename Real, class Weight>
Real mean_density(const Voxmap& voxmap, const Eigen::Matrix<Real, 3, 1>& point, const Weight& weight) {
  const Eigen::Matrix<Real, 3, 1> base = point.array().floor();
  const Eigen::Matrix<Real, 3, 1> t = point - base;
  Real sum = 0, weights = 0;
  for (int i = 0; i < 8; ++i) {
    const Vec3i voxel = base.template cast<int>() + Vec3i(i & 1, i >> 1 & 1, i >> 2);
    if (!voxmap.grid.contains(voxel)) continue;
    const std::uint8_t grade = voxmap.grade.get(voxel);
    if (grade == 0) continue;
    const Real near =
        ((i & 1) ? t.x() : 1 - t.x()) * ((i >> 1 & 1) ? t.y() : 1 - t.y()) * ((i >> 2) ? t.z() : 1 - t.z());
    const Real w = near * weight(voxel);
    sum += w * static_cast<Real>(DensityMapping::density_from_grade(grade));
    weights += w;
  }
  return weights > 0 ? sum / weights : 0;
}

}  // namespace reamsim
