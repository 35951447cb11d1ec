# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Published numbers against the runs of a study: `reamsim validate` (docs/study-files.md has the format of NAME.csv)."""

from __future__ import annotations

import csv
import dataclasses
import math
import pathlib
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy

from ..errors import InputError
from ..tables import mixed_columns, number_array

_NUMBERS = ("value", "low", "high")
_COLUMNS = ("result", *_NUMBERS, "unit")
_DEPTH = r"(-?\d+(?:\.\d+)?)"
_OF_FORCES = re.compile(rf"(mean|min|max)\((\w+); *{_DEPTH}\.\.{_DEPTH} mm\)")
AGREES, CONTRADICTS, UNKNOWN = "agrees", "contradicts", "cannot tell"


@dataclasses.dataclass(frozen=True)
class Published:
    """A row. `value`: NaN where it is missing; `low`, `high`: the interval of agreement, ±infinity at an open end."""

    line: int
    place: Mapping[str, str]  # cells by parameter, and the label
    result: str
    unit: str
    value: float
    low: float
    high: float

    def verdict(self, simulated: float) -> str:
        """Outside by more than half of the width contradicts; where one end is open, outside at all."""
        if math.isnan(simulated):
            return UNKNOWN
        outside, width = max(self.low - simulated, simulated - self.high), self.high - self.low
        return AGREES if outside <= 0 else CONTRADICTS if math.isinf(width) or outside > width / 2 else UNKNOWN


@dataclasses.dataclass(frozen=True)
class Comparison:
    """Simulated values, shape (rows, models): NaN where a result is null or a model has no run for a row."""

    title: str
    rows: list[Published]
    models: list[str]
    simulated: numpy.ndarray

    def verdicts(self, model: int) -> tuple[list[str], str]:
        """By row, and of the model: it agrees if all its values do, and contradicts if one does."""
        found = [row.verdict(value) for row, value in zip(self.rows, self.simulated[:, model])]
        return found, CONTRADICTS if CONTRADICTS in found else AGREES if set(found) == {AGREES} else UNKNOWN


def _fail(place: str, found: str, expected: str) -> InputError:
    return InputError([f"{place}: found {found}; expected {expected}"], 2)


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def read_published(path: str, parameters: Sequence[str]) -> tuple[str, list[Published]]:
    """First line of the comments, and the rows, for a study with these parameters. Raises InputError with all mistakes."""
    try:
        lines = list(enumerate(pathlib.Path(path).read_text(encoding="utf-8-sig").splitlines(), 1))
        table = [(f"{path}:{line}", [cell.strip() for cell in next(csv.reader([text]))]) for line, text in lines
                 if text.strip() and not text.startswith("#")]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise _fail(path, f"no published numbers ({error})", "a CSV in UTF-8 beside the study, with its name") from error
    title = next((text.strip("# ") for _, text in lines if text.startswith("#")), "")
    where, header = table[0] if table else (path, [])
    if not set(_COLUMNS) <= set(header) or len(set(header)) < len(header) or len(table) < 2:
        raise _fail(where, ",".join(header) or "nothing", f"a header with parameters and {', '.join(_COLUMNS)}, and rows")
    for name in sorted(set(header) - {*_COLUMNS, "label", *parameters}):
        raise _fail(f"{where}: {name}", "no such parameter", f"{', '.join(_COLUMNS)}, label or {', '.join(parameters)}")
    rows, mistakes = [], []
    for where, cells in table[1:]:
        try:
            rows.append(_row(where, header, cells))
        except InputError as error:
            mistakes += error.lines
    if mistakes:
        raise InputError(mistakes, 2)
    return title, rows


def _row(where: str, header: list[str], cells: list[str]) -> Published:
    if len(cells) != len(header):
        raise _fail(where, f"{len(cells)} cells", f"{len(header)}, one for each column")
    row = dict(zip(header, cells))
    for name in _NUMBERS:
        if row[name] and not math.isfinite(_number(row[name])):
            raise _fail(f"{where}: {name}", row[name], "a number, or an empty cell")
    value, low, high = (_number(row[name] or default) for name, default in zip(_NUMBERS, ("nan", "-inf", "inf")))
    if not low < high or value < low or value > high:
        raise _fail(f"{where}: value", f"{low:g}, {value:g}, {high:g}", "low below high, and the value between them")
    if math.isinf(high - low) and (math.isnan(value) or low == -high):
        raise _fail(f"{where}: low", "an open interval", "low and high, or the value and one of them")
    place = {name: row[name] for name in header if name not in _COLUMNS}
    return Published(int(where.rsplit(":", 1)[1]), place, row["result"], row["unit"], value, low, high)


