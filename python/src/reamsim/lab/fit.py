# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""The constants of the force law that best explain measured forces (docs/physics.md, "Constants from a measurement")."""

from __future__ import annotations

import dataclasses
import itertools
import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy

from ..errors import InputError
from .force_model import GRADES, MILLIJOULES, Coefficients, ForceBasis, grade_densities
from .least_squares import Problem, minimum, nonnegative

CLASS_GAP_G_CM3 = 0.05
_MOST_NORMAL_RATIO, _MOST_EXPONENT = 10.0, 5.0  # ranges of the searches: those of the scenario keys
_LEAST_NOISE = 1e-7  # relative: without noise, weights would grow without limit
_NEGLIGIBLE = 1e-8  # a part whose square is smaller, relative to the whole, says nothing about its constant
_LEAST_SPREAD = 0.02  # logarithms of density with a smaller standard deviation, by removed volume, tell no exponent
_SINGULAR = 1e-12  # of an eigenvalue of the information, relative
# A constant with a larger standard error is not determined: relative to its value, or of an exponent.
_MOST_RELATIVE_ERROR, _MOST_EXPONENT_ERROR = 0.5, 1.0
_HIGH_CORRELATION = 0.99  # constants with a higher one are hard to tell apart
_WORSE_THAN_MEAN = -0.05  # a larger R² may come from noise about a mean that the law explains well
# Specific energies beside which the unit of a column is likelier to be wrong than the bone to be unusual: this fraction
# of the least that the project assumes at a density, and several times that of the thinnest chips (docs/physics.md, 4).
_OF_LEAST_ENERGY, _MOST_ENERGY_J_MM3 = 0.1, 20.0


@dataclasses.dataclass
class Constant:
    """A fitted constant. `standard_error`: NaN where it was not fitted, so that its value is that of the run, or is 0
    because a negative value would fit better (`at_bound`)."""

    name: str
    value: float
    fitted: bool = True
    standard_error: float = float("nan")

    @property
    def at_bound(self) -> bool:
        return self.fitted and self.value <= 0

    @property
    def unit(self) -> str:
        return "J/mm3" if self.name.startswith("u") else "N/mm" if self.name.startswith("K") else ""


@dataclasses.dataclass
class DensityClass:
    """Grades that share a specific energy. `mean_g_cm3`: by removed volume."""

    least_g_cm3: float
    most_g_cm3: float
    mean_g_cm3: float
    removed_mm3: float
    grades: list[int]


@dataclasses.dataclass(frozen=True)
class Residual:
    """The part of a measured column that the fit does not explain. `r_squared`: fraction of the variance explained."""

    column: str
    samples: int
    rms_measured: float
    rms: float
    r_squared: float


@dataclasses.dataclass
class ForceFit:
    """A fit. Constants: u0, p (law) or u1, u2, ... (classes), J/mm³; k_n; K_t, K_n, N/mm, where the run had an edge force."""

    constants: list[Constant]
    covariance: numpy.ndarray  # of the constants `free`, in their order; the scatter of the residuals included
    classes: list[DensityClass]
    residuals: list[Residual]
    coefficients: Coefficients  # for `ForceBasis.values`
    statements: list[str] = dataclasses.field(default_factory=list)  # which constants the data cannot tell
    warnings: list[str] = dataclasses.field(default_factory=list)  # signs of a wrong unit or sign of a measured column

    def __getitem__(self, name: str) -> Constant:
        return next(constant for constant in self.constants if constant.name == name)

    @property
    def mean_g_cm3(self) -> float:
        """Density of the removed bone by its volume."""
        volume = sum(one.removed_mm3 for one in self.classes)
        return sum(one.mean_g_cm3 * one.removed_mm3 for one in self.classes) / volume if volume > 0 else 0

    @property
    def free(self) -> list[int]:
        """Places of the constants that `covariance` has."""
        return [i for i, constant in enumerate(self.constants) if constant.fitted and not constant.at_bound]


