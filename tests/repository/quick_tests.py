# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""quick_tests.py ROOT BUILD: every name of tests/quick.txt is a suite or a test of the build, whose names differ. quick_tests.py ROOT: prints the regular
expression of these tests for CTest."""

import json
import pathlib
import subprocess
import sys


def names(root):
    lines = pathlib.Path(root, "tests/quick.txt").read_text().splitlines()
    return [name for line in lines if not line.startswith("#") for name in line.split()]


def main():
    chosen = names(sys.argv[1])
    if len(sys.argv) == 2:  # a suite with parameters has a prefix: Both/Suite
        print("(^|/)({})$|^({})$".format("|".join(name for name in chosen if "." not in name),
                                          "|".join(name.replace(".", "[.]") for name in chosen if "." in name)))
        return
    listed = subprocess.run(["ctest", "--test-dir", sys.argv[2], "--show-only=json-v1"], capture_output=True, text=True, check=True)
    tests = [test["name"] for test in json.loads(listed.stdout)["tests"]]
    assert len(tests) > 250, len(tests)
    assert len(set(tests)) == len(tests), "CTest mixes up tests of one name: " + ", ".join(sorted({name for name in tests if tests.count(name) > 1}))
    there = {*tests, *(test.split("/")[-1] for test in tests)}
    stale = [name for name in chosen if name not in there]
    assert not stale, f"tests/quick.txt names no test of the build: {stale}"


main()
