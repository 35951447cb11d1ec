// SPDX-FileCopyrightText: the reamsim authors
// SPDX-License-Identifier: Apache-2.0

// A robot's impedance controller: a spring pulls the reamer along its axis to a goal beyond the face of the bone.
// Usage: impedance SCENARIO GOAL_MM
#include <reamsim/simulation.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) try {
  if (argc != 3) return std::fprintf(stderr, "usage: impedance SCENARIO GOAL_MM\n"), 2;
  constexpr double kStiffness_n_mm = 40, kDamping_n_s_mm = 5, kMost_mm_s = 5;
  reamsim::Simulation simulation(argv[1]);
  const double goal_mm = std::atof(argv[2]);

  // The scenario's first two poses give the start and the direction of the axis.
  reamsim::Pose pose = simulation.planned_poses()[0];
  const reamsim::Pose next = simulation.planned_poses()[1];
  std::array<double, 3> axis{};
  double length = 0;
  for (int i = 0; i < 3; ++i) length += std::pow(next.position_mm[i] - pose.position_mm[i], 2);
  for (int i = 0; i < 3; ++i) axis[i] = (next.position_mm[i] - pose.position_mm[i]) / std::sqrt(length);
  pose.spin_angle_rad.reset();  // integrated by the simulation
  simulation.start(pose);

  double travel_mm = 0, force_n = 0;
  for (int k = 0; k < 3000; ++k) {
    // Spring and bone set the speed of a damped hand; the force is that of the step before.
    const double push_n = kStiffness_n_mm * (goal_mm - travel_mm) - force_n;
    const double feed_mm_s = std::fmin(std::fmax(push_n / kDamping_n_s_mm, 0), kMost_mm_s);
    travel_mm += feed_mm_s * simulation.frame_s();
    for (int i = 0; i < 3; ++i) pose.position_mm[i] += axis[i] * feed_mm_s * simulation.frame_s();
    force_n += 0.05 * (simulation.step(pose).axial_force_n - force_n);  // a filter keeps the loop stable
    if (k % 500 == 0) std::printf("%.3f s: travel %.3f mm, %.1f N\n", k * simulation.frame_s(), travel_mm, force_n);
  }
  std::printf("removed %.2f mm3\n", simulation.removed_mm3());
} catch (const reamsim::Error& error) {
  return std::fprintf(stderr, "%s\n", error.what()), 1;
}
