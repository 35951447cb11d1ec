# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Main effects of a study: what a parameter alone changes of a result (docs/study-files.md); effects.csv, what their figure
shows, and the table of a study on the terminal."""

from __future__ import annotations

import contextlib
import dataclasses
import math
import os
from collections.abc import Sequence
from typing import Any

import numpy

from .tables import aligned, write_csv

MOST_NUMERIC_LEVELS = 8  # more values of a number are grouped by intervals
MOST_LEVELS = 40  # more levels of a text do not fit an axis
MOST_INTERVALS, LEAST_VALUES_OF_INTERVAL = 8, 8
MOST_PARAMETERS, MOST_RESULTS = 6, 8  # of one figure
_MOST_DOTS = 300  # single runs in a panel; more would hide the means
# A result whose values differ by less than this fraction of them does not vary: it is rounding. Nor does an angle that
# differs by less than this, °: the fits of faces have errors of some hundredths.
LEAST_VARIATION, LEAST_VARIATION_DEG = 1e-9, 0.1
_MOST_RUNS_IN_ROWS = 20
_MOST_ROWS = 24  # of levels, so that the table fits a screen
_MOST_CELL = 24  # characters of a parameter
Row = list[str]


@dataclasses.dataclass(frozen=True)
class Column:
    """A column of a study by run."""

    key: str  # of runs.csv
    title: str  # what people read, with the unit
    cells: Sequence[str] = ()  # texts of a parameter
    shown: Sequence[str] = ()  # as tables and figures show them
    numbers: numpy.ndarray | None = None  # of a result (NaN: missing), or of a parameter all of whose cells are numbers
    unit: str = ""  # of a result

    def of(self, runs: Sequence[int]) -> Column:
        """The same of some runs."""
        def some(values: Sequence[str]) -> list[str]:
            return [values[run] for run in runs] if len(values) else []

        return dataclasses.replace(self, cells=some(self.cells), shown=some(self.shown),
                                   numbers=None if self.numbers is None else self.numbers[list(runs)])


@dataclasses.dataclass
class Parameter:
    """A parameter that varies. `levels`: names of the groups, empty for intervals. `x`: by run, the value of a number,
    otherwise the number of the level from 1. `group`: by run. `also`: keys that vary together with it."""

    column: Column
    numeric: bool
    levels: list[str]
    x: numpy.ndarray
    group: numpy.ndarray
    also: list[str] = dataclasses.field(default_factory=list)


@dataclasses.dataclass(frozen=True)
class Group:
    """The runs with one level, or with values in one interval. `x`: mean of the parameter; `sd`: standard deviation of
    the result over all else that varies, 0 for one run."""

    level: int
    x: float
    least: float
    most: float
    runs: int
    mean: float
    sd: float


@dataclasses.dataclass(frozen=True)
class Effect:
    """What a parameter alone changes of a result. `explained`: fraction of the variance that the means of the groups
    explain (the correlation ratio); of intervals corrected for what random groups would explain (Kelley 1935)."""

    groups: list[Group]
    explained: float


@dataclasses.dataclass
class MainEffects:
    """`effects[parameter][result]`. Parameters descend by the mean of the fractions that they explain."""

    parameters: list[Parameter]
    results: list[Column]
    effects: list[list[Effect]]

    def __bool__(self) -> bool:
        return bool(self.parameters and self.results)


def main_effects(parameters: Sequence[Column], results: Sequence[Column]) -> MainEffects:
    """The effects of all parameters with two or more values.

    A number with more than eight values is grouped by intervals with equally many of them. Texts with more than forty
    values, and texts that differ in every run, are no parameters; nor is a vector whose tilts or shifts are. Of parameters
    that group the runs in the same way, the first stands for all.
    """
    varied: list[Parameter] = []
    keys = [column.key for column in parameters]
    for column in parameters:
        has_parts = any(key.startswith((f"{column.key}.tilt_", f"{column.key}.shift_")) for key in keys)
        parameter = None if has_parts else _grouped(column)
        if parameter is None:
            continue
        same = next((other for other in varied if _group_alike(other, parameter)), None)
        if same is None:
            varied.append(parameter)
        else:
            same.also.append(column.key)
    of_results = [column for column in results if _varies(column)]
    pairs = [(parameter, [_effect(parameter, column.numbers) for column in of_results]) for parameter in varied]
    pairs.sort(key=lambda pair: -sum(effect.explained for effect in pair[1]))
    return MainEffects([pair[0] for pair in pairs], of_results, [pair[1] for pair in pairs])


def _grouped(column: Column) -> Parameter | None:
    if column.numbers is not None:
        values, first, group = numpy.unique(column.numbers, return_index=True, return_inverse=True)
        if len(values) < 2:
            return None
        if len(values) <= MOST_NUMERIC_LEVELS:
            return Parameter(column, True, [column.shown[run] for run in first], column.numbers, group)
        intervals = min(max(len(values) // LEAST_VALUES_OF_INTERVAL, 2), MOST_INTERVALS)
        return Parameter(column, True, [], column.numbers, group * intervals // len(values))
    places = {cell: place for place, cell in enumerate(dict.fromkeys(column.cells))}  # in the order of the plan
    differs_in_every_run = len(places) == len(column.cells) > 2
    if not 2 <= len(places) <= MOST_LEVELS or differs_in_every_run:
        return None
    group = numpy.array([places[cell] for cell in column.cells])
    levels = _shortened([column.shown[column.cells.index(cell)] for cell in places])
    return Parameter(column, False, levels, group + 1.0, group)


def _shortened(levels: list[str]) -> list[str]:
    """Without what all begin with, up to the last separator in it: "reamer_flat" is "flat"."""
    same = len(os.path.commonprefix(levels))
    begin = 1 + max(levels[0].rfind(separator, 0, same) for separator in "_- ")
    return levels if any(len(level) == begin for level in levels) else [level[begin:] for level in levels]


def _group_alike(a: Parameter, b: Parameter) -> bool:
    """Whether both group the runs in the same way, whatever the numbers of the groups."""
    if not a.levels or len(a.levels) != len(b.levels):
        return False
    return len(set(zip(a.group.tolist(), b.group.tolist()))) == len(a.levels)


def _varies(column: Column) -> bool:
    values = column.numbers[~numpy.isnan(column.numbers)]
    if not len(values):
        return False
    least = LEAST_VARIATION_DEG if column.unit == "°" else LEAST_VARIATION * max(abs(values.max()), abs(values.min()))
    return bool(values.max() - values.min() > least)


def _effect(parameter: Parameter, y: numpy.ndarray) -> Effect:
    known = ~numpy.isnan(y)
    x, group, y = parameter.x[known], parameter.group[known], y[known]
    groups, within = [], 0.0
    for level in numpy.unique(group):
        chosen = group == level
        of_x, of_y = x[chosen], y[chosen]
        squares = float(((of_y - of_y.mean()) ** 2).sum())
        within += squares
        sd = (squares / (len(of_y) - 1)) ** 0.5 if len(of_y) > 1 else 0.0
        groups.append(Group(int(level), float(of_x.mean()), float(of_x.min()), float(of_x.max()), len(of_y),
                            float(of_y.mean()), sd))
    total = float(((y - y.mean()) ** 2).sum())
    if not total > 0:
        return Effect(groups, 0.0)
    correction = (len(y) - 1) / (len(y) - len(groups)) if not parameter.levels and len(y) > len(groups) else 1
    return Effect(groups, min(max(1 - within / total * correction, 0.0), 1.0))


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
                   "range": [float(one.x.min()), float(one.x.max())],
                   "spread": float(numpy.diff(numpy.unique(one.x)).min()),  # least distance of levels
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


def study_table(names: Sequence[str], all_runs: int, parameters: Sequence[Column], results: Sequence[Column],
                effects: MainEffects, done: int, width: int) -> list[str]:
    """The lines of up to twenty runs, of more those of the levels; none wider than `width`. Empty where no run is done.

    Args:
        names, parameters, results: number and state of each run, and its columns.
        all_runs, done: how many the study has, and how many are done.
        effects: of the runs that are done.
    """
    if not done:
        return []
    if all_runs <= _MOST_RUNS_IN_ROWS:
        return _widest(_rows_of_runs(names, parameters, results), 1, width)
    if not effects:
        return []
    counts = numpy.cumsum([len(of_parameter[0].groups) for of_parameter in effects.effects])
    shown = max(1, int((counts <= _MOST_ROWS).sum()))
    lines = _widest(_means_rows(effects, shown, done), 4, width)
    if left_out := len(effects.parameters) - shown:
        lines.append(f"{left_out} more parameters explain less")
    return lines + ["", *_band_lines(effects)] if any(not one.levels for one in effects.parameters) else lines


def _widest(rows: Sequence[Row], least: int, width: int) -> list[str]:
    """The lines of a table with as many of its columns as fit, but at least so many."""
    for count in range(len(rows[0]), least, -1):
        lines = aligned([row[:count] for row in rows])
        if all(len(line) <= width for line in lines):
            return lines
    return aligned([row[:least] for row in rows])


def _rows_of_runs(names: Sequence[str], parameters: Sequence[Column], results: Sequence[Column]) -> list[Row]:
    columns = [_titled(one, [_short(shown, cell) for shown, cell in zip(one.shown, one.cells)]) for one in parameters
               if len(set(one.cells)) > 1]
    cells = [["-" if math.isnan(value) else f"{value:.4g}" for value in one.numbers] for one in results]
    varied = [i for i, of_result in enumerate(cells) if len(set(of_result)) > 1] or range(len(results))
    columns += [_titled(results[i], cells[i]) for i in varied]
    return [list(row) for row in zip(["run", "", *names], *columns)]


def _means_rows(effects: MainEffects, parameters: int, done: int) -> list[Row]:
    """Means and standard deviations of the results by level of the first parameters."""
    rows = [["mean ± SD", "", ""], ["", "", "runs"], ["all", "", str(done)]]
    for result in effects.results:
        for row, cell in zip(rows, [*two_lines(result.title), _mean_text(_all_of(result))]):
            row.append(cell)
    for parameter, of_parameter in zip(effects.parameters[:parameters], effects.effects):
        groups = of_parameter[0].groups
        for g, group in enumerate(groups):
            level = parameter.levels[group.level] if parameter.levels else f"{group.least:.3g} to {group.most:.3g}"
            row = [parameter.column.title[:28] if g == 0 else "", level[:20], str(group.runs)]
            rows.append(row + [_mean_text(effect.groups[g]) if len(effect.groups) == len(groups) else "-"
                               for effect in of_parameter])
    return rows


def _band_lines(effects: MainEffects) -> list[str]:
    """Of distributions, what the means do not say: quantiles of each result over all runs, and the parameter that explains
    most of it."""
    rows = [["over all runs", "5 %", "50 %", "95 %", "explained most by"]]
    for r, result in enumerate(effects.results):
        values, whole = result.numbers[~numpy.isnan(result.numbers)], _all_of(result)
        quantiles = [_mean_text(whole, float(numpy.quantile(values, part))).split(" ")[0] for part in (0.05, 0.5, 0.95)]
        most = max(range(len(effects.parameters)), key=lambda p: effects.effects[p][r].explained)
        explained = 100 * effects.effects[most][r].explained
        rows.append([result.title[:34], *quantiles, f"{effects.parameters[most].column.title[:28]} ({explained:.0f} %)"])
    return aligned(rows)


def _all_of(result: Column) -> Group:
    values = result.numbers[~numpy.isnan(result.numbers)]
    sd = float(values.std(ddof=1)) if len(values) > 1 else 0.0
    return Group(0, 0, 0, 0, len(values), float(values.mean()), sd)


def _mean_text(group: Group, value: float | None = None) -> str:
    """47.1 ± 3.2: the deviation with two digits, the mean (or another value) with as many decimals."""
    value = group.mean if value is None else value
    if group.runs == 1:
        return f"{value:.4g}"
    decimals = min(max(1 - math.floor(math.log10(group.sd)), 0), 6) if group.sd > 0 else 2
    return f"{value:.{decimals}f} ± {group.sd:.{decimals}f}"


def _titled(column: Column, cells: Row) -> Row:
    return [*two_lines(column.title[:32]), *cells]


def _short(shown: str, cell: str) -> str:
    """Numbers of a list with four digits, and "…" where the rest does not fit: [-41.2, 9.2, 36.6]."""
    if cell.startswith("[") and cell.endswith("]"):
        with contextlib.suppress(ValueError):
            shown = f"[{', '.join(f'{float(part):.4g}' for part in cell[1:-1].split(','))}]"
    return shown if len(shown) <= _MOST_CELL else shown[:_MOST_CELL - 1] + "…"


def two_lines(title: str) -> tuple[str, str]:
    """A title on two lines of about the same length in bytes; the first is empty where it is one word."""
    text = title.encode()
    spaces = [at for at, letter in enumerate(text) if letter == ord(" ")]
    if not spaces:
        return "", title
    best = min(spaces, key=lambda at: abs(at - len(text) / 2))
    return text[:best].decode(), text[best + 1:].decode()
