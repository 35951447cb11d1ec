# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Finds the program `reamsim`, whose version is that of the package, and runs scenarios and studies with it."""

from __future__ import annotations

import importlib.metadata
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import warnings
from collections.abc import Mapping, Sequence
from typing import Any

from .errors import InputError, Interrupted, ProgramError, ProgramNotFound, ReamsimWarning, RunError
from .results import Run, Sweep, load, load_sweep
from .scenario_text import assignments, scenario_file

_ERROR, _WARNING = "reamsim: error: ", "reamsim: warning: "
_INPUT_STATUS, _INTERRUPTED_STATUSES = 2, (75, 130)


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


def find_program() -> str:
    """Path of the program: that of the environment variable ``REAMSIM_PROGRAM``; otherwise ``bin/reamsim`` of the
    prefix where this package is installed, or ``build/release/cli/reamsim`` of the checkout that it lies in;
    otherwise ``reamsim`` on ``PATH``. Raises ProgramNotFound where there is none, or ``REAMSIM_PROGRAM`` names no
    executable file."""
    named = os.environ.get("REAMSIM_PROGRAM")
    if named:
        found = shutil.which(named)
        if found is None:
            raise ProgramNotFound(f"REAMSIM_PROGRAM={named}: not an executable file; set it to the program reamsim")
        return found
    for folder in pathlib.Path(__file__).resolve().parents:
        for candidate in (folder / "bin/reamsim", folder / "build/release/cli/reamsim"):
            if candidate.is_file() and os.access(candidate, os.X_OK):
                return str(candidate)
    found = shutil.which("reamsim")
    if found is None:
        raise ProgramNotFound(
            "the program reamsim was not found beside the Python package or on PATH; build it with ./run.sh, or set "
            "the environment variable REAMSIM_PROGRAM to its path")
    return found


def call(arguments: Sequence[str], *, show_output: bool = False) -> str:
    """Runs the program with a command and its options, and returns its standard output; `show_output` prints it as well.
    Warnings become `ReamsimWarning`. Raises InputError, RunError or Interrupted by the exit status, ProgramNotFound where
    there is no program. Ctrl-C (``KeyboardInterrupt``) interrupts the program, which writes a checkpoint."""
    program, out = find_program(), []
    # Standard error goes to memory: a full pipe would stop the program.
    with open(os.memfd_create("stderr"), "w+", encoding="utf-8", errors="backslashreplace") as errors:
        try:
            child = subprocess.Popen([program, *arguments], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=errors,
                                     text=True, encoding="utf-8", errors="backslashreplace")
        except OSError as error:
            raise ProgramNotFound(f"{program}: cannot be started ({error.strerror}); set REAMSIM_PROGRAM to the program "
                                  "reamsim") from error
        with child:
            try:
                for line in child.stdout or ():
                    out.append(line)
                    if show_output:
                        print(line, end="", flush=True)
            except KeyboardInterrupt:
                child.send_signal(signal.SIGINT)  # a notebook interrupts the kernel alone
                child.communicate()
                if child.returncode == 0:
                    raise
        errors.seek(0)
        lines = errors.read().splitlines()
    mistakes = [line for line in lines if not line.startswith(_WARNING)]
    error = _error(mistakes, child.returncode) if child.returncode != 0 else None
    try:
        _warn([line.removeprefix(_WARNING) for line in lines if line.startswith(_WARNING)])
    except ReamsimWarning as warning:  # the caller wants warnings as errors
        if error is None:
            raise
        raise error from warning
    if error is not None:
        raise error
    return "".join(out)


def _warn(texts: Sequence[str]) -> None:
    """Issues warnings in the name of the caller of this package. Those of a line within it would be shown once, however
    many runs have them."""
    package, level = str(pathlib.Path(__file__).parent), 2
    frame = sys._getframe(1)
    while frame.f_back is not None and os.path.dirname(frame.f_code.co_filename) == package:
        frame, level = frame.f_back, level + 1
    for text in texts:
        warnings.warn(text, ReamsimWarning, stacklevel=level)


def _error(lines: list[str], status: int) -> ProgramError:
    lines = [line.removeprefix(_ERROR) for line in lines]
    if status < 0:
        name = signal.Signals(-status).name if -status in iter(signal.Signals) else str(-status)
        lines.append(f"the program was ended by the signal {name}")
    if not lines:
        lines.append(f"the program ended with status {status}, without a message")
    if status == _INPUT_STATUS:
        return InputError(lines, status)
    if status in _INTERRUPTED_STATUSES:
        return Interrupted(lines, status)
    return RunError(lines, status)


def _version() -> str:
    checkout = pathlib.Path(__file__).resolve().parents[3] / "CMakeLists.txt"  # of python/src/reamsim
    if checkout.is_file():
        found = re.search(r"project\(reamsim VERSION (\S+)", checkout.read_text(encoding="utf-8"))
        if found:
            return found[1]
    return importlib.metadata.version("reamsim")


__version__: str = _version()
