# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""step_cost.py [STEPS]: what a step of reamsim.Simulation costs, in and out of the bone. Out of the bone the simulator has
next to nothing to do, so a step costs there what the call from Python costs. Prints microseconds."""

import pathlib
import statistics
import sys
import time

import numpy
import reamsim

SCENARIO = pathlib.Path(__file__).resolve().parents[2] / "trajectories/half_space.yaml"
STEPS = int(sys.argv[1]) if len(sys.argv) > 1 else 4000
REPEATS = 5


def descent(simulation, from_mm, to_mm):
    """Poses one after another along z."""
    poses = numpy.repeat(simulation.planned_poses()[:1], STEPS).view(numpy.recarray)
    poses.position_mm[:, 2] = numpy.linspace(from_mm, to_mm, STEPS)
    return poses


def microseconds(simulation, poses, call):
    """Median time of a step of call(poses), from the same state each time."""
    state, times = simulation.state(), []
    for _ in range(REPEATS):
        simulation.restore(state)
        begun = time.perf_counter()
        call(poses)
        times.append((time.perf_counter() - begun) / STEPS * 1e6)
    simulation.restore(state)
    return statistics.median(times)


def steps(poses):
    places, quaternion, spin_rpm = poses.position_mm.tolist(), poses.quaternion[0].tolist(), float(poses.spin_rpm[0])
    for place in places:
        simulation.step(place, quaternion, spin_rpm)


simulation = reamsim.Simulation(SCENARIO, bone__voxel_mm=0.4)
simulation.start([0, 0, 60], [1, 0, 0, 0], 250)
for name, from_mm, to_mm in (("out of the bone", 60, 50), ("in the bone", 0, -0.002 * STEPS / 10)):
    poses = descent(simulation, from_mm, to_mm)
    print(f"{name}: step() {microseconds(simulation, poses, steps):.2f} us, "
          f"run() {microseconds(simulation, poses, simulation.run):.2f} us")
    simulation.step(*poses[-1])
grids_ms = []
for _ in range(REPEATS):
    simulation.step([0, 0, -1], [1, 0, 0, 0], 250)
    begun = time.perf_counter()
    voxels = simulation.fill.values.size
    grids_ms.append((time.perf_counter() - begun) * 1e3)
print(f"fill of {voxels / 1e6:.1f} million voxels: {statistics.median(grids_ms):.1f} ms")
