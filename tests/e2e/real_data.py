# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""The public CT and meshes, in the folder that REAMSIM_DATA names."""

import os
import pathlib
import re
import sys

SKIPPED = 77


def require(scenario):
    """Exits with 77 (skipped) where a file that the scenario names below ${REAMSIM_DATA} does not exist."""
    for name in re.findall(r"\$\{REAMSIM_DATA\}\S+", pathlib.Path(scenario).read_text()):
        path = pathlib.Path(scenario).parent / os.path.expandvars(name)
        if not path.exists():
            print(f"skipped: no {path}; set REAMSIM_DATA to the folder that holds the public data")
            sys.exit(SKIPPED)
