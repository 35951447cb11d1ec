# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""keys.py REAMSIM ROOT: every key of summary.json and every column of each CSV that runs write is on a page of results, and
docs/results.md names no key of summary.json that no run has.

A row of its table stands for the names in its first cell, where `.name` replaces the last part of the name before it, and for
the names below them that its text gives in backticks."""

import csv
import json
import pathlib
import re
import subprocess
import sys
import tempfile

import scans

PAGES = ("results", "figures", "columns", "study-files")
HOLDER = "holder: [{name: shaft, from_z_mm: 30, to_z_mm: 80, diameter_mm: 8}]"
GLENOID = "bone: {source: phantom, side: left, voxel_mm: 1, phantom: {shape: glenoid, walch: A1}}\n"
IMPLANT = ("metrics: {implant: {backside_radius_mm: 29, width_mm: 22, height_mm: 28, thickness_mm: 4, pegs: [{from_mm: [0, 0, 0], "
           "to_mm: [0, 0, -12], diameter_mm: 5}]}}\n")
BLOCK = "bone: {source: phantom, voxel_mm: 0.5, phantom: {shape: half_space, size_mm: [8, 8, 4]}}\n"
SLOW = "{approach_mm: 0.1, feed_mm_s: 1, depth_mm: 0.3, dwell_s: 0, retract_mm: 1}"
TAIL = "version: 2\n"
WITHOUT_PICTURES = "render: {enabled: false}\n"
WITH_PICTURES = "render: {width_px: 64, height_px: 64, cameras: [overview], report: false}\n"
# Each has results that others lack.
RUNS = {
    "plunge": f"{GLENOID}{IMPLANT}tool: {{mesh: reamer.stl, {HOLDER}}}\ncutting: {{preset: assumed-low}}\n"
              "motion: {frame: glenoid, frame_rate_hz: 50, plunge: {from: contact, depth_mm: 1.5, retract_mm: 12}}\n",
    "flat": f"{GLENOID}tool: {{mesh: flat.stl}}\nmotion: {{frame: glenoid, frame_rate_hz: 50, plunge: {{from: contact, depth_mm: 4}}}}\n",
    "resolved": f"{BLOCK}tool: {{mesh: edges.stl, spin: resolved, scale: 0.2}}\ncutting: {{erosion: exact}}\n"
                f"motion: {{frame_rate_hz: 50, plunge: {SLOW}}}\n",
    "shell": f"{BLOCK}tool: {{mesh: flat.stl}}\ncutting: {{erosion: remove}}\nmotion: {{frame_rate_hz: 50, plunge: {SLOW}}}\n",
    "push": f"{BLOCK}tool: {{mesh: flat.stl}}\nmotion: {{push: {{thrust_n: 30, approach_mm: 0.1, depth_mm: 0.3, time_s: 2}}}}\n",
    "springs": f"{BLOCK}tool: {{mesh: flat.stl}}\nmotion: {{plunge: {SLOW}, compliance: {{stiffness_n_mm: [1000, 1000, 1000]}}}}\n",
    "passes": f"{BLOCK}tool: {{mesh: flat.stl}}\nmotion: {{frame_rate_hz: 50, passes: [plunge: {SLOW}, plunge: {SLOW}]}}\n",
    "scan": "bone: {source: ct, voxel_mm: 1, ct: {path: ball.nrrd, seed_mm: [19, 19, 19]}}\ntool: {mesh: flat.stl}\n"
            "motion: {frame_rate_hz: 50, plunge: {entry_mm: [19.5, 19.5, 33], depth_mm: 1}}\n",
}


def section(page, title):
    begin = re.search(rf"^(#+) {re.escape(title)}$", page, re.M)
    return re.split(rf"^#{{1,{len(begin[1])}}} ", page[begin.end():], maxsplit=1, flags=re.M)[0]


def rows_of(text):
    """Per row of the tables: the full names of the first cell, and all names of the others."""
    for line in text.splitlines():
        if not line.startswith("| `"):
            continue
        first, rest = re.split(r"(?<!\\)\|", line[1:], maxsplit=1)
        names = []
        for name in re.findall(r"`([^`]+)`", first):
            names.append(names[-1].rsplit(".", 1)[0] + name if name.startswith(".") else name)
        yield names, set(re.findall(r"`\.?([^`]+)`", rest))


def keys_of(value, path=""):
    if isinstance(value, dict) and value:
        for key, inner in value.items():
            yield from keys_of(inner, f"{path}.{key}" if path else key)
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for inner in value:
            yield from keys_of(inner, path + "[]")
    else:
        yield path


def is_documented(key, rows):
    parts = key.replace("[]", "").split(".")
    for names, words in rows:
        for name in names:
            head = name.replace("[]", "").split(".")
            below = parts[len(head):]
            if head[:len(parts)] == parts:
                return True  # a section that is null in some run
            if parts[:len(head)] == head and all(part in words or ".".join(below) in words for part in below):
                return True
    return False


def simulate(program, folder, root):
    for name, mesh in (("reamer.stl", "reamer_convex.stl"), ("flat.stl", "reamer_flat.stl"), ("edges.stl", "reamer_convex_edges.stl")):
        (folder / name).symlink_to(root / "assets" / mesh)
    scans.write_scan(folder / "ball.nrrd")
    for name, text in RUNS.items():
        (folder / f"{name}.yaml").write_text(text + TAIL + (WITH_PICTURES if name == "flat" else WITHOUT_PICTURES))
        subprocess.run([program, "run", f"{name}.yaml", "-o", name, "--quiet"], cwd=folder, check=True, timeout=120, capture_output=True)
    subprocess.run([program, "compare", "shell", "resolved", "-o", "compared"], cwd=folder, check=True, capture_output=True)


def check_columns(text, folder):
    """Columns of the CSV files of runs, against the words of the pages in backticks, alone or in a list with commas."""
    words = {word for span in re.findall(r"`([^`\n]+)`", text) for word in span.split(",")}
    missing, files = [], 0
    for path in sorted(folder.glob("*/*.csv")):
        if path.name == "runs.csv" or path.parent.name == "scan" and path.name == "poses.csv":
            continue  # its columns are keys
        files += 1
        with path.open(encoding="utf-8") as file:
            missing += [f"{path.relative_to(folder)}: {column}" for column in next(csv.reader(file)) if column not in words]
    assert files >= 20, files
    return missing


def main():
    program, root = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    pages = {name: (root / f"docs/{name}.md").read_text() for name in PAGES}
    rows = list(rows_of(section(pages["results"], "summary.json")))
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        simulate(program, folder, root)
        found = {key for run in RUNS for key in keys_of(json.loads((folder / run / "summary.json").read_text()))}
        missing = check_columns("\n".join(pages.values()), folder)
    missing += sorted(f"summary.json: {key}" for key in found if not is_documented(key, rows))
    plain = {key.replace("[]", "") for key in found}
    stale = [name for names, _ in rows for name in names
             if not any(key == name.replace("[]", "") or key.startswith(name.replace("[]", "") + ".") for key in plain)]
    assert not missing and not stale, f"not in docs/ ({', '.join(PAGES)}):\n" + "\n".join(missing) + "\nin no run:\n" + "\n".join(stale)
    print(f"{len(found)} keys of summary.json")


main()
