# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Finds the module `reamsim._simulation`, which is built with the program."""

from __future__ import annotations

import functools
import importlib
import importlib.util
import os
import pathlib
import sys
import sysconfig
from types import ModuleType

from .errors import ProgramNotFound
from .program import __version__, find_program

_NAME = "reamsim._simulation"


@functools.cache
def simulation_module() -> ModuleType:
    """The module: beside this package, otherwise of the installation or the build of the program that `find_program`
    finds. Raises ProgramNotFound where there is none for this Python, or it is one of another version."""
    # Pins PoCL's worker threads to their cores, as the program does. Must be set before OpenCL is loaded.
    os.environ.setdefault("POCL_AFFINITY", "1")
    candidates = _candidates()
    path = next((path for path in candidates if path.is_file()), None)
    if path is None:
        raise ProgramNotFound(
            "reamsim.Simulation needs the module _simulation, which is built with the program for Debian's Python: build it "
            "with ./run.sh, install it with `cmake --install build/release`, or set REAMSIM_PROGRAM to a program that has "
            "it; searched: " + ", ".join(str(path) for path in candidates))
    spec = importlib.util.spec_from_file_location(_NAME, path)
    assert spec is not None and spec.loader is not None
    try:
        module = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
    except ImportError as error:
        raise ProgramNotFound(f"{path}: cannot be loaded: {error}") from error
    if module.__version__ != __version__:
        raise ProgramNotFound(f"{path}: is of version {module.__version__}, and this package of version {__version__}: "
                              "install both from the same checkout")
    sys.modules[_NAME] = module
    return module


def _candidates() -> list[pathlib.Path]:
    file = "_simulation" + sysconfig.get_config_var("EXT_SUFFIX")
    out = [pathlib.Path(__file__).resolve().parent / file]
    try:
        folder = pathlib.Path(find_program()).resolve().parent
    except ProgramNotFound:
        return out
    packages = "lib/python{}.{}/dist-packages/reamsim".format(*sys.version_info[:2])
    return [*out, folder.parent / packages / file, folder.parent / "python" / file]  # .../bin, and BUILD/cli
