# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Poses of the tool and the rows that steps give."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy
from numpy.typing import ArrayLike

from .errors import InputError
from .tables import INTEGERS, as_table

POSE = numpy.dtype([("position_mm", numpy.float64, 3), ("quaternion", numpy.float64, 4), ("spin_rpm", numpy.float64),
                    ("spin_angle_rad", numpy.float64)])
"""A pose of the tool in the bone frame: position of its origin, rotation w, x, y, z from tool to bone, spindle speed, and
the spin angle so far."""

# The pose in a row of forces.csv.
_COLUMNS = ("tool_x_mm", "tool_y_mm", "tool_z_mm", "tool_qw", "tool_qx", "tool_qy", "tool_qz", "spin_rpm")
_ANGLE = "spin_angle_rad"


class Step(NamedTuple):
    """What a step did: a row of forces.csv (docs/columns.md). Force and torque are those of the bone on the tool, means over
    the step, in the bone frame."""

    frame: int
    time_s: float
    tool_x_mm: float
    tool_y_mm: float
    tool_z_mm: float
    tool_qw: float
    tool_qx: float
    tool_qy: float
    tool_qz: float
    spin_rpm: float
    spin_angle_rad: float
    depth_mm: float
    force_x_n: float
    force_y_n: float
    force_z_n: float
    torque_x_nmm: float
    torque_y_nmm: float
    torque_z_nmm: float
    axial_force_n: float
    spin_torque_nmm: float
    contacts: int
    removed_mm3: float
    energy_mj: float
    floor_energy_mj: float
    balance: float
    # The column `pass`, a word that Python keeps to itself; a simulation has one tool.
    pass_: int

    @property
    def force_n(self) -> numpy.ndarray:
        """Force on the tool, N."""
        return numpy.array(self[12:15])

    @property
    def torque_nmm(self) -> numpy.ndarray:
        """Torque on the tool about its origin, N·mm."""
        return numpy.array(self[15:18])


def table_of_steps(values: numpy.ndarray) -> Any:
    """Rows of 26 numbers as `Run.forces` has them."""
    names = [name.rstrip("_") for name in Step._fields]
    return as_table({name: values[:, i].astype(numpy.int64 if name in INTEGERS else numpy.float64)
                     for i, name in enumerate(names)})


def poses_of_array(values: numpy.ndarray) -> numpy.ndarray:
    """Rows of 9 numbers as poses, without a copy."""
    return values.view(POSE)[:, 0].view(numpy.recarray)


def array_of_poses(poses: Any) -> numpy.ndarray:
    """Poses in one of the forms that `Simulation.run` takes, as rows of 8 or 9 numbers. Raises InputError where they
    have none of these forms."""
    names = _names_of(poses)
    if "position_mm" in names:
        wanted = ["position_mm", "quaternion", "spin_rpm"] + ["spin_angle_rad"] * ("spin_angle_rad" in names)
        return _stacked(poses, names, wanted)
    if names:
        return _stacked(poses, names, [*_COLUMNS] + [_ANGLE] * (_ANGLE in names))
    try:
        return numpy.ascontiguousarray(poses, dtype=numpy.float64)
    except (TypeError, ValueError) as error:
        raise InputError([f"poses: {error}; expected poses as of planned_poses(), a table with the columns of forces.csv, "
                          "or an array of shape (n, 8) or (n, 9)"], 2) from None


def _names_of(poses: Any) -> list[str]:
    if isinstance(poses, Mapping):
        return list(poses)
    dtype = getattr(poses, "dtype", None)
    if isinstance(dtype, numpy.dtype):
        return list(dtype.names or ())
    return [str(name) for name in getattr(poses, "columns", ())]  # pandas


def _stacked(poses: Any, names: list[str], wanted: list[str]) -> numpy.ndarray:
    missing = [name for name in wanted if name not in names]
    if missing:
        raise InputError([f"poses: have no column {missing[0]}; expected " + ", ".join(wanted)], 2)
    try:
        columns = [_two_dimensional(poses[name]) for name in wanted]
        return numpy.ascontiguousarray(numpy.hstack(columns))
    except (TypeError, ValueError) as error:
        raise InputError([f"poses: {error}"], 2) from None


def _two_dimensional(values: ArrayLike) -> numpy.ndarray:
    array = numpy.asarray(values, dtype=numpy.float64)
    return array[:, None] if array.ndim == 1 else array
