# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""setup_script.py SOURCE_DIR: which packages cmake/setup.sh chooses, with stand-ins for apt-cache and dpkg-query.

A long answer must count: a pipe to `grep -q` exits early, the writer fails with SIGPIPE, and with `set -o pipefail` the pipeline does."""

import os
import pathlib
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(sys.argv[1])
# The candidate first, then more lines than any buffer of a pipe holds, in the language of the caller.
APT_CACHE = """#!/bin/bash
case $2 in
  new) candidate=1.0 ;; other) candidate=2.0 ;; *) candidate='(none)' ;;
esac
[ "${LC_ALL-}" = C ] && word=Candidate || word=Installationskandidat
printf '%s:\\n  Installed: (none)\\n  %s: %s\\n' "$2" "$word" "$candidate"
for line in {1..20000}; do echo "     $line 500"; done
"""
DPKG_QUERY = """#!/bin/bash
[ "${!#}" != present ] || printf installed
"""


def chosen(folder, *entries):
    script = f'set -euo pipefail; source "{SOURCE}/cmake/setup.sh"; choose "$@"; echo "${{missing[*]}}"'
    done = subprocess.run(["bash", "-c", script, "bash", *entries], capture_output=True, text=True,
                          env=dict(os.environ, PATH=f"{folder}:{os.environ['PATH']}", LANG="de_DE.UTF-8"))
    assert done.returncode == 0 and not done.stderr, done.stderr
    return done.stdout.split()


with tempfile.TemporaryDirectory() as folder:
    for name, text in {"apt-cache": APT_CACHE, "dpkg-query": DPKG_QUERY}.items():
        program = pathlib.Path(folder, name)
        program.write_text(text)
        program.chmod(0o755)
    for entries, expected in {
            ("new",): ["new"],
            ("present",): [],
            ("new?",): ["new"],
            ("absent?",): [],
            ("absent",): ["absent"],
            ("absent|new",): ["new"],
            ("absent|present",): [],
            ("new|other",): ["new"],
            ("present", "absent?", "other?", "new|absent"): ["other", "new"]}.items():
        found = chosen(folder, *entries)
        assert found == expected, f"{entries}: {found} instead of {expected}"
print("the packages that apt offers, whatever the length of its answer")
