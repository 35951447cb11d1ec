#pragma once

#include <openvdb/openvdb.h>

#include "render/surface/solid_field.h"

namespace reamsim {

/// The surface moved out, which shuts narrow holes, and the distances that it was moved along. Where there is no
/// surface, there is none here either, and every distance is the background.
struct MovedSurface {
  double cell_mm = 0;
  openvdb::FloatGrid::Ptr distance_mm;  ///< from the surface; cells of `cell_mm`
  IsoSurface surface;                   ///< in the space of voxel indices times voxel_mm
};

/// What pictures need of the bone before the run takes anything from it. Needs nothing of the run itself, so that it
/// can be made beside the simulation.
class UnreamedBone {
 public:
  /// Holes and slits up to twice this wide (a pilot hole, a cannula's core hole, a vessel) do not count as surface that
  /// depth is measured from.
  static constexpr double kBridge_mm = 1.8;

  /// Of `voxmap` nothing but its lattice and its grades counts. `before`: the fill that the run began with, as
  /// with_gone_voxels_whole() gives it.
  UnreamedBone(const Voxmap& voxmap, FillBricks before);

  [[nodiscard]] const FillBricks& before() const { return before_; }
  /// Voxel index space.
  [[nodiscard]] const SolidField& field() const { return field_; }
  /// Its surface, voxel index space.
  [[nodiscard]] const IsoSurface& surface() const { return surface_; }
  /// The surface, kBridge_mm further out.
  [[nodiscard]] const MovedSurface& moved() const { return moved_; }

 private:
  FillBricks before_;
  SolidField field_;
  IsoSurface surface_;
  MovedSurface moved_;
};

}  // namespace reamsim
