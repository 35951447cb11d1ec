#pragma once

#include <openvdb/openvdb.h>

#include "render/occupancy.h"
#include "render/solid_field.h"

namespace reamsim {

/// The bone before reaming: where material has gone, and how deep below the old surface the new one lies. Made once per
/// run, from the run's last state.
class UnreamedSurface {
 public:
  /// Holes and slits up to twice this wide (a pilot hole, a cannula's core hole, a vessel) do not count as surface that
  /// depth is measured from.
  static constexpr double kBridge_mm = 1.8;

  /// `voxmap` with all that the run removes gone from its fill; `before`: the fill that it began with.
  UnreamedSurface(const Voxmap& voxmap, FillBricks before);
  /// Of a bone that began whole.
  explicit UnreamedSurface(const Voxmap& voxmap) : UnreamedSurface(voxmap, FillBricks(voxmap.grid.dims)) {}
  // `occupancy_` refers to `before_`.
  UnreamedSurface(const UnreamedSurface&) = delete;
  UnreamedSurface& operator=(const UnreamedSurface&) = delete;

  /// The unreamed bone's field, voxel index space.
  [[nodiscard]] const openvdb::FloatGrid& field() const { return field_.grid(); }
  /// Its surface, voxel index space.
  [[nodiscard]] const IsoSurface& surface() const { return surface_; }
  /// Distance in mm from the part of the unreamed surface that was reamed away, so that neither the far side of a thin
  /// bone nor the wall beside the tool counts. Known wherever material went, in the space of voxel indices times
  /// voxel_mm; 0 elsewhere.
  [[nodiscard]] const openvdb::FloatGrid& depth() const { return *depth_; }

 private:
  FillBricks before_;
  Occupancy occupancy_;
  SolidField field_;
  IsoSurface surface_;
  openvdb::FloatGrid::Ptr depth_;
};

}  // namespace reamsim
