# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Tables: CSV files as pandas DataFrames, or as numpy record arrays without pandas."""

from __future__ import annotations

import contextlib
import csv
import itertools
import pathlib
from collections.abc import Iterable, Mapping
from typing import Any

import numpy

from .errors import ResultsError

# Columns of integers in the tables of a run; the others are numbers with a fraction.
INTEGERS = frozenset({"frame", "contacts", "pass"})


def number_array(path: pathlib.Path) -> numpy.ndarray:
    """A CSV of numbers with a header as a structured array; an empty cell is NaN. Raises ResultsError where the file
    is missing, has no row, or a cell is no number."""
    if not path.is_file():
        raise ResultsError(f"{path}: no such file; the run did not write or keep it")
    try:
        with path.open(encoding="utf-8", newline="") as file:
            names = file.readline().rstrip("\r\n").split(",")
            types = [(name, numpy.int64 if name in INTEGERS else numpy.float64) for name in names]
            rows = (_filled(line.rstrip("\r\n")) for line in file)
            first = next(rows, None)
            if first is None:
                raise ValueError("has no row")
            table = numpy.loadtxt(itertools.chain([first], rows), dtype=types, delimiter=",", comments=None, ndmin=1)
    except (ValueError, UnicodeDecodeError) as error:
        raise ResultsError(f"{path}: damaged: {error}") from error
    return table


def _filled(line: str) -> str:
    """A row with NaN in its empty cells."""
    if ",," not in line and not line.startswith(",") and not line.endswith(","):
        return line
    return ",".join(cell or "nan" for cell in line.split(","))


def mixed_columns(path: pathlib.Path, texts: Iterable[str]) -> dict[str, numpy.ndarray]:
    """A CSV of numbers and texts by column. A column is float64 where all cells are numbers or empty (NaN),
    otherwise texts (dtype object). `texts` are texts whatever they look like. Raises ResultsError where the file is
    missing, has no header, or a row has more or fewer cells than the header."""
    if not path.is_file():
        raise ResultsError(f"{path}: no such file")
    with path.open(encoding="utf-8", errors="backslashreplace", newline="") as file:
        rows = list(csv.reader(file))
    if not rows:
        raise ResultsError(f"{path}: damaged: has no header")
    names, cells = rows[0], rows[1:]
    for number, row in enumerate(cells, 2):
        if len(row) != len(names):
            raise ResultsError(f"{path}: damaged: row {number} has {len(row)} cells; expected {len(names)}")
    return {name: _column([row[i] for row in cells], name in texts) for i, name in enumerate(names)}


def _column(cells: list[str], is_text: bool) -> numpy.ndarray:
    if not is_text:
        with contextlib.suppress(ValueError):
            return numpy.array([float(cell) if cell else numpy.nan for cell in cells], dtype=numpy.float64)
    return numpy.array(cells, dtype=object)


def as_table(columns: Mapping[str, numpy.ndarray]) -> Any:
    """A pandas DataFrame, or a numpy record array without pandas."""
    try:
        import pandas
    except ImportError:
        return numpy.rec.fromarrays(list(columns.values()),
                                    dtype=[(name, values.dtype) for name, values in columns.items()])
    return pandas.DataFrame(dict(columns))
