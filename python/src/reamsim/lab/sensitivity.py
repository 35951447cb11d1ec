# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Sobol indices: fractions of the variance of an output (Sobol 2001)."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence

import numpy

_QUANTILE = 1.96  # 97.5 % of a normal distribution
_MATTERS = 0.1  # total index of an input that a sentence names


@dataclasses.dataclass(frozen=True)
class SobolIndices:
    """Indices, shape (inputs, outputs).

    The first-order index of an input is what it explains alone, its total index what remains unexplained without it. Both
    are 0 where the output does not vary. They are estimates: that of an input that explains nearly all may exceed 1, and
    the first order may exceed the total. Errors are half the widths of 95 % intervals, as of independent samples; those of a
    Sobol sequence scatter less.
    """

    first: numpy.ndarray
    total: numpy.ndarray
    first_error: numpy.ndarray
    total_error: numpy.ndarray
    variance: numpy.ndarray  # of the outputs, shape (outputs,)


def sobol_indices(of_a: numpy.ndarray, of_b: numpy.ndarray, of_mixed: numpy.ndarray) -> SobolIndices:
    """The indices from the outputs of two independent samples A and B of the inputs, as two halves of one Sobol sequence
    of twice the inputs give them. First order after Saltelli et al. (2010), eq. b of their Table 2; total after Jansen
    (1999), eq. f.

    Args:
        of_a, of_b: outputs, shape (samples, outputs).
        of_mixed: outputs of A with the column of one input from B, shape (inputs, samples, outputs).

    Raises ValueError where the shapes do not fit, or there are less than two samples.
    """
    count = len(of_a)
    if of_a.shape != of_b.shape or of_mixed.shape[1:] != of_a.shape or count < 2:
        raise ValueError("sobol_indices: two samples of the same size are needed")
    # About the mean, because the estimators subtract large numbers otherwise.
    mean = 0.5 * (of_a.mean(axis=0) + of_b.mean(axis=0))
    a, b, mixed = of_a - mean, of_b - mean, of_mixed - mean
    variance = ((a ** 2).sum(axis=0) + (b ** 2).sum(axis=0)) / (2 * count - 1)
    alone, rest = b * (mixed - a), 0.5 * (a - mixed) ** 2
    squares = numpy.broadcast_to(0.5 * (a ** 2 + b ** 2), mixed.shape)
    varies = numpy.broadcast_to(variance > 0, mixed.shape[::2])

    def ratio(above: numpy.ndarray, below: numpy.ndarray) -> numpy.ndarray:
        return numpy.divide(above, below, out=numpy.zeros(varies.shape), where=varies)

    def error(above: numpy.ndarray) -> numpy.ndarray:
        """Half the width of the 95 % interval of mean(above)/mean(squares), by the delta method."""
        below = squares.mean(axis=1)
        deviation = above - ratio(above.mean(axis=1), below)[:, None] * squares
        return ratio(_QUANTILE * numpy.sqrt((deviation ** 2).sum(axis=1) / (count * (count - 1))), below)

    return SobolIndices(ratio(alone.mean(axis=1), variance), ratio(rest.mean(axis=1), variance), error(alone), error(rest),
                        variance)


def dominant_inputs(indices: SobolIndices, output: int, names: Sequence[str]) -> str:
    """Says in a sentence which inputs dominate an output. `names`: of the inputs."""
    if not indices.variance[output] > 0:
        return "the output does not vary"
    first, total, first_error, total_error = (100 * values[:, output] for values in (
        indices.first, indices.total, indices.first_error, indices.total_error))
    order = sorted(range(len(names)), key=lambda i: -total[i])
    parts = [f"{names[i]} ({first[i]:.0f} ± {first_error[i]:.0f} % of the variance alone, {total[i]:.0f} ± "
             f"{total_error[i]:.0f} % in total)" for i in order]
    others = [part for i, part in zip(order[1:], parts[1:]) if total[i] >= 100 * _MATTERS]
    return f"{parts[0]} dominates" + (f", followed by {', '.join(others)}" if others else "")
