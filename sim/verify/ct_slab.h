// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <functional>
#include <vector>

#include "sim/bone/voxmap/voxmap.h"
#include "sim/verify/closed_forms.h"

namespace reamsim::verify {

/// A slab of bone in a CT with voxel averaging: radiodensity over the depth below a tilted face, soft tissue outside.
struct CtSlab {
  std::function<double(double depth_mm)> hu;  ///< linear between the breaks
  std::vector<double> breaks_mm = {};         ///< depths where `hu` has a step or a corner, besides the face
  double spacing_mm = 1;                      ///< of the scan
  double offset_voxels = 0;                   ///< of the face against the scan's voxels
  double tilt_deg = 0;
  double depth_mm = 6;  ///< greatest reamed depth
  double radius_mm = 5;

  [[nodiscard]] Vec3 outward() const;
  /// The point of the face in the middle of the reamed region.
  [[nodiscard]] Vec3 face_mm() const;
  /// Energy per volume of the bone down to a depth, by quadrature, mJ/mm³.
  [[nodiscard]] double specific_energy_to(double depth_mm) const;
};

inline constexpr double kSoftTissue_hu = 40;
inline constexpr double kSlabThreshold_hu = 226;

/// Scans the slab and imports it at `voxel_mm`, as `bone.source: ct` does.
FilledVoxmap scan_and_import(const CtSlab& slab, double voxel_mm);

}  // namespace reamsim::verify
