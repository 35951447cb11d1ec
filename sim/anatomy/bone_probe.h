// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>

#include "sim/base/geometry.h"
#include "sim/bone/voxmap/voxmap.h"

namespace reamsim {

/// The bone as a continuous field, for lines through it. The view must outlive the probe.
class BoneProbe {
 public:
  explicit BoneProbe(const BoneView& bone) : bone_(bone) {}

  /// The fraction of bone at a point of B, interpolated between the centres of voxels, 0…1.
  [[nodiscard]] double fraction(const Vec3& point_mm) const;
  /// Distance along `direction`, a unit vector, at which a line from `from_mm` enters bone: the fraction passes a half.
  /// nullopt where it does not within `most_mm`, or starts inside bone.
  [[nodiscard]] std::optional<double> distance_to_bone(const Vec3& from_mm, const Vec3& direction,
                                                       double most_mm) const;
  /// The same for leaving bone; nullopt where the line starts outside.
  [[nodiscard]] std::optional<double> distance_to_air(const Vec3& from_mm, const Vec3& direction, double most_mm) const;
  [[nodiscard]] double voxel_mm() const { return bone_.voxmap.grid.voxel_mm; }

 private:
  [[nodiscard]] double fraction_of(const Vec3i& voxel) const;
  [[nodiscard]] std::optional<double> crossing(const Vec3& from_mm, const Vec3& direction, double most_mm,
                                               bool into_bone) const;

  BoneView bone_;
};

}  // namespace reamsim
