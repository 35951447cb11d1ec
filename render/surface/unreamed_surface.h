#pragma once

#include <memory>

#include "render/surface/solid_field.h"

namespace reamsim {

/// The bone before a run, and how deep below its surface a point lies where the run removes material. Made once per
/// run, from the state that the run ends in, or is predicted to end in.
class UnreamedSurface {
 public:
  /// `before`: the fill that depth is measured from; `last`: what is left of it in the end.
  UnreamedSurface(const Voxmap& voxmap, FillBricks before, const FillBricks& last);

  /// The unreamed bone's fill.
  [[nodiscard]] const FillBricks& before() const { return before_; }
  /// Its field, voxel index space.
  [[nodiscard]] const ScalarGrid& field() const { return field_.grid(); }
  /// Its surface, voxel index space. Triangles are counter-clockwise seen from outside.
  [[nodiscard]] const IsoSurface& surface() const { return surface_; }
  /// Distance in mm from the part of the unreamed surface that was reamed away, so that neither the far side of a thin
  /// bone nor the wall beside the tool counts. Holes and slits up to 3.6 mm wide (a pilot hole, a cannula's core hole,
  /// a vessel) do not count as surface. Known wherever the last state has lost material, in the space of voxel indices
  /// times voxel_mm; 0 elsewhere.
  [[nodiscard]] const ScalarGrid& depth() const { return *depth_; }
  /// The greatest depth of the last state's surface, mm; 0 where nothing is reamed.
  [[nodiscard]] double deepest_mm() const { return deepest_mm_; }

 private:
  FillBricks before_;
  SolidField field_;
  IsoSurface surface_;
  std::shared_ptr<const ScalarGrid> depth_;
  double deepest_mm_;
};

}  // namespace reamsim