def density_classes(volume_mm3: numpy.ndarray, edges_g_cm3: Sequence[float] = ()) -> list[DensityClass]:
    """Classes of the removed bone, `volume_mm3` by grade, shape (256,), between ascending densities; without these a class
    ends where there is a gap of more than 0.05 g/cm³."""
    out: list[DensityClass] = []
    density = grade_densities()
    place = numpy.searchsorted(numpy.asarray(edges_g_cm3, dtype=float), density, side="right")
    before = 0
    for grade in numpy.flatnonzero(volume_mm3 > 0):
        value, volume = float(density[grade]), float(volume_mm3[grade])
        same = (place[grade] == place[before]) if len(edges_g_cm3) else value - density[before] <= CLASS_GAP_G_CM3
        if not out or not same:
            out.append(DensityClass(value, value, 0, 0, []))
        to = out[-1]
        to.mean_g_cm3 = (to.mean_g_cm3 * to.removed_mm3 + value * volume) / (to.removed_mm3 + volume)
        to.most_g_cm3, to.removed_mm3, before = value, to.removed_mm3 + volume, grade
        to.grades.append(int(grade))
    return out


def fit_forces(basis: ForceBasis, law: Mapping[str, Any], time_s: numpy.ndarray, measured: Mapping[str, numpy.ndarray], *,
               model: str = "law", class_edges_g_cm3: Sequence[float] = (), fit_normal_ratio: bool = True,
               file: str = "", limits: Mapping[str, Any] | None = None) -> ForceFit:
    """Least squares, weighted by the noise of each column, which is estimated from the residuals.

    Args:
        basis: of a run of the experiment.
        law: of that run (`force_model.law_of`).
        time_s: of the measurement, ascending, shape (times,).
        measured: values by column of forces.csv (`force_model.CHANNELS`), NaN where nothing was measured.
        model: ``law``: u0 and p of u0·(density/reference)^p; ``classes``: one specific energy per density class.
        class_edges_g_cm3: as in `density_classes`.
        fit_normal_ratio: False keeps k_n of the run.
        file, limits: of the measurement, for messages; as in `_warnings`, without it they are about the columns alone.

    Raises:
        InputError: no measured time lies in the run's contact, or no positive constant explains what was measured.
    """
    fit = _Fit(basis, law, time_s, measured, model == "law", class_edges_g_cm3, fit_normal_ratio)
    out = fit.solved()
    if fit.fix_undetermined(out):
        out = fit.solved()
    fit.require_energy(out, file)
    out.warnings = _warnings(out, law["cutting.reference_density_g_cm3"], limits)
    out.statements = fit.statements(out, fit_normal_ratio)
    return out


