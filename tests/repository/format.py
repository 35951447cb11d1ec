# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""format.py CLANG_FORMAT ROOT: every C++ file of the project is as clang-format writes it with .clang-format."""

import pathlib
import subprocess
import sys

FOLDERS = ("assets", "cli", "docs/examples", "kernels", "python", "render", "sim", "tests")


def main():
    clang_format, root = sys.argv[1:]
    files = sorted(str(file) for folder in FOLDERS for ending in ("cpp", "h") for file in (pathlib.Path(root) / folder).rglob(f"*.{ending}"))
    assert len(files) > 500, files
    done = subprocess.run([clang_format, "--dry-run", "-Werror", *files], capture_output=True, text=True)
    sys.exit(done.stderr if done.returncode != 0 else 0)


main()
