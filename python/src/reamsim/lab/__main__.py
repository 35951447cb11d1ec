# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""__main__.py COMMAND [PATH...]: what the program calls for `reamsim fit`, `uq`, `validate` and `sweep` (cli/lab.cpp). The job is JSON on
standard input, the answer JSON on standard output: ``say`` and ``warn``, lines for the terminal, or ``error``, with exit
status 2 where the input is wrong. COMMAND ``check`` says whether the packages are installed, and needs none."""

import importlib.util
import json
import os
import pathlib
import re
import sys

PACKAGES = {"numpy": "python3-numpy", "scipy": "python3-scipy", "matplotlib": "python3-matplotlib", "yaml": "python3-yaml"}


def main() -> int:
    missing = [debian for module, debian in PACKAGES.items() if importlib.util.find_spec(module) is None]
    if missing:
        print(json.dumps({"error": f"{sys.executable} has not all packages that the statistics need; install them: "
                                   f"apt install {' '.join(missing)}; or set REAMSIM_PYTHON to a Python that has them"}))
        return 1
    if sys.argv[1] == "check":
        print("{}")
        return 0
    # One thread of linear algebra: the order of sums, and so the last digit, must not depend on their number.
    for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
        os.environ[name] = "1"
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
    from reamsim.errors import ProgramError
    from reamsim.lab import bridge

    try:
        answer, status = bridge.COMMANDS[sys.argv[1]](json.load(sys.stdin.buffer), *sys.argv[2:]), 0
    except ProgramError as error:
        answer, status = {"error": "\n".join(error.lines)}, error.status
    except OSError as error:
        answer, status = {"error": f"{error.filename}: cannot be written; is the disk full or the folder read-only?"}, 1
    # Bytes of a path that are no UTF-8 as the program writes them.
    print(re.sub(r"\\udc([89a-f][0-9a-f])", r"\\\\x\1", json.dumps(answer)))
    return status


if __name__ == "__main__":
    sys.exit(main())
