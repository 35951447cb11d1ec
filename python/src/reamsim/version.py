# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""The version of the package, which is that of the program."""

from __future__ import annotations

import importlib.metadata
import pathlib
import re


def _version() -> str:
    checkout = pathlib.Path(__file__).resolve().parents[3] / "CMakeLists.txt"  # of python/src/reamsim
    if checkout.is_file():
        found = re.search(r"project\(reamsim VERSION (\S+)", checkout.read_text(encoding="utf-8"))
        if found:
            return found[1]
    return importlib.metadata.version("reamsim")


__version__: str = _version()
