# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Reams with a constant axial force: a controller sets the feed rate of every step, as a thrust-controlled drive does.
Usage: constant_force.py SCENARIO FORCE_N DEPTH_MM"""
import sys

import numpy
import reamsim

GAIN_PER_S, MOST_MM_S = 100.0, 5.0

scenario, goal_n, goal_mm = sys.argv[1], float(sys.argv[2]), float(sys.argv[3])
simulation = reamsim.Simulation(scenario)
first, second = simulation.planned_poses()[:2]
feed_axis = second.position_mm - first.position_mm
feed_axis /= numpy.linalg.norm(feed_axis)
position_mm, feed_mm_s = first.position_mm.copy(), MOST_MM_S
step = simulation.start(position_mm, first.quaternion, first.spin_rpm)

steps = []
while step.depth_mm < goal_mm and len(steps) < 100_000:
    # The force is nearly proportional to the feed rate: changing that by a fraction settles alike in soft and hard bone.
    feed_mm_s *= 1 + GAIN_PER_S * simulation.frame_s * (1 - step.axial_force_n / goal_n)
    feed_mm_s = min(max(feed_mm_s, 0.001), MOST_MM_S)
    position_mm += feed_axis * feed_mm_s * simulation.frame_s
    step = simulation.step(position_mm, first.quaternion, first.spin_rpm)
    steps.append(step)

force_n = numpy.array([step.axial_force_n for step in steps])
second_half = force_n[len(force_n) // 2:]
print(f"{step.depth_mm:.2f} mm deep after {step.time_s:.2f} s, {simulation.removed_mm3:.1f} mm3 removed")
print(f"axial force over the second half: mean {second_half.mean():.2f} N, deviation {second_half.std():.2f} N")
