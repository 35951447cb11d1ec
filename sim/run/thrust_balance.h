// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

#pragma once

#include <cstdint>
#include <functional>

namespace reamsim {

/// The hand and the tool it pushes, after a frame. Energies since the start of the push.
struct FeedState {
  double travel_mm = 0;           ///< along the line of the push
  double velocity_mm_s = 0;       ///< at the end of the frame; used where there is a mass
  double bone_n_s_mm = 0;         ///< resistance of the bone per feed, without edge forces, in the last frame
  std::int64_t still_frames = 0;  ///< up to the last one, in which the tool stood still under thrust
  double hand_mj = 0;             ///< work of the hand
  double drill_mj = 0;            ///< work of the drive against the spin torque
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

/// The feed of a frame.
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
/// before, for the first guess; 0: none.
///
/// Between two frames the velocity approaches its steady value exponentially with the rate (slope + damping)/M. The
/// mean over the frame is therefore v₀ + θ·(v₁ − v₀) with θ = 1/(1 − e^(−λ)) − 1/λ and λ = rate·Δt: exact for a
/// constant slope, implicit, of second order for small steps (θ → 1/2) and without oscillation for large ones (θ → 1).
FeedRate balanced_feed(const ThrustBalance& balance, const BoneForce& bone, double slope_n_s_mm);

/// Adds the energies of a frame, mJ. `frame_s`: its time. Returns the force of the hand, N.
double add_thrust_energies(const ThrustBalance& balance, const FeedRate& feed, double frame_s, FeedState& state);

}  // namespace reamsim
