#!/usr/bin/env python3
# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""measure.py BUILD [-o DIR]: which lines of sim, render, cli and python the tests executed, by folder, as a Markdown table, and the
files with the most lines that none executed. BUILD is a build of the preset `coverage` in which ctest has run. DIR gets gcovr's pages
of every line. Needs gcovr (Debian's package)."""

import argparse
import collections
import json
import pathlib
import subprocess
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ("sim", "render", "cli", "python", "kernels")
WORST = 25


def measured(build, pages):
    with tempfile.TemporaryDirectory() as temporary:
        summary = pathlib.Path(temporary) / "summary.json"
        command = ["gcovr", f"--root={SOURCE}", f"--object-directory={build}", "--json-summary", summary, "-j", "2",
                   "--exclude-throw-branches"]
        command += [f"--filter={SOURCE}/{folder}/" for folder in FOLDERS]
        if pages:
            pages.mkdir(parents=True, exist_ok=True)
            command += ["--html-details", pages / "index.html"]
        subprocess.run([*command, build], check=True, cwd=build)
        return json.loads(summary.read_text())["files"]


def folder_of(name):
    parts = pathlib.PurePath(name).parts
    return "/".join(parts[:2]) if parts[0] in ("sim", "render") and len(parts) > 2 else parts[0]


def row(name, files):
    lines = sum(file["line_total"] for file in files)
    covered = sum(file["line_covered"] for file in files)
    branches = sum(file["branch_total"] for file in files)
    taken = sum(file["branch_covered"] for file in files)
    return f"| {name} | {lines} | {100 * covered / lines:.1f} % | {100 * taken / max(branches, 1):.1f} % |"


def main():
    arguments = argparse.ArgumentParser()
    arguments.add_argument("build", type=pathlib.Path)
    arguments.add_argument("-o", "--pages", type=pathlib.Path)
    given = arguments.parse_args()
    files = [file for file in measured(given.build.resolve(), given.pages) if file["line_total"]]
    assert files, f"no counters in {given.build}: build the preset coverage, and run ctest there"
    folders = collections.defaultdict(list)
    for file in files:
        folders[folder_of(file["filename"])].append(file)
    print("| folder | lines | executed | branches |\n|---|---|---|---|")
    for name in sorted(folders):
        print(row(name, folders[name]))
    print(row("all", files))
    print("\n| file | lines not executed | executed |\n|---|---|---|")
    for file in sorted(files, key=lambda file: file["line_covered"] - file["line_total"])[:WORST]:
        print(f"| {file['filename']} | {file['line_total'] - file['line_covered']} | {file['line_percent']} % |")


main()
