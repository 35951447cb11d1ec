# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""The table of a study on the terminal: of up to twenty runs a row for each, of more the means and standard deviations of
the results by level of the parameters that explain most."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy

from .effects import Column, Group, MainEffects, Parameter
from .tables import aligned

_MOST_RUNS_IN_ROWS = 20
_MOST_ROWS = 24  # of levels, so that the table fits a screen
_MOST_CELL = 24  # characters of a parameter
Row = list[str]


def rows_of_runs(names: Sequence[str], parameters: Sequence[Column], results: Sequence[Column], width: int) -> list[str]:
    """A row per run, with as many columns as fit. `names`: number and state of each run."""
    columns = [_titled(one, [_short(shown, cell) for shown, cell in zip(one.shown, one.cells)]) for one in parameters
               if len(set(one.cells)) > 1]
    cells = [["-" if math.isnan(value) else f"{value:.4g}" for value in one.numbers] for one in results]
    varied = [i for i, of_result in enumerate(cells) if len(set(of_result)) > 1] or range(len(results))
    columns += [_titled(results[i], cells[i]) for i in varied]
    rows = [["run"], [""], *([name] for name in names)]
    for column in columns:
        more = [[*row, cell] for row, cell in zip(rows, column)]
        if _is_wider(aligned(more), width):
            break
        rows = more
    return aligned(rows)


def study_table(names: Sequence[str], all_runs: int, parameters: Sequence[Column], results: Sequence[Column],
                effects: MainEffects, done: int, width: int) -> list[str]:
    """The lines, none wider than `width`. Empty where no run is done.

    Args:
        names, parameters, results: of all runs.
        all_runs: how many the study has.
        effects: of the runs that are done.
        done: how many these are.
    """
    if not done:
        return []
    if all_runs <= _MOST_RUNS_IN_ROWS:
        return rows_of_runs(names, parameters, results, width)
    if not effects:
        return []
    lines = _means_lines(effects, done, width)
    return lines + ["", *_band_lines(effects)] if any(not one.levels for one in effects.parameters) else lines


def _means_lines(effects: MainEffects, done: int, width: int) -> list[str]:
    counts = numpy.cumsum([len(of_parameter[0].groups) for of_parameter in effects.effects])
    shown = max(1, int((counts <= _MOST_ROWS).sum()))
    lines: list[str] = []
    for results in range(1, len(effects.results) + 1):
        more = aligned(_means_rows(effects, shown, results, done))
        if lines and _is_wider(more, width):
            break
        lines = more
    left_out = len(effects.parameters) - shown
    return lines + [f"{left_out} more parameters explain less"] if left_out else lines


def _means_rows(effects: MainEffects, parameters: int, results: int, done: int) -> list[Row]:
    rows = [["mean ± SD", "", ""], ["", "", "runs"], ["all", "", str(done)]]
    for result in effects.results[:results]:
        for row, cell in zip(rows, [*two_lines(result.title), _mean_text(_all_of(result))]):
            row.append(cell)
    for parameter, of_parameter in zip(effects.parameters[:parameters], effects.effects):
        groups = of_parameter[0].groups
        for g, group in enumerate(groups):
            row = [parameter.column.title[:28] if g == 0 else "", _range_or_level(parameter, group)[:20], str(group.runs)]
            for effect in of_parameter[:results]:
                row.append(_mean_text(effect.groups[g]) if len(effect.groups) == len(groups) else "-")
            rows.append(row)
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


def _range_or_level(parameter: Parameter, group: Group) -> str:
    return parameter.levels[group.level] if parameter.levels else f"{group.least:.3g} to {group.most:.3g}"


def _titled(column: Column, cells: Row) -> Row:
    return [*two_lines(column.title[:32]), *cells]


def _short(shown: str, cell: str) -> str:
    """Numbers of a list with four digits, and "…" where the rest does not fit: [-41.2, 9.2, 36.6]."""
    if cell.startswith("[") and cell.endswith("]"):
        try:
            shown = f"[{', '.join(f'{float(part):.4g}' for part in cell[1:-1].split(','))}]"
        except ValueError:
            pass
    return shown if len(shown) <= _MOST_CELL else shown[:_MOST_CELL - 1] + "…"


def two_lines(title: str) -> tuple[str, str]:
    """A title on two lines of about the same length in bytes; the first is empty where it is one word."""
    text = title.encode()
    spaces = [at for at, letter in enumerate(text) if letter == ord(" ")]
    if not spaces:
        return "", title
    best = min(spaces, key=lambda at: abs(at - len(text) / 2))
    return text[:best].decode(), text[best + 1:].decode()


def _is_wider(lines: Sequence[str], width: int) -> bool:
    return any(len(line) > width for line in lines)
