#pragma once

#include <openvdb/openvdb.h>

#include <memory>

#include "render/surface/unreamed_bone.h"

namespace reamsim {

/// Where material goes from a bone, and how deep below the old surface the new one lies. Made once per run, from the
/// state that the run ends in, or is foreseen to end in.
class UnreamedSurface {
 public:
  /// Of `voxmap` the lattice and the grades count; `last`: the fill from which all that the run removes is gone.
  UnreamedSurface(std::shared_ptr<const UnreamedBone> bone, const Voxmap& voxmap, const FillBricks& last);
  /// The last fill is the voxmap's. `before`: as in UnreamedBone.
  UnreamedSurface(const FilledVoxmap& voxmap, FillBricks before);
  /// Of a bone that began whole.
  explicit UnreamedSurface(const FilledVoxmap& voxmap) : UnreamedSurface(voxmap, FillBricks(voxmap.grid.dims)) {}

  /// The unreamed bone's fill.
  [[nodiscard]] const FillBricks& before() const { return bone_->before(); }
  /// Its field, voxel index space.
  [[nodiscard]] const openvdb::FloatGrid& field() const { return bone_->field().grid(); }
  /// Its surface, voxel index space.
  [[nodiscard]] const IsoSurface& surface() const { return bone_->surface(); }
  /// Distance in mm from the part of the unreamed surface that was reamed away, so that neither the far side of a thin
  /// bone nor the wall beside the tool counts. Known wherever material is gone from the last state, in the space of
  /// voxel indices times voxel_mm; 0 elsewhere.
  [[nodiscard]] const openvdb::FloatGrid& depth() const { return *depth_; }
  /// The greatest depth of the last state's surface, mm; 0 where nothing is reamed.
  [[nodiscard]] double deepest_mm() const { return deepest_mm_; }

 private:
  std::shared_ptr<const UnreamedBone> bone_;
  openvdb::FloatGrid::Ptr depth_;
  double deepest_mm_;
};

}  // namespace reamsim
