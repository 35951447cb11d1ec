# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""What a fit says in words: constants that the data do not tell, and signs of measured columns with another sign or unit
than forces.csv, which standard errors do not show."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .fit import ForceFit

# A constant with a larger standard error is not determined: relative to its value, or of an exponent.
MOST_RELATIVE_ERROR, MOST_EXPONENT_ERROR = 0.5, 1.0
_HIGH_CORRELATION = 0.99  # constants with a higher one are hard to tell apart
_WORSE_THAN_MEAN = -0.05  # a larger R² may come from noise about a mean that the law explains well
# Specific energies beside which the unit of a column is likelier to be wrong than the bone to be unusual: this fraction
# of the least that the project assumes at a density, and several times that of the thinnest chips (docs/physics.md, 4).
_OF_LEAST_ENERGY, _MOST_ENERGY_J_MM3 = 0.1, 20.0


def statements(fit: ForceFit, first: list[str]) -> list[str]:
    """`first`, then what constants at a bound, standard errors and correlations say."""
    out = list(first)
    for constant in fit.constants:
        if constant.at_bound:
            out.append(f"{constant.name} is 0: a negative value would fit better, so the model or the data are wrong")
        elif constant.fitted and constant.standard_error > MOST_RELATIVE_ERROR * abs(constant.value):
            out.append(f"{constant.name} is not determined by these data: its standard error exceeds half of it")
    free, covariance = fit.free, fit.covariance
    for i in range(len(free)):
        for j in range(i + 1, len(free)):
            correlation = covariance[i, j] / (covariance[i, i] * covariance[j, j]) ** 0.5
            if abs(correlation) > _HIGH_CORRELATION:
                out.append(f"{fit.constants[free[i]].name} and {fit.constants[free[j]].name} are hard to tell apart "
                           f"(correlation {correlation:.4f}): only a combination of them is well determined")
    return out if out or fit.warnings else ["all constants are determined by these data"]


def warnings(fit: ForceFit, reference_density_g_cm3: float, limits: Mapping[str, Any] | None) -> list[str]:
    """Columns that the fitted law explains worse than their mean, constants that a scenario would refuse, and specific
    energies that are far from those of bone.

    Args:
        reference_density_g_cm3: of u0.
        limits: ``keys``: of u0, p, k_n, K_t, K_n and u the scenario's ``key``, its ``min``, ``max`` and both as ``text``;
            ``least_energy``: the law of the least energy of bone that the project assumes.
    """
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
    out = []
    for name, energy, density in _energies(fit, reference_density_g_cm3):
        relative = min(density / least["reference_density_g_cm3"], 1)
        low = _OF_LEAST_ENERGY * least["specific_energy_j_mm3"] * relative ** least["density_exponent"]
        if energy > 0 and not low <= energy <= _MOST_ENERGY_J_MM3:
            out.append(f"{name}: the bone of {density:.3g} g/cm3 takes {energy:.3g} J/mm3, far "
                       f"{'below' if energy < low else 'above'} what is usual for bone ({low:.2g} to "
                       f"{_MOST_ENERGY_J_MM3:g} J/mm3); check the unit of every measured column ({columns})")
    return out


def _energies(fit: ForceFit, reference_density_g_cm3: float) -> list[tuple[str, float, float]]:
    """The specific energies of a fit, each at the density of the bone that tells it: u0 itself may be extrapolated."""
    if fit.constants[0].name != "u0":
        return [(constant.name, constant.value, one.mean_g_cm3) for constant, one in zip(fit.constants, fit.classes)]
    volume = sum(one.removed_mm3 for one in fit.classes)
    if not volume > 0:
        return []
    density = sum(one.mean_g_cm3 * one.removed_mm3 for one in fit.classes) / volume
    return [("u0", fit["u0"].value * (density / reference_density_g_cm3) ** fit["p"].value, density)]
