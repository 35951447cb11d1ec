# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""A robot holds the reamer with an impedance controller: a virtual mass on a spring and a damper follows the scenario's
motion, and the bone pushes it off. Usage: impedance.py SCENARIO STIFFNESS_N_MM MASS_KG"""
import sys

import numpy
import reamsim

scenario, stiffness_n_mm, mass_kg = sys.argv[1], float(sys.argv[2]), float(sys.argv[3])
mass = mass_kg / 1000                               # N·s²/mm
damping = 2 * numpy.sqrt(stiffness_n_mm * mass)     # N·s/mm: critical
simulation = reamsim.Simulation(scenario)
plan, dt = simulation.planned_poses(), simulation.frame_s
step = simulation.start(*plan[0])
position_mm, velocity, bone_damping = plan[0].position_mm.copy(), numpy.zeros(3), 0.0

lags_mm, forces_n = [], []
for before, goal in zip(plan, plan[1:]):
    spring_n = stiffness_n_mm * (goal.position_mm - position_mm)
    damper_n = damping * (goal.position_mm - before.position_mm) / dt
    # The force of the bone grows with the feed rate: taken at the end of the step, as F + bone_damping·(v_old − v_new). That
    # of the step before alone would make the loop unstable.
    bone_n = step.force_n + bone_damping * velocity
    velocity = (mass * velocity / dt + spring_n + damper_n + bone_n) / (mass / dt + damping + bone_damping)
    position_mm += velocity * dt
    step = simulation.step(position_mm, goal.quaternion, goal.spin_rpm)
    speed = numpy.linalg.norm(velocity)
    measured = max(0.0, -step.force_n @ velocity) / max(speed**2, 1e-6)
    bone_damping += 0.1 * (measured - bone_damping)     # a filter: a tool that hardly moves cuts unevenly
    lags_mm.append(numpy.linalg.norm(goal.position_mm - position_mm))
    forces_n.append(numpy.linalg.norm(step.force_n))

print(f"most force {max(forces_n):.2f} N, most deviation from the plan {max(lags_mm):.3f} mm")
print(f"{simulation.removed_mm3:.1f} mm3 removed")
