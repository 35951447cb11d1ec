# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Runs scenarios and studies with the program."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Mapping
from typing import Any

from .errors import RunError
from .program import call
from .results import Run, load
from .scenario_text import assignments, scenario_file
from .sweeps import Sweep, load_sweep


def run(scenario: str | os.PathLike[str] | Mapping[str, Any], output: str | os.PathLike[str] | None = None,
        settings: Mapping[str, Any] | None = None, *, overwrite: bool = False, resume: bool = False,
        device: str | None = None, show_output: bool = False, **overrides: Any) -> Run:
    """Simulates a scenario and returns its results.

    Args:
        scenario: path of a YAML file, name of a shipped scenario (``"default"``), or the scenario as a dict. Paths in a dict are relative to the current folder.
        output: results folder; without it ``output.dir`` of the scenario, otherwise ``out/NAME``.
        settings: keys to change, by their dotted names: ``{"bone.voxel_mm": 0.4}``. None deletes a key.
        overwrite: replace an existing results folder once the run succeeds.
        resume: continue an interrupted run.
        device: OpenCL device, or ``serial``.
        show_output: print the program's progress.
        **overrides: keys to change, with ``__`` for the dot: ``bone__voxel_mm=0.4``.

    Raises:
        InputError: the scenario is wrong; ``.lines`` has a line per mistake.
        RunError: the run failed.
        Interrupted: the run was interrupted, also by Ctrl-C; ``.resumable`` says whether it can be continued.
        ProgramNotFound: the program reamsim was not found.
    """
    options = [option for text in assignments(settings or {}, overrides) for option in ("--set", text)]
    if output is not None:
        options += ["--output", os.fspath(output)]
    if device is not None:
        options += ["--device", device]
    options += ["--overwrite"] * overwrite + ["--resume"] * resume
    with scenario_file(scenario) as path:
        said = call(["run", path, *options], show_output=show_output)
    found = [line.split(": ", 1)[1] for begin in ("results: ", "the results were complete: ") for line in said.splitlines()
             if line.startswith(begin)]
    if not found:
        raise RunError(["the program did not say where its results are; is REAMSIM_PROGRAM another version?"], 0)
    return load(found[-1])


def sweep(study: str | os.PathLike[str], output: str | os.PathLike[str] | None = None, jobs: int | None = None, *,
          show_output: bool = False) -> Sweep:
    """Makes the runs of a study that are missing, and collects its table.

    Args:
        study: path of the study's YAML file, or name of a shipped study.
        output: folder of the study; without it ``out/NAME`` with the name of the file.
        jobs: runs at the same time; without it the program's default.
        show_output: print the program's progress.

    Raises:
        InputError, RunError, Interrupted, ProgramNotFound: as `run`. A run that fails is a row of ``.runs``
            instead, with a warning.
    """
    path = pathlib.Path(study)
    folder = pathlib.Path(output) if output is not None else pathlib.Path("out", path.stem)
    parallel = [] if jobs is None else ["--jobs", str(jobs)]
    failure = None
    try:
        call(["sweep", "run", str(path), "-o", str(folder), *parallel], show_output=show_output)
    except RunError as error:  # some runs failed, or the study did: the table tells
        failure = error
    call(["sweep", "collect", str(path), "-o", str(folder)], show_output=show_output)
    collected = load_sweep(folder)
    if failure is not None and set(collected.statuses) != {"done", "failed"} and set(collected.statuses) != {"failed"}:
        raise failure
    return collected
