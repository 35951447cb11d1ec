# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""The simulator in this process: the caller moves the tool step by step. Poses of the tool, and the rows that steps give."""

from __future__ import annotations

import contextlib
import functools
import importlib.util
import os
import pathlib
import sys
import sysconfig
from collections.abc import Mapping
from types import ModuleType
from typing import Any, NamedTuple

import numpy
from numpy.typing import ArrayLike

from .errors import InputError, ProgramNotFound
from .grid import Grid
from .program import __version__, find_program
from .scenario_text import assignments, scenario_file
from .tables import INTEGERS, as_table

POSE = numpy.dtype([("position_mm", numpy.float64, 3), ("quaternion", numpy.float64, 4), ("spin_rpm", numpy.float64),
                    ("spin_angle_rad", numpy.float64)])
"""A pose of the tool in the bone frame: position of its origin, rotation w, x, y, z from tool to bone, spindle speed, and
the spin angle so far."""

# The pose in a row of forces.csv.
_COLUMNS = ("tool_x_mm", "tool_y_mm", "tool_z_mm", "tool_qw", "tool_qx", "tool_qy", "tool_qz", "spin_rpm")
_ANGLE = "spin_angle_rad"
_MODULE = "reamsim._simulation"  # built with the program


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


_make_step = Step._make


