// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <optional>

#include "sim/engine/common/substep.h"

namespace reamsim {

/// Advance of the smallest loss that single precision tells, mm.
inline double smallest_advance_mm(double voxel_mm) {
  return least_loss(voxel_mm) * voxel_mm / RS_WHOLE_FILL;
}

/// The force of a slow motion is that between two advances, in smallest losses: the first takes what earlier frames
/// have left; up to the second the rounding of voxels, which is the same for all on a face along the lattice, is about
/// 0.2
/// %.
inline constexpr double kFirstLosses = 8, kSecondLosses = 64;

/// A trial of a slow motion: over these multiples of its time, at the same velocity. The mean force is the difference
/// of the two impulses over that of the times.
struct SlowTrial {
  double first = 0, second = 0;
};

/// nullopt for a motion that is not slow, or that is none.
inline std::optional<SlowTrial> slow_trial(double motion_mm, double smallest_mm) {
  constexpr double kRest = 1e-3;
  if (motion_mm >= kSecondLosses * smallest_mm || motion_mm < kRest * smallest_mm) return std::nullopt;
  return SlowTrial{kFirstLosses * smallest_mm / motion_mm, kSecondLosses * smallest_mm / motion_mm};
}

}  // namespace reamsim
