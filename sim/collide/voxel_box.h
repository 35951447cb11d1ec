#pragma once

#include "kernels/shared.h"
#include "sim/bone/voxmap.h"

namespace reamsim {

/// A box of voxels, corners included; empty where `max` lies below `min` on some axis.
struct VoxelBox {
  Vec3i min = Vec3i::Zero();
  Vec3i max = Vec3i::Constant(-1);

  [[nodiscard]] bool empty() const { return (max.array() < min.array()).any(); }
  /// Voxels along each axis; 0, 0, 0 for an empty box.
  [[nodiscard]] Vec3i size() const { return empty() ? Vec3i(Vec3i::Zero()) : Vec3i(max - min + Vec3i::Ones()); }
};

/// The box of the voxels that are bone, gone or not.
VoxelBox bone_voxels(const Voxmap& voxmap);

/// The volume of interest in voxmap coordinates (paper §4.3.2): the voxels of `bone` whose centres can lie in
/// `tool_box` (T, mm) in the substep's pose. It overestimates, and never misses.
VoxelBox voxel_voi(const SubstepArgs& args, const Aabb& tool_box, const VoxelBox& bone);

}  // namespace reamsim
