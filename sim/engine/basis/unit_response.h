// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include "kernels/window.h"
#include "sim/engine/common/force_basis.h"

namespace reamsim {

using BasisValues = std::array<double, kBasisValues>;

/// The arguments of a substep with the constants to which its forces are linear, one at a time: the law itself,
/// evaluated with each of them, gives the basis.
struct UnitArgs {
  /// `edges_per_turn`: cutting edges/2π, mm of edge per mm² of face at a radius of 1 mm; 0: no edge force.
  UnitArgs(const SubstepArgs& args, float edges_per_turn);

  SubstepArgs without_normal;  ///< k_n = 0
  SubstepArgs with_normal;     ///< k_n = 1
  SubstepArgs edge_along;      ///< K_t = 1 N/mm, K_n = 0
  SubstepArgs edge_normal;     ///< K_t = 0, K_n = 1 N/mm
};

/// The basis of a voxel next to `clip` that loses a unit of fill. `volume_mm3`: of the whole voxel.
BasisValues unit_response(const UnitArgs& args, const Clip& clip, float volume_mm3);

/// The basis of cutting edges in contact with a voxel; see rs_edge_force().
BasisValues edge_response(const UnitArgs& args, const Clip& clip, rs_i32 remaining, rs_i32 outside);

}  // namespace reamsim
