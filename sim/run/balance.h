// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <functional>
#include <tuple>
#include <vector>

#include "sim/base/geometry.h"
#include "sim/scenario/motion_settings.h"

namespace reamsim {

/// The hand and the tool it pushes, after a frame. Energies since the start of the push.
struct FeedState {
  double travel_mm = 0;           ///< along the line of the push
  double velocity_mm_s = 0;       ///< at the end of the frame; used where there is a mass
  double bone_n_s_mm = 0;         ///< resistance of the bone per feed, without edge forces, in the last frame
  std::int64_t still_frames = 0;  ///< up to the last one, in which the tool stood still under thrust
  double hand_mj = 0;             ///< work of the hand
  double spindle_work_mj = 0;     ///< work of the drive against the spin torque
  double damping_mj = 0;
  double kinetic_mj = 0;
  double lost_mj = 0;  ///< kinetic energy that bone took within frames beside the mean force (docs/feeds.md, 10)
};

/// What balances the force of the bone in a frame: F_bone(feed) + damping·feed + M·dv/dt = thrust.
struct ThrustBalance {
  double thrust_n = 0;
  double max_feed_mm_s = 0;
  double damping_n_s_mm = 0;
  double inertia_n_s_mm = 0;  ///< mass over the frame's time; 0: no mass
  double velocity_mm_s = 0;   ///< at the start of the frame
  double standing_n = 0;      ///< force of the bone on the resting tool: the edge force
};

struct FeedRate {
  double mm_s = 0;         ///< mean over the frame
  double end_mm_s = 0;     ///< at its end
  double bone_n = 0;       ///< force of the bone at this feed
  double bone_n_s_mm = 0;  ///< its slope: (bone_n − standing_n)/mm_s
  double middle = 1;       ///< the mean feed as a fraction of the way from the velocity before to that at the end
  bool limited = false;    ///< by max_feed_mm_s: the hand exerts less than the thrust
  int evaluations = 0;
};

/// Axial force of the bone at a feed above 0, N. Does not decrease with the feed, and may jump.
using BoneForce = std::function<double(double feed_mm_s)>;

/// The feed at which the forces balance; 0 where the bone holds the thrust at rest. `slope_n_s_mm`: that of the frame
/// before, for the first guess; 0: none. Between two frames the velocity approaches its steady value exponentially with
/// the rate (slope + damping)/M. The mean over the frame is therefore v₀ + θ·(v₁ − v₀) with θ = 1/(1 − e^(−λ)) − 1/λ
/// and λ = rate·Δt: exact for a constant slope, implicit, of second order for small steps (θ → 1/2) and without
/// oscillation for large ones (θ → 1).
FeedRate balanced_feed(const ThrustBalance& balance, const BoneForce& bone, double slope_n_s_mm);

/// Adds the energies of a frame, mJ. `frame_s`: its time. Returns the force of the hand, N.
double add_thrust_energies(const ThrustBalance& balance, const FeedRate& feed, double frame_s, FeedState& state);

/// Springs between the planned pose and the tool, after a substep. Vectors in T; energies since the start of the run.
struct SpringState {
  Vec3 deflection_mm = Vec3::Zero();
  Vec3 bone_n = Vec3::Zero();       ///< force of the bone in the last balance
  Vec3 tool_mm_s = Vec3::Zero();    ///< velocity of the tool's origin in it
  Mat3 bone_n_s_mm = Mat3::Zero();  ///< resistance −∂F/∂v there; zeros: not known
  double carriage_mj = 0;           ///< work of what moves the planned pose
  double spindle_work_mj = 0;       ///< work of the drive against the spin torque
  double spring_mj = 0;
  double damping_mj = 0;
  double lost_mj = 0;        ///< ½·k·Δd² of every substep: of the step in time (docs/feeds.md, 11)
  double unbalanced_mj = 0;  ///< work of what the balances miss
  std::int64_t limited_frames = 0;
  std::int64_t unbalanced_frames = 0;
  double unbalanced_n = 0;  ///< the most that a balance misses

  static auto fields(auto& s) {
    return std::tie(s.deflection_mm, s.bone_n, s.tool_mm_s, s.bone_n_s_mm, s.carriage_mj, s.spindle_work_mj,
                    s.spring_mj, s.damping_mj, s.lost_mj, s.unbalanced_mj, s.limited_frames, s.unbalanced_frames,
                    s.unbalanced_n);
  }
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

  [[nodiscard]] bool is_rigid(int axis) const { return stiffness_n_mm[axis] >= ComplianceSettings::kRigid_n_mm; }
};

/// Forces of the bone at deflections at the end of the substep, each from the bone as it is before, N.
using BoneForces = std::function<std::vector<Vec3>(const std::vector<Vec3>& deflections_mm)>;

struct Deflection {
  Vec3 mm = Vec3::Zero();
  Vec3 bone_n = Vec3::Zero();
  Mat3 bone_n_s_mm = Mat3::Zero();  ///< resistance of the bone, −∂F/∂v
  double missing_n = 0;             ///< of the balance
  bool limited = false;             ///< by most_mm
  bool balanced = true;
  int evaluations = 0;  ///< calls of BoneForces
};

/// The deflection at which the forces balance. The bone resists as a damper, F ≈ −A·v, and A/Δt exceeds the stiffness
/// by orders of magnitude. The first guess takes force, velocity and resistance of the substep before; steps of Newton
/// with Broyden's update of the resistance follow (Broyden 1965, doi:10.1090/S0025-5718-1965-0198670-6). Where a step
/// does not halve what is missing, one call evaluates differences for a new resistance and shorter steps. Where the
/// force jumps across the balance, the best point is taken, and `balanced` is false.
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
