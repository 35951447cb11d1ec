// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "sim/base/geometry.h"

namespace reamsim {

/// The values of a basis: force (3) and torque (3) against the motion, force (3) and torque (3) along the normal,
/// energy, speed-floor energy.
inline constexpr std::size_t kBasisValues = 14;

/// What the voxels of one grade exert on the tool in one substep, per specific energy of 1 N/mm² = 1 mJ/mm³
/// (docs/physics.md, 4): force = u·(P + k_n·N). In T without spin. Grade 0 is the edge force: P per K_t, N per K_n.
struct GradeBasis {
  int grade = 0;
  std::array<double, kBasisValues> values{};

  [[nodiscard]] Vec3 force() const { return at(0); }                ///< P, mm²
  [[nodiscard]] Vec3 torque() const { return at(3); }               ///< P, mm³
  [[nodiscard]] Vec3 normal_force() const { return at(6); }         ///< N, mm²
  [[nodiscard]] Vec3 normal_torque() const { return at(9); }        ///< N, mm³
  [[nodiscard]] double energy() const { return values[12]; }        ///< mm³
  [[nodiscard]] double floor_energy() const { return values[13]; }  ///< mm³

 private:
  [[nodiscard]] Vec3 at(std::size_t first) const { return {values[first], values[first + 1], values[first + 2]}; }
};

/// The grades that lose volume in a substep, ascending.
using SubstepBasis = std::vector<GradeBasis>;

}  // namespace reamsim
