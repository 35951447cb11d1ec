# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""effects.csv, and what the figure of main effects shows."""

from __future__ import annotations

from typing import Any

import numpy

from .effects import MainEffects, Parameter
from .tables import write_csv

MOST_PARAMETERS, MOST_RESULTS = 6, 8  # of one figure
_MOST_DOTS = 300  # single runs in a panel; more would hide the means


def write_table(folder: str, effects: MainEffects) -> None:
    """FOLDER/effects.csv: a row for each group of runs of each parameter and result."""
    rows: list[list[float | str]] = []
    for parameter, of_parameter in zip(effects.parameters, effects.effects):
        for result, effect in zip(effects.results, of_parameter):
            for group in effect.groups:
                level = parameter.levels[group.level] if parameter.levels else ""
                limits = [group.least, group.most] if parameter.numeric else ["", ""]
                rows.append([parameter.column.key, result.key, level, *limits, group.runs, group.mean, group.sd,
                             effect.explained])
    write_csv(f"{folder}/effects.csv", ["parameter", "result", "level", "from", "to", "runs", "mean", "sd", "explained"], rows)


def figure_data(effects: MainEffects) -> dict[str, Any]:
    """For `effects_figure.draw`: the parameters that explain most, the first results, and at most 300 single runs."""
    count = len(effects.parameters[0].x)
    # Drawn at random, the same on every machine: every second run would be one level of the fastest parameter.
    dots = numpy.sort(numpy.random.RandomState(1).permutation(count)[:_MOST_DOTS])
    parameters = [{"title": one.column.title, "numeric": one.numeric, "levels": one.levels, "x": one.x[dots].tolist(),
                   "range": [float(one.x.min()), float(one.x.max())], "spread": _least_step(one),
                   "groups": [[[group.x, group.mean, group.sd, group.level] for group in effect.groups]
                              for effect in of_parameter[:MOST_RESULTS]],
                   "explained": [effect.explained for effect in of_parameter[:MOST_RESULTS]]}
                  for one, of_parameter in list(zip(effects.parameters, effects.effects))[:MOST_PARAMETERS]]
    results = []
    for r, result in enumerate(effects.results[:MOST_RESULTS]):
        bars = [value for one in parameters for _, mean, sd, _ in one["groups"][r] for value in (mean - sd, mean + sd)]
        values = numpy.append(result.numbers, bars)
        results.append({"title": result.title, "range": [float(numpy.nanmin(values)), float(numpy.nanmax(values))],
                        "y": [None if numpy.isnan(y) else float(y) for y in result.numbers[dots]]})
    return {"parameters": parameters, "results": results}


def _least_step(parameter: Parameter) -> float:
    """Least distance of levels."""
    return float(numpy.diff(numpy.unique(parameter.x)).min())
