# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Forces of a finished run for other constants of the force law (docs/physics.md, section 4).

A law is a dict of the scenario's keys by their dotted names, such as ``cutting.normal_ratio``.
"""

from __future__ import annotations

import dataclasses
import functools
import pathlib
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy
import scipy.sparse

from ..errors import InputError, ResultsError
from ..tables import number_array

if TYPE_CHECKING:
    from ..results import Run

GRADES = 256
_GRADE_STEP_G_CM3, _MOST_DENSITY_G_CM3, _MOST_GRADE = 0.008, 2.0, 250
MILLIJOULES = 1000  # per J
_DENSITY_KEYS = tuple("bone.density." + key for key in ("ash_slope_g_cm3_per_hu", "ash_offset_g_cm3", "ash_fraction"))
_LAW_KEYS = ("cutting.specific_energy_j_mm3", "cutting.reference_density_g_cm3", "cutting.density_exponent",
             "cutting.normal_ratio", *_DENSITY_KEYS)
# What a column of forces.csv is of the force and torque on the tool: force or torque, and the axis; 3: that of the tool.
CHANNELS = {"force_x_n": ("", 0), "force_y_n": ("", 1), "force_z_n": ("", 2), "torque_x_nmm": ("torque_", 0),
            "torque_y_nmm": ("torque_", 1), "torque_z_nmm": ("torque_", 2), "axial_force_n": ("", 3),
            "spin_torque_nmm": ("torque_", 3)}


def law_of(run: Run) -> dict[str, Any]:
    """The law of a run, from its scenario.yaml. Raises ResultsError where a key is missing."""
    def value(key: str) -> Any:
        at: Any = run.scenario
        for part in key.split("."):
            at = at.get(part) if isinstance(at, dict) else None
        return at

    law = {key: value(key) for key in _LAW_KEYS}
    missing = [key for key in _LAW_KEYS if law[key] is None]
    if missing:
        raise ResultsError(f"{run.dir / 'scenario.yaml'}: has no {missing[0]}; expected the scenario of a run with the "
                           "law energy")
    for key in ("cutting.specific_energy_table", "cutting.edge_force.tangential_n_mm",
                "cutting.edge_force.normal_n_mm"):
        if value(key) is not None:
            law[key] = value(key)
    return law


def grade_densities(law: Mapping[str, Any] | None = None, of_run: Mapping[str, Any] | None = None) -> numpy.ndarray:
    """Density of each grade, g/cm³, shape (256,); with `law` and `of_run`, what it is by the relation from HU to density
    of `law` where the run had that of `of_run`: at most 2."""
    density = _GRADE_STEP_G_CM3 * numpy.arange(GRADES)
    if law is None or of_run is None or all(law[key] == of_run[key] for key in _DENSITY_KEYS):
        return density
    slope, offset, fraction = (of_run[key] for key in _DENSITY_KEYS)
    hu = (density * fraction - offset) / slope
    slope, offset, fraction = (law[key] for key in _DENSITY_KEYS)
    return numpy.clip((slope * hu + offset) / fraction, 0, _MOST_DENSITY_G_CM3)


def specific_energies(law: Mapping[str, Any], of_run: Mapping[str, Any] | None = None) -> numpy.ndarray:
    """Specific cutting energy by grade, N/mm² = mJ/mm³, shape (256,): u₀·(ρ/ρ_ref)^p, or interpolated in the law's table;
    0 of grades that no voxel has. `of_run`: as in `grade_densities`."""
    density = grade_densities(law, of_run)
    table = law.get("cutting.specific_energy_table")
    if table:
        energy = numpy.interp(density, [row["density_g_cm3"] for row in table], [row["energy_j_mm3"] for row in table])
    else:
        relative = density / law["cutting.reference_density_g_cm3"]
        energy = law["cutting.specific_energy_j_mm3"] * relative ** law["cutting.density_exponent"]
    energy[0] = 0
    energy[_MOST_GRADE + 1:] = 0
    return MILLIJOULES * energy


@dataclasses.dataclass(frozen=True)
class Coefficients:
    """What the parts of a basis are multiplied by, shape (256, points): `p` and `n` of P and N by grade, N/mm². Grade 0
    is the edge force: K_t and K_n, N/mm."""

    p: numpy.ndarray
    n: numpy.ndarray

    @staticmethod
    def of_laws(laws: list[Mapping[str, Any]], of_run: Mapping[str, Any] | None = None) -> Coefficients:
        """Those of laws, a column each."""
        p = numpy.stack([specific_energies(law, of_run) for law in laws], axis=1)
        n = p * [law["cutting.normal_ratio"] for law in laws]
        for part, key in ((p, "cutting.edge_force.tangential_n_mm"), (n, "cutting.edge_force.normal_n_mm")):
            part[0] = [law.get(key, 0) for law in laws]
        return Coefficients(p, n)


class ForceBasis:
    """The force basis of a run, frame by frame (docs/columns.md, force_basis.npy).

    Attributes:
        time_s: of the frames, shape (frames,).
        tool_z: axis of the tool in the bone frame, shape (frames, 3).
        rows: force_basis.npy, a structured array.
    """

    def __init__(self, rows: numpy.ndarray, frame: numpy.ndarray, time_s: numpy.ndarray, tool_z: numpy.ndarray) -> None:
        """`frame`: numbers of the frames, ascending; `rows` without a frame there are left out."""
        place = numpy.searchsorted(frame, rows["frame"])
        known = (place < len(frame)) & (frame[numpy.minimum(place, len(frame) - 1)] == rows["frame"])
        self.time_s, self.tool_z, self.rows = time_s, tool_z, rows[known]
        self._place = place[known]

    @staticmethod
    def read(folder: str | pathlib.Path) -> ForceBasis:
        """That of a results folder. Raises InputError where the run has no force basis, or it is damaged;
        ResultsError where forces.csv is missing or damaged."""
        path = pathlib.Path(folder) / "force_basis.npy"
        try:
            rows = numpy.load(path)
            rows["energy_mm3"]
        except (OSError, ValueError, IndexError) as error:
            raise InputError([f"{path}: cannot be read: {error}; expected the force basis of a run with "
                              "output.force_basis: true"], 2) from error
        log = number_array(pathlib.Path(folder) / "forces.csv")
        return ForceBasis(rows, log["frame"], log["time_s"], tool_axis(log))

    @property
    def has_edge(self) -> bool:
        """Whether it has parts of an edge force."""
        return bool((self.rows["grade"] == 0).any())

    @functools.cached_property
    def volume_mm3(self) -> numpy.ndarray:
        """Removed volume by grade over all frames, shape (256,); with a size effect, weighted by its factor."""
        volume = numpy.bincount(self.rows["grade"], self.rows["energy_mm3"], GRADES)
        volume[0] = 0
        return volume

    def matrix(self, values: numpy.ndarray) -> scipy.sparse.csr_matrix:
        """A value of each row as a matrix, shape (frames, 256)."""
        return scipy.sparse.csr_matrix((values, (self._place, self.rows["grade"])), (len(self.time_s), GRADES))

    def parts(self, column: str) -> tuple[scipy.sparse.csr_matrix, scipy.sparse.csr_matrix]:
        """The parts P and N of a column of forces.csv (`CHANNELS`), shape (frames, 256)."""
        kind, axis = CHANNELS[column]
        unit = "mm3" if kind else "mm2"
        direction = self.tool_z[self._place] if axis == 3 else numpy.eye(3)[axis]
        p, n = (self.matrix((self.rows[f"{part}_{kind}{unit}"].astype(float) * direction).sum(axis=1)) for part in "pn")
        return p, n

    def values(self, column: str, coefficients: Coefficients) -> numpy.ndarray:
        """A column of forces.csv for other constants, shape (frames, points)."""
        p, n = self.parts(column)
        return p @ coefficients.p + n @ coefficients.n

    def energy_mj(self, coefficients: Coefficients) -> numpy.ndarray:
        """Cutting energy of each frame, shape (frames, points)."""
        return self.matrix(self.rows["energy_mm3"].astype(float)) @ coefficients.p


def tool_axis(log: numpy.ndarray) -> numpy.ndarray:
    """The axis +z of the tool in the bone frame from forces.csv, shape (frames, 3)."""
    w, x, y, z = (log["tool_q" + part] for part in "wxyz")
    return numpy.stack([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)], axis=1)
