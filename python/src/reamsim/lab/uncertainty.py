# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Bands of force and torque, and sensitivity indices, of a sample of uncertain inputs.

The points are two independent samples A and B of the inputs, and for each input A with its column of B. Inputs that are
constants of the force law need no run of their own: forces for them follow from the force basis of a run.
"""

from __future__ import annotations

import dataclasses
import pathlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy
import scipy.sparse

from ..tables import number_array
from .force_model import Coefficients, ForceBasis, tool_axis
from .sensitivity import SobolIndices, sobol_indices

_MOST_INTERVALS = 400
_TAIL = 0.2  # fraction of the values of an input whose mean outputs are compared
_POINTS_AT_ONCE = 256  # of one run, which bounds the memory
FORCE_OUTPUTS = ("peak_axial_force_n", "peak_spin_torque_nmm", "energy_mj")


@dataclasses.dataclass(frozen=True)
class Design:
    """What is uncertain, and where it is evaluated: n·(inputs + 2) points, the rows of A, those of B, and for each input
    those of A with its column of B."""

    inputs: Sequence[str]  # names
    unit: numpy.ndarray  # samples A, then B, in the unit cube, shape (2n, inputs)
    runs: Sequence[pathlib.Path]  # results folders
    run_of: numpy.ndarray  # run of each point, shape (points,)
    constants: Sequence[str]  # keys of the force law among the inputs
    values: numpy.ndarray  # of these constants, shape (points, constants)
    laws: Sequence[Mapping[str, Any]]  # with constants: by run the ``law`` without them, and that ``of_run``
    numbers: Sequence[Mapping[str, float]]  # by run other results, which do not depend on the force law


@dataclasses.dataclass(frozen=True)
class Uncertainty:
    """The results."""

    outputs: list[str]  # names: `FORCE_OUTPUTS`, then the numbers that differ between the runs
    samples: numpy.ndarray  # outputs of A, then B, shape (2n, outputs)
    indices: SobolIndices  # shape (inputs, outputs)
    low: numpy.ndarray  # means of the outputs where an input is in its lowest fifth, shape (inputs, outputs)
    high: numpy.ndarray  # the same of its highest fifth
    time_s: numpy.ndarray  # ends of the intervals, shape (intervals,)
    axial_force_n: numpy.ndarray  # means over the intervals of A, then B, shape (intervals, 2n)
    spin_torque_nmm: numpy.ndarray


def evaluate(design: Design) -> Uncertainty:
    """Evaluates all points. Raises InputError or ResultsError where a run has no force basis where it is needed, or a
    file is damaged."""
    independent = len(design.unit)
    first, others = design.numbers[0], design.numbers[1:]
    in_all = [name for name in first if all(name in other for other in others)]
    names = [name for name in in_all if any(other[name] != first[name] for other in others)]
    logs = [number_array(folder / "forces.csv") for folder in design.runs]
    time_s = _intervals([log["time_s"] for log in logs])
    points = numpy.zeros((len(design.run_of), len(FORCE_OUTPUTS) + len(names)))
    bands = numpy.zeros((2, len(time_s), independent))
    for run, log in enumerate(logs):
        points[design.run_of == run, len(FORCE_OUTPUTS):] = [design.numbers[run][name] for name in names]
        mean = _interval_means(log["time_s"], time_s)
        for at, axial, torque, energy in _histories(design, run, log):
            points[at, 0] = numpy.maximum(axial.max(axis=0, initial=0), 0)
            points[at, 1] = numpy.abs(torque).max(axis=0, initial=0)
            points[at, 2] = energy.sum(axis=0)
            band = at < independent
            bands[:, :, at[band]] = mean(axial[:, band]), mean(torque[:, band])
    n = independent // 2
    mixed = points[independent:].reshape(len(design.inputs), n, -1)
    low, high = _tails(design.unit, points[:independent])
    return Uncertainty([*FORCE_OUTPUTS, *names], points[:independent],
                       sobol_indices(points[:n], points[n:independent], mixed), low, high, time_s, *bands)


def _intervals(times: Sequence[numpy.ndarray]) -> numpy.ndarray:
    """Ends of equal intervals of time, from 0 to the end of the longest run; none is shorter than a frame of that run."""
    longest = max((one for one in times if len(one)), key=lambda one: one[-1], default=numpy.zeros(1))
    count = min(max(len(longest) - 1, 1), _MOST_INTERVALS)
    return (longest[-1] / count if longest[-1] > 0 else 1.0) * numpy.arange(1, count + 1)


def _histories(design: Design, run: int, log: numpy.ndarray) -> Any:
    """Of the points of a run, some at a time: their places; axial force, spin torque and energy, shape (frames, points)."""
    places = numpy.flatnonzero(design.run_of == run)
    if not design.constants:
        columns = (log[name][:, None] for name in ("axial_force_n", "spin_torque_nmm", "energy_mj"))
        yield (places, *(numpy.broadcast_to(column, (len(log), len(places))) for column in columns))
        return
    rows = numpy.load(design.runs[run] / "force_basis.npy")
    basis = ForceBasis(rows, log["frame"], log["time_s"], tool_axis(log))
    for first in range(0, len(places), _POINTS_AT_ONCE):
        at = places[first:first + _POINTS_AT_ONCE]
        laws = [{**design.laws[run]["law"], **dict(zip(design.constants, values))} for values in design.values[at]]
        coefficients = Coefficients.of_laws(laws, design.laws[run]["of_run"])
        yield (at, basis.values("axial_force_n", coefficients), basis.values("spin_torque_nmm", coefficients),
               basis.energy_mj(coefficients))


def _interval_means(frame_s: numpy.ndarray, ends_s: numpy.ndarray) -> Callable[[numpy.ndarray], numpy.ndarray]:
    """Means over intervals of time of values by frame, shape (frames, points): shape (intervals, points). An interval
    without a frame has that of the one before, up to the end of the run."""
    place = numpy.ceil(frame_s / ends_s[0] - 1e-6).astype(int) - 1
    place = numpy.clip(place, 0, len(ends_s) - 1)
    counts = numpy.bincount(place, minlength=len(ends_s))
    sums = scipy.sparse.csr_matrix((numpy.ones(len(place)), (place, numpy.arange(len(place)))), (len(ends_s), len(place)))
    last = place[-1] if len(place) else -1
    source = numpy.maximum.accumulate(numpy.where(counts > 0, numpy.arange(len(ends_s)), 0))
    source[last + 1:] = numpy.arange(last + 1, len(ends_s))
    return lambda values: (sums @ values / numpy.maximum(counts, 1)[:, None])[source]


def _tails(unit: numpy.ndarray, samples: numpy.ndarray) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Means of the outputs in the lowest and highest fifth of each input, shape (inputs, outputs); NaN without samples."""
    def means(chosen: numpy.ndarray) -> numpy.ndarray:
        counts = chosen.sum(axis=0)[:, None]
        sums = numpy.stack([samples[of_input].sum(axis=0) for of_input in chosen.T])
        return numpy.divide(sums, counts, out=numpy.full(sums.shape, numpy.nan), where=counts > 0)

    return means(unit < _TAIL), means(unit > 1 - _TAIL)
