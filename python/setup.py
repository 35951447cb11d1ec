# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""The version of the package is that of the program: project(reamsim VERSION ...) in ../CMakeLists.txt."""

import pathlib
import re

from setuptools import setup

CMAKE = pathlib.Path(__file__).resolve().parent.parent / "CMakeLists.txt"


def version() -> str:
    found = re.search(r"project\(reamsim VERSION (\S+)", CMAKE.read_text(encoding="utf-8")) if CMAKE.is_file() else None
    if found is None:
        raise SystemExit(f"{CMAKE}: has no version of reamsim; install from the folder python/ of a checkout of reamsim")
    return found[1]


setup(version=version())