def compare(path: str, folder: str, parameters: Sequence[str]) -> Comparison:
    """The published numbers in `path` against the collected study in `folder`. Its models are the labels of the study's table,
    else the combinations of the parameters, that `path` does not name. Raises InputError where a row has no run, a model has
    two for it, or the runs have no such result."""
    title, rows = read_published(path, parameters)
    runs = mixed_columns(pathlib.Path(folder, "runs.csv"), {"id", "message", *parameters})
    free = [name for name in parameters if name not in rows[0].place]
    free = ["label"] if "label" in free else [name for name in free if len(set(runs[name])) > 1]
    of_run = [", ".join(runs[name][i] if name == "label" else f"{name.rsplit('.', 1)[-1]} {runs[name][i].rsplit('/', 1)[-1]}"
                        for name in free) or "simulation" for i in range(len(runs["run"]))]
    models = list(dict.fromkeys(of_run))
    simulated = numpy.full((len(rows), len(models)), numpy.nan)
    for r, row in enumerate(rows):
        where = f"{path}:{row.line}"
        pairs = [(runs[name], cell) for name, cell in row.place.items() if name in parameters]
        # runs.csv has an apostrophe before a text that a spreadsheet would take for a formula.
        found = [i for i in range(len(of_run))
                 if all(values[i] in (cell, "'" + cell) or math.isclose(_number(values[i]), _number(cell), rel_tol=1e-9)
                        for values, cell in pairs)]
        if not found or len({of_run[i] for i in found}) < len(found):
            raise _fail(where, f"{len(found)} runs for this row", "one run of each model; see the parameters in its runs.csv")
        for i in found:
            value = _value(row.result, runs, i, pathlib.Path(folder, "runs", runs["id"][i], "forces.csv"), f"{where}: result")
            simulated[r, models.index(of_run[i])] = value
    return Comparison(title, rows, models, simulated)


def _value(result: str, runs: Mapping[str, numpy.ndarray], i: int, forces: pathlib.Path, where: str) -> float:
    """A result of run `i`; NaN where it is null."""
    of_forces = _OF_FORCES.fullmatch(result)
    if not of_forces:
        if result not in runs or runs[result].dtype == object:
            raise _fail(where, result, "a column of numbers in runs.csv, or mean(COLUMN; FROM..TO mm)")
        return float(runs[result][i])
    if not forces.is_file():
        raise _fail(where, "no forces.csv of the runs", "keep: [summary, forces] in the study")
    log = number_array(forces)
    statistic, column, start, end = of_forces.groups()
    depth = log["depth_mm"][:int(numpy.argmax(log["depth_mm"])) + 1]  # not of the way back
    inside = numpy.flatnonzero((depth >= float(start)) & (depth <= float(end)))
    if column not in log.dtype.names or not len(inside) or depth[-1] < float(end):
        raise _fail(where, result, f"a column of forces.csv, and depths up to {depth[-1]:.4g} mm")
    return float(getattr(numpy, statistic)(log[column][inside]))


def figure_data(found: Comparison, name: str) -> dict[str, Any]:
    """For `validation_figure.draw`: a panel for each result and the texts among the parameters, over the number that varies
    most; without one over the rows."""
    def known(values: Any) -> list[float | None]:
        return [float(value) if math.isfinite(value) else None for value in values]

    numbers = [key for key in found.rows[0].place if all(math.isfinite(_number(row.place[key])) for row in found.rows)]
    axis = max(numbers, key=lambda key: len({row.place[key] for row in found.rows}), default=None)
    panels: dict[tuple[str, ...], list[int]] = {}
    for r, row in enumerate(found.rows):
        panels.setdefault((row.result, row.unit, *(row.place[key] for key in row.place if axis and key != axis)), []).append(r)
    out = []
    for (result, unit, *others), places in panels.items():
        rows = [found.rows[r] for r in places]
        of_forces = _OF_FORCES.fullmatch(result)  # "mean(axial_force_n; ...": the unit stands in the name as well
        words = f"{of_forces[1]} {of_forces[2]}" if of_forces else " ".join(result.split(".")[-2:])
        quantity = ((words.rpartition("_")[0] or words) if unit else words).replace("_", " ")
        out.append({"title": ", ".join(others), "y": quantity + f" ({unit})" * bool(unit), "x_title": axis,
                    "x": [_number(row.place[axis]) if axis else float(i) for i, row in enumerate(rows)],
                    "names": None if axis else [", ".join(row.place.values()) for row in rows],
                    **{key: known(getattr(row, key) for row in rows) for key in _NUMBERS},
                    "models": {model: known(found.simulated[places, m]) for m, model in enumerate(found.models)}})
    return {"name": name, "title": found.title, "panels": out}