class _Fit:
    """The shape of u over the units, and the searches for p and k_n."""

    def __init__(self, basis: ForceBasis, law: Mapping[str, Any], time_s: numpy.ndarray,
                 measured: Mapping[str, numpy.ndarray], is_law: bool, edges: Sequence[float], fit_normal_ratio: bool) -> None:
        self.law, self.is_law = law, is_law
        self.classes = density_classes(basis.volume_mm3, edges)
        units = [[grade] for one in self.classes for grade in one.grades] if is_law else [one.grades for one in self.classes]
        self.problem = Problem(basis, time_s, dict(measured), units)
        self.unit_grades = units
        density = grade_densities()[[unit[0] for unit in units]]
        self.log_density = numpy.log(density / law["cutting.reference_density_g_cm3"])
        self.exponent, self.normal_ratio = law["cutting.density_exponent"], law["cutting.normal_ratio"]
        self.fit_exponent = is_law and _density_spread(basis.volume_mm3) >= _LEAST_SPREAD
        p, n = ((part.sum(axis=1) ** 2).sum() for part in self._parts()[:2])
        self.normal_matters = bool(n > _NEGLIGIBLE * p)
        self.fit_normal_ratio = fit_normal_ratio and self.normal_matters

    def _parts(self) -> tuple[numpy.ndarray, numpy.ndarray, numpy.ndarray, numpy.ndarray]:
        """Columns of the problem: P, N, edge, measured values."""
        rows, n = self.problem.rows, self.problem.units
        return rows[:, :n], rows[:, n:2 * n], rows[:, 2 * n:-1], rows[:, -1]

    def _shape(self, exponent: float) -> numpy.ndarray:
        """u of the units for constants of 1 J/mm³, shape (units, constants), N/mm²."""
        if self.is_law:
            return MILLIJOULES * numpy.exp(exponent * self.log_density)[:, None]
        return MILLIJOULES * numpy.eye(self.problem.units)

    def solved(self) -> ForceFit:
        """The best constants; the weights follow from the residuals three times."""
        self.problem.weigh()
        self._search()
        for _ in range(3):
            self.problem.weigh(self._coefficients(), _LEAST_NOISE)
            self._search()
        return self._result()

    def _search(self) -> None:
        if self.fit_exponent:
            self.exponent = minimum(lambda p: self._best_of_exponent(p)[2:], 0, _MOST_EXPONENT, 20)
        self.normal_ratio, self.linear = self._best_of_exponent(self.exponent)[:2]

    def _best_of_exponent(self, exponent: float) -> tuple[float, numpy.ndarray, float, float]:
        """For an exponent: k_n, the linear constants (u, K_t, K_n), the squares, and their slope over the exponent."""
        p, n, edge, values = self._parts()
        shape = self._shape(exponent)
        change = shape * self.log_density[:, None]
        own = shape.shape[1]
        parts = numpy.concatenate([p @ shape, n @ shape, edge, values[:, None], p @ change, n @ change], axis=1)
        parts = numpy.linalg.qr(parts, mode="r")
        p, n, p_change, n_change = (parts[:, i:i + own] for i in (0, own, parts.shape[1] - 2 * own, parts.shape[1] - own))
        edge, values = parts[:, 2 * own:-2 * own - 1], parts[:, -2 * own - 1]

        def solve(normal_ratio: float) -> tuple[numpy.ndarray, numpy.ndarray]:
            matrix = numpy.concatenate([p + normal_ratio * n, edge], axis=1)
            linear = nonnegative(matrix, values)
            return linear, values - matrix @ linear

        def slope(normal_ratio: float) -> tuple[float, float]:
            # At the best linear constants, the squares change with k_n as if those were fixed.
            linear, rest = solve(normal_ratio)
            return float(rest @ rest), float(-2 * rest @ (n @ linear[:own]))

        ratio = minimum(slope, 0, _MOST_NORMAL_RATIO, 40) if self.fit_normal_ratio else self.normal_ratio
        linear, rest = solve(ratio)
        return ratio, linear, float(rest @ rest), float(-2 * rest @ ((p_change + ratio * n_change) @ linear[:own]))

    def _coefficients(self) -> numpy.ndarray:
        """Of the columns of the problem."""
        shape = self._shape(self.exponent)
        u = shape @ self.linear[:shape.shape[1]]
        return numpy.concatenate([u, self.normal_ratio * u, self.linear[shape.shape[1]:]])

    def without_energy(self) -> bool:
        """Whether every specific energy is 0. Then nothing tells k_n and p."""
        return not self.linear[:1 if self.is_law else self.problem.units].any()

    def fix_undetermined(self, fit: ForceFit) -> bool:
        """Fixes k_n and p where their errors show that the data do not tell them: they would only spoil the others.
        Returns whether it did."""
        least_ratio = _MOST_RELATIVE_ERROR * max(self.normal_ratio, 0.1)
        normal = self.fit_normal_ratio and (self.without_energy() or fit["k_n"].standard_error > least_ratio)
        exponent = self.fit_exponent and (self.without_energy() or
                                          fit["p"].standard_error > _MOST_EXPONENT_ERROR)
        if normal:
            self.fit_normal_ratio = self.normal_matters = False
            self.normal_ratio = self.law["cutting.normal_ratio"]
        if exponent:
            self.fit_exponent, self.exponent = False, self.law["cutting.density_exponent"]
        return normal or exponent

    def require_energy(self, fit: ForceFit, file: str) -> None:
        """Raises InputError where every coefficient is 0: the measured columns are wrong."""
        if self.linear.any():
            return
        if all(residual.rms_measured == 0 for residual in fit.residuals):
            found = "every measured value in the time of contact is 0; check the columns, and that time_s begins with the run"
        else:
            found = (f"{fit.constants[0].name} is 0: a negative value would fit better; check the sign of each column: "
                     "axial_force_n is positive where the bone pushes the tool out, spin_torque_nmm where it brakes a "
                     "positive spin_rpm; reverse the sign of a load cell that measures the force on the bone")
        raise InputError([f"{file}: {found}" if file else found], 2)

    def _result(self) -> ForceFit:
        own = 1 if self.is_law else self.problem.units
        if self.is_law:
            constants = [Constant("u0", float(self.linear[0])), Constant("p", self.exponent, self.fit_exponent)]
        else:
            constants = [Constant(f"u{i + 1}", float(self.linear[i])) for i in range(own)]
        constants.append(Constant("k_n", self.normal_ratio, self.fit_normal_ratio))
        constants += [Constant(name, float(value)) for name, value in zip(("K_t", "K_n"), self.linear[own:])]
        c = self._coefficients()
        out = ForceFit(constants, numpy.empty((0, 0)), self.classes,
                       [_residual(channel, c) for channel in self.problem.channels], self._of_grades(c))
        if out.free:
            out.covariance = self._covariance(out.free)
            for place, error in zip(out.free, numpy.sqrt(numpy.diagonal(out.covariance))):
                constants[place].standard_error = float(error)
        return out

    def _derivatives(self) -> numpy.ndarray:
        """Of the coefficients by the constants, in their order."""
        n, c, shape = self.problem.units, self._coefficients(), self._shape(self.exponent)
        columns = numpy.zeros((self.problem.columns, shape.shape[1] + 1 + self.is_law + 2 * self.problem.has_edge))
        columns[:2 * n, :shape.shape[1]] = numpy.concatenate([shape, self.normal_ratio * shape])
        at = shape.shape[1]
        if self.is_law:
            columns[:2 * n, at] = c[:2 * n] * numpy.tile(self.log_density, 2)
            at += 1
        columns[n:2 * n, at] = c[:n]
        if self.problem.has_edge:
            columns[2 * n:, at + 1:] = numpy.eye(2)
        return columns

    def _covariance(self, free: list[int]) -> numpy.ndarray:
        change = self.problem.rows[:, :-1] @ self._derivatives()[:, free]
        information = change.T @ change
        scale = 1 / numpy.maximum(numpy.sqrt(numpy.diagonal(information)), 1e-150)
        values, vectors = numpy.linalg.eigh(scale[:, None] * information * scale)
        vectors = scale[:, None] * vectors
        variance = self.problem.squares(self._coefficients()) / max(1, self.problem.samples - len(free))
        with numpy.errstate(over="ignore", invalid="ignore"):  # infinite where a constant changes nothing
            return variance * ((vectors / numpy.maximum(values, _SINGULAR)) @ vectors.T)

    def _of_grades(self, c: numpy.ndarray) -> Coefficients:
        p, n = numpy.zeros((GRADES, 1)), numpy.zeros((GRADES, 1))
        for unit, grades in enumerate(self.unit_grades):
            p[grades, 0] = c[unit]
        n[:] = self.normal_ratio * p
        if self.problem.has_edge:
            p[0, 0], n[0, 0] = c[-2:]
        return Coefficients(p, n)

    def statements(self, fit: ForceFit, asked_for_normal_ratio: bool) -> list[str]:
        """On what the data tell, in words: also what constants at a bound, standard errors and correlations say."""
        out = []
        if self.is_law and not self.fit_exponent and not self.without_energy():
            density = fit.mean_g_cm3
            energy = self.linear[0] * (density / self.law["cutting.reference_density_g_cm3"]) ** self.exponent
            out.append("the removed bone has nearly one density: it cannot tell the exponent from u0, so p stays that of "
                       f"the run ({self.exponent:g}); what is determined is u = {energy:.5g} J/mm3 at {density:.3g} g/cm3")
        if asked_for_normal_ratio and not self.normal_matters and not self.without_energy():
            out.append(f"the measured columns do not tell k_n, which stays that of the run ({self.normal_ratio:g}); "
                       "measure the axial force and the spin torque together")
        for constant in fit.constants:
            if constant.at_bound:
                out.append(f"{constant.name} is 0: a negative value would fit better, so the model or the data are "
                           "wrong")
            elif constant.fitted and constant.standard_error > _MOST_RELATIVE_ERROR * abs(constant.value):
                out.append(f"{constant.name} is not determined by these data: its standard error exceeds half of it")
        free, covariance = fit.free, fit.covariance
        for i, j in itertools.combinations(range(len(free)), 2):
            correlation = covariance[i, j] / (covariance[i, i] * covariance[j, j]) ** 0.5
            if abs(correlation) > _HIGH_CORRELATION:
                out.append(f"{fit.constants[free[i]].name} and {fit.constants[free[j]].name} are hard to tell apart "
                           f"(correlation {correlation:.4f}): only a combination of them is well determined")
        return out if out or fit.warnings else ["all constants are determined by these data"]


