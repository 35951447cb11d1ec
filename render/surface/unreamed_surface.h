// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <memory>

#include "render/surface/solid_field.h"

namespace reamsim {

/// The bone before a run, and the depth below its surface where its actual or predicted final state lacks bone.
class UnreamedSurface {
 public:
  /// Fill before the run, from which depth is measured, and after it.
  UnreamedSurface(const Voxmap& voxmap, FillBricks before, const FillBricks& after);

  [[nodiscard]] const FillBricks& before() const { return before_; }
  /// Field of the unreamed bone, voxel index space.
  [[nodiscard]] const ScalarGrid& field() const { return field_.grid(); }
  /// Surface of the unreamed bone, voxel index space; triangles counter-clockwise seen from outside.
  [[nodiscard]] const IsoSurface& surface() const { return surface_; }
  /// Distance in mm from the reamed part of the unreamed surface; the far side of a thin bone and the wall beside the
  /// tool do not count. Nor do holes and slits up to 3.6 mm wide (a pilot hole, a cannula's core hole, a vessel).
  /// Defined wherever material was removed, in the space of voxel indices times voxel_mm; 0 elsewhere.
  [[nodiscard]] const ScalarGrid& depth() const { return *depth_; }
  /// The greatest depth of the final surface, mm; 0 when nothing is reamed.
  [[nodiscard]] double deepest_mm() const { return deepest_mm_; }

 private:
  FillBricks before_;
  SolidField field_;
  IsoSurface surface_;
  std::shared_ptr<const ScalarGrid> depth_;
  double deepest_mm_;
};

}  // namespace reamsim