class State:
    """Where a `Simulation` stood: bone, pose and sums."""

    def __init__(self, native: Any) -> None:
        self._native = native

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes the state to a file, in one piece: the path has the old or the new content. Raises RunError where
        the file cannot be written."""
        self._native.save(os.fsencode(path))

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> State:
        """Reads a file of `save`. Raises InputError where the file is missing, damaged or another one."""
        return cls(simulation_module().State.load(os.fsencode(path)))


class Simulation:
    """Bone and tool of a scenario; the caller gives the poses of the tool and gets the forces.

    Positions are in mm in the bone frame, quaternions w, x, y, z from the tool to the bone. One thread at a time; the GIL is
    released while it computes. Several simulations may exist at a time, but none in a process that was forked from one with
    a simulation (``multiprocessing``: use ``spawn``).

    Args:
        scenario: path of a YAML file, name of a shipped scenario (``"default"``), or the scenario as a dict. Paths in a dict
            are relative to the current folder. Its motion gives `planned_poses` and `frame_s`.
        settings: keys to change, by their dotted names: ``{"bone.voxel_mm": 0.4}``. None deletes a key.
        device: OpenCL device, or ``serial``.
        **overrides: keys to change, with ``__`` for the dot: ``bone__voxel_mm=0.4``.

    Raises:
        InputError: the scenario is wrong; ``.lines`` has a line per mistake.
        RunError: a device or the memory failed.
        ProgramNotFound: the module behind this class is missing; the message says how to get it.
    """

    def __init__(self, scenario: str | os.PathLike[str] | Mapping[str, Any], settings: Mapping[str, Any] | None = None, *,
                 device: str | None = None, **overrides: Any) -> None:
        keys = dict(settings or {}) | ({} if device is None else {"engine.device": device})
        with scenario_file(scenario) as path:
            self._native = simulation_module().Simulation(
                os.fsencode(path), [text.encode() for text in assignments(keys, overrides)])
        self._step, self._peek = self._native.step, self._native.peek
        self._fill: Grid | None = None

    def start(self, position_mm: ArrayLike, quaternion: ArrayLike, spin_rpm: float,
              spin_angle_rad: float | None = None) -> Step:
        """Frame 0: puts the tool somewhere. With ``cutting.erosion: exact``, bone inside it is removed without
        force. Raises InputError where the pose is wrong, or the simulation has started."""
        self._fill = None
        return _make_step(self._native.start(position_mm, quaternion, spin_rpm, spin_angle_rad))

    def step(self, position_mm: ArrayLike, quaternion: ArrayLike, spin_rpm: float, spin_angle_rad: float | None = None,
             dt_s: float | None = None) -> Step:
        """Moves the tool to a pose in `dt_s` seconds, without it `frame_s`. Without `spin_angle_rad` the spin angle
        is the integral of the speed. Raises InputError where a pose or time is wrong, or `start` has not been
        called. Nothing has changed then."""
        self._fill = None
        return _make_step(self._step(position_mm, quaternion, spin_rpm, spin_angle_rad, dt_s))

    def peek(self, position_mm: ArrayLike, quaternion: ArrayLike, spin_rpm: float, spin_angle_rad: float | None = None,
             dt_s: float | None = None) -> Step:
        """What `step` would return, without removing bone. With ``cutting.erosion: exact`` only."""
        return _make_step(self._peek(position_mm, quaternion, spin_rpm, spin_angle_rad, dt_s))

    def run(self, poses: Any) -> Any:
        """Steps to poses that are known ahead, `frame_s` apart, in batches: faster, and with windows of smooth motion as
        `reamsim.run` (docs/erosion.md, 3). Before `start`, the first pose is that of `start`.

        Args:
            poses: poses as of `planned_poses`; a table with the columns of forces.csv, such as `Run.forces`; or an array of
                shape (n, 8), position, quaternion, spindle speed, or (n, 9), with the spin angle.

        Returns:
            A row per pose, with the columns of `Run.forces`: a pandas DataFrame, or a numpy record array without pandas.

        Raises:
            InputError: a pose is wrong. Nothing has changed then.
            KeyboardInterrupt: Ctrl-C. The simulation stands after the frame `frame`, and can go on.
        """
        rows = _array_of_poses(poses)
        self._fill = None
        values = self._native.run(rows)
        names = [name.rstrip("_") for name in Step._fields]
        return as_table({name: values[:, i].astype(numpy.int64 if name in INTEGERS else numpy.float64)
                         for i, name in enumerate(names)})

    def planned_poses(self) -> numpy.ndarray:
        """The poses of the scenario's motion, one per frame: a record array with the fields ``position_mm`` (3 numbers),
        ``quaternion`` (4), ``spin_rpm`` and ``spin_angle_rad``. ``simulation.step(*pose)`` takes one of them."""
        return _poses_of_array(self._native.planned_poses())

    @property
    def pose(self) -> numpy.record | None:
        """The present pose, as one of `planned_poses`; None before `start`."""
        pose = self._native.pose()
        return None if pose is None else _poses_of_array(pose)[0]

    @property
    def frame(self) -> int:
        """The frame of the last step."""
        return self._native.frame()

    @property
    def frame_s(self) -> float:
        """Duration of a step, 1/``motion.frame_rate_hz``."""
        return self._native.frame_s()

    @property
    def removed_mm3(self) -> float:
        """Bone removed so far, mm³."""
        return self._native.removed_mm3()

    @property
    def fill(self) -> Grid:
        """Remaining fraction of each voxel: 1 whole, 0 removed or without bone. `Grid.values` is read-only, and never
        changes: after a step the property gives a new array, and until then the same one."""
        if self._fill is None:
            self._fill = _grid(self._native.fill(), "")
        return self._fill

    @functools.cached_property
    def density(self) -> Grid:
        """Density of the bone before reaming, g/cm³; 0 without bone. Read-only."""
        return _grid(self._native.density(), "g/cm³")

    def state(self) -> State:
        """The present state. It shares the memory of bone that no later step changes."""
        return State(self._native.state())

    def restore(self, state: State) -> None:
        """Goes back to a state of this simulation, or of another one with the same bone. Raises InputError where the
        state is one of another bone."""
        self._fill = None
        self._native.restore(state._native)


def _grid(parts: tuple[numpy.ndarray, tuple[float, ...], float], unit: str) -> Grid:
    values, center_mm, voxel_mm = parts
    return Grid(values, numpy.array(center_mm), voxel_mm, unit=unit)


def _poses_of_array(values: numpy.ndarray) -> numpy.ndarray:
    """Rows of 9 numbers as poses, without a copy."""
    return values.view(POSE)[:, 0].view(numpy.recarray)


def _array_of_poses(poses: Any) -> numpy.ndarray:
    """Poses in one of the forms that `Simulation.run` takes, as rows of 8 or 9 numbers. Raises InputError where they
    have none of these forms."""
    names = _names_of(poses)
    if names:
        wanted = ["position_mm", "quaternion", "spin_rpm"] if "position_mm" in names else [*_COLUMNS]
        return _stacked(poses, names, wanted + [_ANGLE] * (_ANGLE in names))
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
        columns = [numpy.asarray(poses[name], dtype=numpy.float64) for name in wanted]
        return numpy.ascontiguousarray(numpy.hstack([one[:, None] if one.ndim == 1 else one for one in columns]))
    except (TypeError, ValueError) as error:
        raise InputError([f"poses: {error}"], 2) from None


@functools.cache
def simulation_module() -> ModuleType:
    """The module: beside this package, otherwise of the installation or the build of the program that `find_program`
    finds. Raises ProgramNotFound where there is none for this Python, or it is one of another version."""
    # Pins PoCL's worker threads to their cores, as the program does. Must be set before OpenCL is loaded.
    os.environ.setdefault("POCL_AFFINITY", "1")
    file = "_simulation" + sysconfig.get_config_var("EXT_SUFFIX")
    candidates = [pathlib.Path(__file__).resolve().parent / file]
    with contextlib.suppress(ProgramNotFound):
        folder = pathlib.Path(find_program()).resolve().parent  # .../bin, or BUILD/cli
        packages = "lib/python{}.{}/dist-packages/reamsim".format(*sys.version_info[:2])
        candidates += [folder.parent / packages / file, folder.parent / "python" / file]
    path = next((path for path in candidates if path.is_file()), None)
    if path is None:
        raise ProgramNotFound(
            "reamsim.Simulation needs the module _simulation, which is built with the program for Debian's Python: build it "
            "with ./run.sh, install it with `cmake --install build/release`, or set REAMSIM_PROGRAM to a program that has "
            "it; searched: " + ", ".join(str(path) for path in candidates))
    spec = importlib.util.spec_from_file_location(_MODULE, path)
    assert spec is not None and spec.loader is not None
    try:
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    except ImportError as error:
        raise ProgramNotFound(f"{path}: cannot be loaded: {error}") from error
    if module.__version__ != __version__:
        raise ProgramNotFound(f"{path}: is of version {module.__version__}, and this package of version {__version__}: "
                              "install both from the same checkout")
    sys.modules[_MODULE] = module
    return module