def _density_spread(volume_mm3: numpy.ndarray) -> float:
    """Standard deviation of the logarithm of density, by removed volume."""
    volume, log = volume_mm3[1:], numpy.log(numpy.arange(1, GRADES))
    if not volume.sum() > 0:
        return 0
    return float(numpy.sqrt(numpy.average((log - numpy.average(log, weights=volume)) ** 2, weights=volume)))


def _residual(channel: Any, coefficients: numpy.ndarray) -> Residual:
    count = max(channel.samples, 1)
    rest = channel.residual_squares(coefficients)
    variance = channel.squares - channel.sum ** 2 / count
    return Residual(channel.column, channel.samples, float(numpy.sqrt(channel.squares / count)),
                    float(numpy.sqrt(rest / count)), 1 - rest / variance if variance > 0 else 0.0)


def _warnings(fit: ForceFit, reference_density_g_cm3: float, limits: Mapping[str, Any] | None) -> list[str]:
    """Columns that the fitted law explains worse than their mean, constants that a scenario would refuse, and specific
    energies that are far from those of bone. The density is that of u0. `limits`: ``keys``, of u0, p, k_n, K_t, K_n and u the
    scenario's ``key``, its ``min``, ``max`` and both as ``text``; ``least_energy``, the law of the least energy of bone that
    the project assumes."""
    columns = ", ".join(f"{one.column} in {'N mm' if one.column.endswith('_nmm') else 'N'}" for one in fit.residuals)
    poor = [f"{one.column}: R2 is {one.r_squared:.3g}" for one in fit.residuals if one.r_squared < _WORSE_THAN_MEAN]
    out = []
    if poor:  # one sentence: the fit follows the column with the least noise, whose unit may be the wrong one
        worse = "it worse than its mean does" if len(poor) == 1 else "them worse than their means do"
        out.append(f"{', '.join(poor)}: the fitted law explains {worse}; check sign and unit of every measured column "
                   f"({columns}), because a wrong one spoils the fit of the others, and that time_s begins with the run")
    if limits is not None:
        out += (_refused_constants(fit, limits["keys"], columns) or
                _unusual_energies(fit, reference_density_g_cm3, limits["least_energy"], columns))
    return out


