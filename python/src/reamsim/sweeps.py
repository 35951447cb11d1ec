# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Results of a study: many runs from one file."""

from __future__ import annotations

import functools
import os
import pathlib
from collections.abc import Iterator
from typing import Any

import numpy

from .errors import ResultsError
from .results import Run
from .tables import as_table, mixed_columns

# Columns of runs.csv that are texts, whatever they look like: an id of digits alone would lose its zeros.
_TEXTS = frozenset({"id", "status", "message"})
_NEEDED = ("run", "id", "status")


def load_sweep(folder: str | os.PathLike[str]) -> Sweep:
    """Opens the folder of a study that `reamsim sweep collect` has collected. Raises ResultsError where the folder
    or its runs.csv is missing or damaged."""
    return Sweep(pathlib.Path(folder))


class Sweep:
    """Results of a study.

    Attributes:
        dir: folder of the study, with ``runs.csv`` and ``runs/ID/``.
    """

    dir: pathlib.Path

    def __init__(self, folder: pathlib.Path) -> None:
        self.dir = folder
        if not folder.is_dir():
            raise ResultsError(f"{folder}: no such folder; expected the folder of a study")
        if not (folder / "runs.csv").is_file():
            raise ResultsError(f"{folder}: has no runs.csv; expected the folder of a study: call `reamsim sweep collect`")
        self._columns = mixed_columns(folder / "runs.csv", _TEXTS)
        missing = [name for name in _NEEDED if name not in self._columns]
        if missing:
            raise ResultsError(f"{folder / 'runs.csv'}: damaged, or not of a study: has no column {missing[0]}")
        try:
            self._columns["run"] = self._columns["run"].astype(numpy.int64)
        except ValueError as error:
            raise ResultsError(f"{folder / 'runs.csv'}: damaged: column run: {error}") from error

    def __repr__(self) -> str:
        return f"<reamsim.Sweep {str(self.dir)!r}, {len(self)} runs>"

    def __len__(self) -> int:
        return len(self._columns["run"])

    def __iter__(self) -> Iterator[Run]:
        """The runs that have results, in the order of the table."""
        return (Run(self._folder(name)) for name in self.ids if (self._folder(name) / "summary.json").is_file())

    @property
    def ids(self) -> list[str]:
        """Identifiers of all runs, in the order of the table."""
        return [str(name) for name in self._columns["id"]]

    @property
    def statuses(self) -> list[str]:
        """Status of all runs, in the order of the table: ``done``, ``failed``, ``interrupted`` or ``missing``."""
        return [str(status) for status in self._columns["status"]]

    @functools.cached_property
    def runs(self) -> Any:
        """runs.csv: a row per run. Columns ``run``, ``id``, ``status``, ``message`` (why a run failed; of a finished run its
        warnings), then the parameters, then every number of summary.json with its dotted name
        (``forces.peak_force_n``). A pandas DataFrame, or a numpy record array without pandas; a missing number is
        NaN."""
        return as_table(self._columns)

    def run(self, id: str) -> Run:
        """Results of one run. Raises ResultsError where there is no run of this id, or it has no results: it failed (the
        message says why), or they were not kept."""
        if id not in self.ids:
            raise ResultsError(f"{self.dir}: has no run {id}; column id of runs.csv lists them")
        row = self.ids.index(id)
        if not (self._folder(id) / "summary.json").is_file():
            message = str(self._columns["message"][row]) if "message" in self._columns else ""
            raise ResultsError(f"{self._folder(id)}: run {id} has no results; its status is "
                               f"{self._columns['status'][row]}{': ' + message if message else ''}")
        return Run(self._folder(id))

    def _folder(self, id: str) -> pathlib.Path:
        return self.dir / "runs" / id
