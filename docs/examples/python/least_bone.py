# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Searches the axis along which a reamer removes least bone until the back of an implant, a sphere like the reamer's, is
seated on all of its footprint. Seated is what lies at most 0.5 mm above bone, as in metrics.seating (docs/metrics.md, 7).
Usage: least_bone.py SCENARIO AXES SEED"""
import math
import sys

import numpy
import reamsim

BACK_RADIUS_MM, FOOTPRINT_MM, GAP_MM = 29.0, 20.0, 0.5   # of the back; diameter; most gap
TOOL_Z = numpy.array([0, 0, 1.0])
MOST_TILT_RAD, STEP_MM, ABOVE_MM, MOST_DEPTH_MM = math.radians(15), 0.1, 4.0, 6.0

scenario, axes, seed = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
simulation = reamsim.Simulation(scenario, bone__voxel_mm=0.5)
planned = simulation.planned_poses()[0]
bone, before_start = simulation.density, simulation.state()


def turned(vector, quaternion):
    """A vector, or an array of vectors, of the tool in the frame of the bone."""
    w, u = quaternion[0], quaternion[1:]
    return vector + 2 * numpy.cross(u, numpy.cross(u, vector) + w * vector)


def tilted(quaternion, about_x, about_y):
    """The rotation `quaternion` after a tilt about x and y of the tool, in rad."""
    half = math.hypot(about_x, about_y) / 2
    tilt = numpy.array([about_x, about_y, 0]) * (math.sin(half) / (2 * half) if half > 0 else 0.5)
    w, u = quaternion[0], quaternion[1:]
    return numpy.array([w * math.cos(half) - u @ tilt, *(w * tilt + math.cos(half) * u + numpy.cross(u, tilt))])


# Points GAP_MM below the back, all over the footprint but for the core that the cannula leaves: a peg replaces it.
radius, angle = numpy.meshgrid(numpy.linspace(1.5, FOOTPRINT_MM / 2, 20), numpy.linspace(0, 2 * math.pi, 60))
x, y, r = (radius * numpy.cos(angle)).ravel(), (radius * numpy.sin(angle)).ravel(), radius.ravel()
below_back = numpy.stack([x, y, BACK_RADIUS_MM - numpy.sqrt(BACK_RADIUS_MM**2 - r**2) - GAP_MM], axis=1)
# Axes are tilted about the point where the planned one enters the bone.
along = planned.position_mm - numpy.arange(0, 60, 0.1)[:, None] * turned(TOOL_Z, planned.quaternion)
entry_mm = along[numpy.argmax(numpy.nan_to_num(bone.at(along)) > 0)]


def bone_for(about_x, about_y, most_mm3):
    """Bone removed (mm³) and depth (mm) at which the implant is seated on this axis; infinite beyond `most_mm3`."""
    quaternion = tilted(planned.quaternion, about_x, about_y)
    axis = turned(TOOL_Z, quaternion)
    simulation.restore(before_start)
    simulation.start(entry_mm + ABOVE_MM * axis, quaternion, planned.spin_rpm)
    for height_mm in numpy.arange(ABOVE_MM - STEP_MM, -MOST_DEPTH_MM, -STEP_MM):
        origin_mm = entry_mm + height_mm * axis
        simulation.step(origin_mm, quaternion, planned.spin_rpm)
        if simulation.removed_mm3 >= most_mm3:
            break
        if simulation.removed_mm3 > 0:
            points_mm = origin_mm + turned(below_back, quaternion)
            if numpy.all(simulation.fill.interpolated(points_mm) >= 0.5):
                return simulation.removed_mm3, -height_mm
    return math.inf, math.nan


random = numpy.random.default_rng(seed)
best = (*bone_for(0, 0, math.inf), 0.0, 0.0)
print(f"seed {seed}; planned axis: {best[0]:.1f} mm3, {best[1]:.2f} mm deep")
for k in range(axes):
    # Around the best one so far, closer and closer.
    size, direction = MOST_TILT_RAD * (1 - k / axes) * math.sqrt(random.random()), random.uniform(0, 2 * math.pi)
    tilt = best[2] + size * math.cos(direction), best[3] + size * math.sin(direction)
    removed_mm3, depth_mm = bone_for(*tilt, best[0])
    if removed_mm3 < best[0]:
        best = removed_mm3, depth_mm, *tilt
print(f"best axis: {best[0]:.1f} mm3, {best[1]:.2f} mm deep; tilted by {math.degrees(best[2]):.1f} and "
      f"{math.degrees(best[3]):.1f} degrees about x and y of the tool")
