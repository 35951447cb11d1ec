# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Exceptions and the warning of the package."""

from __future__ import annotations

from collections.abc import Sequence


class ReamsimError(Exception):
    """Base of all exceptions of this package."""


class ProgramError(ReamsimError):
    """The program, or a `Simulation`, ended with an error.

    Attributes:
        lines: the program's error messages, one for each mistake, without the prefix ``reamsim: error:``.
        status: its exit status, of a `Simulation` that of the program for the same error; negative: the number of the
            signal that ended it.
    """

    def __init__(self, lines: Sequence[str], status: int) -> None:
        super().__init__("\n".join(lines))
        self.lines = list(lines)
        self.status = status


class InputError(ProgramError):
    """The scenario, study, an option or an argument is wrong (exit status 2). Each line of a scenario's mistake has file,
    line, column and key."""


class RunError(ProgramError):
    """The run failed (exit status 1), or a signal ended the program."""


class Interrupted(ProgramError):
    """The run was interrupted (exit status 75 or 130).

    Attributes:
        resumable: True where a checkpoint exists: the same call with ``resume=True`` continues.
    """

    def __init__(self, lines: Sequence[str], status: int) -> None:
        super().__init__(lines, status)
        self.resumable = status == 75


class ProgramNotFound(ReamsimError):
    """The program `reamsim` was not found, or the module of `Simulation` that is built with it."""


class ResultsError(ReamsimError):
    """A folder is no results folder, or one of its files is missing or damaged."""


class MissingPackage(ReamsimError, ImportError):
    """An optional package of Python is not installed."""

    def __init__(self, package: str, purpose: str, debian: str) -> None:
        super().__init__(f"{purpose} needs the Python package {package}: install it (Debian: apt-get install {debian})")


class ReamsimWarning(UserWarning):
    """A warning of the program."""