def _refused_constants(fit: ForceFit, keys: Mapping[str, Any], columns: str) -> list[str]:
    out = []
    for constant in fit.constants:
        key = keys.get(constant.name, keys["u"])
        least = -math.inf if key["min"] is None else key["min"]  # JSON has no infinity
        most = math.inf if key["max"] is None else key["max"]
        if constant.fitted and not constant.at_bound and not least <= constant.value <= most:
            out.append(f"{constant.name} is {constant.value:.6g}, and {key['key']} accepts {key['text']}: a scenario would "
                       f"refuse it; check the unit of every measured column ({columns})")
    return out


def _unusual_energies(fit: ForceFit, reference_density_g_cm3: float, least: Mapping[str, float], columns: str) -> list[str]:
    energies = [(constant.name, constant.value, one.mean_g_cm3) for constant, one in zip(fit.constants, fit.classes)]
    if fit.constants[0].name == "u0":  # at the density of the bone that tells it: u0 itself may be extrapolated
        density = fit.mean_g_cm3
        relative = density / reference_density_g_cm3
        energies = [("u0", fit["u0"].value * relative ** fit["p"].value, density)] if density > 0 else []
    out = []
    for name, energy, density in energies:
        relative = min(density / least["reference_density_g_cm3"], 1)
        low = _OF_LEAST_ENERGY * least["specific_energy_j_mm3"] * relative ** least["density_exponent"]
        if energy > 0 and not low <= energy <= _MOST_ENERGY_J_MM3:
            out.append(f"{name}: the bone of {density:.3g} g/cm3 takes {energy:.3g} J/mm3, far "
                       f"{'below' if energy < low else 'above'} what is usual for bone ({low:.2g} to "
                       f"{_MOST_ENERGY_J_MM3:g} J/mm3); check the unit of every measured column ({columns})")
    return out
