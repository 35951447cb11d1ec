// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <span>

#include "sim/bone/vdb/bone_vdb.h"
#include "sim/engine/basis/visit_basis.h"
#include "sim/engine/common/outline_table.h"
#include "sim/tool/tool.h"

namespace reamsim {

/// The force basis of `erosion: remove`, from the voxels that the engine removed.
class TouchedBasis {
 public:
  /// The voxmap must outlive it.
  TouchedBasis(const BoneView& bone, const Tool& tool)
      : voxmap_(&bone.voxmap), outline_(make_outline_table(tool.profile, bone.voxmap.grid.voxel_mm)) {}

  /// The basis of each substep. `removed`: voxels, and the places in `args` of the substeps that removed them.
  [[nodiscard]] std::vector<SubstepBasis> of(std::span<const SubstepArgs> args, const RemovedFrames& removed) const;

 private:
  [[nodiscard]] BasisValues response(const UnitArgs& args, const Vec3i& voxel) const;

  const Voxmap* voxmap_;
  OutlineTable outline_;
};

}  // namespace reamsim
