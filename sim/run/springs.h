// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "sim/base/geometry.h"

namespace reamsim {

/// Springs between the planned pose and the tool, after a substep. Vectors in T; energies since the start of the run.
struct SpringState {
  std::array<double, 3> deflection_mm{};
  std::array<double, 3> bone_n{};       ///< force of the bone in the last balance
  std::array<double, 3> tool_mm_s{};    ///< velocity of the tool's origin in it
  std::array<double, 9> bone_n_s_mm{};  ///< resistance −∂F/∂v there; zeros: not known
  double carriage_mj = 0;               ///< work of what moves the planned pose
  double drill_mj = 0;                  ///< work of the drive against the spin torque
  double spring_mj = 0;
  double damping_mj = 0;
  double lost_mj = 0;        ///< ½·k·Δd² of every substep: of the step in time (docs/feeds.md, 11)
  double unbalanced_mj = 0;  ///< work of what the balances miss
  std::int64_t limited_frames = 0;
  std::int64_t unbalanced_frames = 0;
  double unbalanced_n = 0;  ///< the most that a balance misses
};

/// What balances the force of the bone in a substep, along each axis of T that is not rigid:
/// k·d + c·(d − d_before)/Δt = F_bone(d).
struct SpringBalance {
  Vec3 stiffness_n_mm = Vec3::Zero();  ///< ComplianceSettings::kRigid_n_mm: rigid
  double damping_n_s_mm = 0;
  Vec3 planned_mm = Vec3::Zero();  ///< displacement of the planned pose
  double duration_s = 0;
  double most_mm = 0;   ///< the deflection changes by no more
  double least_mm = 0;  ///< smaller differences of a position have no meaning

  [[nodiscard]] bool is_rigid(int axis) const;
};

/// Forces of the bone at deflections at the end of the substep, each from the bone as it is before, N.
using BoneForces = std::function<std::vector<Vec3>(const std::vector<Vec3>& deflections_mm)>;

/// The deflection at the end of a substep.
struct Deflection {
  Vec3 mm = Vec3::Zero();
  Vec3 bone_n = Vec3::Zero();
  Mat3 bone_n_s_mm = Mat3::Zero();  ///< resistance of the bone, −∂F/∂v
  double missing_n = 0;             ///< of the balance
  bool limited = false;             ///< by most_mm
  bool balanced = true;
  int evaluations = 0;  ///< calls of BoneForces
};

/// The deflection at which the forces balance.
///
/// The bone resists as a damper, F ≈ −A·v, and A/Δt exceeds the stiffness by orders of magnitude. The first guess
/// takes force, velocity and resistance of the substep before; steps of Newton with Broyden's update of the resistance
/// follow (Broyden 1965, doi:10.1090/S0025-5718-1965-0198670-6). Where a step does not halve what is missing, one call
/// evaluates differences for a new resistance and shorter steps. Where the force jumps across the balance, the best
/// point is taken, and `balanced` is false.
Deflection balanced_deflection(const SpringBalance& balance, const BoneForces& bone, const SpringState& before);

/// What was cut in a substep, in T.
struct PartWork {
  Vec3 bone_n = Vec3::Zero();
  Vec3 torque_nmm = Vec3::Zero();  ///< about the tool's origin
  Vec3 tilt_rad = Vec3::Zero();    ///< rotation of the planned pose, without spin
  double spin_rad = 0;
};

/// Adds the energies of a substep with the deflection `now`, and takes it into the state.
void add_spring_energies(const SpringBalance& balance, const Deflection& now, const PartWork& work, SpringState& state);

}  // namespace reamsim
