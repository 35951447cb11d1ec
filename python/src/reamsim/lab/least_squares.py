# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Least squares of a fit: measured values against the parts of a force basis.

Columns are P of each unit (grades that share a specific energy), N of each, and the edge's Q_t and Q_n: what is measured
is their sum with the coefficients u, k_n·u, K_t and K_n.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy
import scipy.optimize
import scipy.sparse

from ..errors import InputError
from .force_model import GRADES, ForceBasis

_SAME_TIME_S = 1e-9  # a measured time that is nearer to a frame's is taken as that frame's
_BLOCK = 4096  # rows of a dense matrix at a time


def nonnegative(matrix: numpy.ndarray, values: numpy.ndarray) -> numpy.ndarray:
    """The x ≥ 0 that minimizes |matrix·x − values| (Lawson and Hanson 1974), shape (columns,); 0 of a column of zeros."""
    size = numpy.sqrt((matrix ** 2).sum(axis=0))  # columns of length 1, so that one tolerance holds for all
    scale = numpy.divide(1, size, out=numpy.zeros_like(size), where=size > 0)
    return scale * scipy.optimize.nnls(matrix * scale, values)[0]


def minimum(slope: Callable[[float], tuple[float, float]], low: float, high: float, scan: int) -> float:
    """The place of the least value between `low` and `high`: the best of a scan, refined at the root of the slope. `slope`
    gives value and slope. An end is approached to 10⁻⁹ of the range and not reached: the standard error then says what a
    bound would hide."""
    places = numpy.linspace(low, high, scan + 1)
    best = int(numpy.argmin([slope(place)[0] for place in places]))
    falls = slope(places[best])[1] < 0
    found, other = places[best], places[min(best + 1, scan) if falls else max(best - 1, 0)]
    if (slope(other)[1] < 0) != falls:
        found = scipy.optimize.brentq(lambda place: slope(place)[1], found, other, xtol=1e-14, rtol=1e-14)
    margin = 0.5e-9 * (high - low)
    return float(min(max(found, low + margin), high - margin))


def frame_weights(frame_s: numpy.ndarray, time_s: numpy.ndarray) -> scipy.sparse.csr_matrix:
    """Linear interpolation from frames (ascending) to other times, shape (times, frames); rows of zeros before the first
    and after the last frame."""
    after = numpy.searchsorted(frame_s, time_s - _SAME_TIME_S)
    known = (after < len(frame_s)) & ((after > 0) | (frame_s[0] <= time_s + _SAME_TIME_S))
    after = numpy.where(known, after, 0)
    before = numpy.maximum(after - 1, 0)
    between = known & (frame_s[after] > time_s + _SAME_TIME_S)
    step = numpy.where(between, frame_s[after] - frame_s[before], 1)
    part = numpy.where(between, (time_s - frame_s[before]) / step, 1)
    row = numpy.arange(len(time_s))
    weights = numpy.concatenate([part * known, (1 - part) * known])
    return scipy.sparse.csr_matrix((weights, (numpy.tile(row, 2), numpy.concatenate([after, before]))),
                                   (len(time_s), len(frame_s)))


class Channel:
    """A measured column with its samples, those in contact. Its rows are compressed to the triangular `factor` of
    [parts | values], of at most columns + 1 rows, from which follow the squares of all residuals."""

    def __init__(self, column: str, parts: scipy.sparse.csr_matrix, values: numpy.ndarray) -> None:
        known = ~numpy.isnan(values)
        parts, values = parts[known], values[known]
        self.column, self.samples = column, len(values)
        self.sum, self.squares = float(values.sum()), float((values ** 2).sum())
        self.factor = numpy.zeros((0, parts.shape[1] + 1))
        for first in range(0, self.samples, _BLOCK):
            block = numpy.column_stack([parts[first:first + _BLOCK].toarray(), values[first:first + _BLOCK]])
            self.factor = numpy.linalg.qr(numpy.concatenate([self.factor, block]), mode="r")

    def residual_squares(self, coefficients: numpy.ndarray) -> float:
        """Σ (measured − fitted)²."""
        return float(((self.factor @ numpy.append(coefficients, -1.0)) ** 2).sum())


class Problem:
    """The weighted problem of all channels: `rows` are their weighted factors, whose last column are the measured values."""

    def __init__(self, basis: ForceBasis, time_s: numpy.ndarray, measured: dict[str, numpy.ndarray],
                 units: list[list[int]]) -> None:
        """`measured`: values by column of forces.csv (`CHANNELS`), NaN where nothing was measured. Raises InputError
        where no measured time lies in the run's contact."""
        self.units, self.has_edge = len(units), basis.has_edge
        of_unit = scipy.sparse.csr_matrix(([1.0] * sum(map(len, units)),
                                           ([grade for unit in units for grade in unit],
                                            [i for i, unit in enumerate(units) for _ in unit])), (GRADES, self.units))
        weights = frame_weights(basis.time_s, time_s)
        parts = {}
        for column in measured:
            p, n = (weights @ part for part in basis.parts(column))
            edge = [p[:, 0], n[:, 0]] if self.has_edge else []
            parts[column] = scipy.sparse.hstack([p @ of_unit, n @ of_unit, *edge], format="csr")
        contact = numpy.any([numpy.asarray(abs(part).sum(axis=1)).ravel() != 0 for part in parts.values()], axis=0)
        self.columns = 2 * self.units + 2 * self.has_edge
        self.channels = [Channel(column, parts[column][contact], values[contact]) for column, values in measured.items()]
        if self.samples == 0:
            raise InputError(["no measured time lies in the time of contact of the run; shift time_s so that it begins "
                              "with the run"], 2)
        self.weigh()

    @property
    def samples(self) -> int:
        """Number of values that count."""
        return sum(channel.samples for channel in self.channels)

    def weigh(self, coefficients: numpy.ndarray | None = None, floor: float = 0) -> None:
        """Weighs each channel by the variance of its residuals with these coefficients; None: of its values. `floor`: least
        standard deviation relative to the root mean square."""
        rows = [numpy.zeros((1, self.columns + 1))]  # never none
        for channel in self.channels:
            rest = channel.squares if coefficients is None else channel.residual_squares(coefficients)
            rest = max(rest, floor ** 2 * channel.squares)
            if rest > 0:  # samples, and not zeros only
                rows.append(numpy.sqrt(channel.samples / rest) * channel.factor)
        self.rows = numpy.concatenate(rows)

    def squares(self, coefficients: numpy.ndarray) -> float:
        """Σ weights·(measured − fitted)²."""
        return float(((self.rows @ numpy.append(coefficients, -1.0)) ** 2).sum())
