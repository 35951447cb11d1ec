#!/usr/bin/env python3
# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Flat against convex reamers on glenoids of uniform foam, to several end points (docs/validation.md).

    python3 docs/compare_reamers.py build/release/cli/reamsim [VOXEL_MM]

Runs trajectories/foam_*.yaml 10 mm deep, finds in forces.csv where each end point lies, runs them again to there, and
prints tables in Markdown. A plunge along the axis removes volume per travel as much as the face in contact has area
across the axis, so this area is the slope of the removed volume over depth. The true area of the reamed face is that of
the reamed columns of depth_map.csv, each divided by the cosine of the reamer's slope there.
"""
import csv
import itertools
import json
import math
import pathlib
import subprocess
import sys
import tempfile

ROOT = pathlib.Path(__file__).resolve().parent.parent
REAMERS = ("flat", "convex")
CASES = tuple(itertools.product(("uniconcave", "biconcave"), REAMERS))
CONVEX_RADIUS_MM = 29.0
DEEP_MM = 10.0  # beyond the shipped entry point
WINDOW_MM = 0.25  # over which the slope of the volume is taken, either way


def run(program, face, reamer, settings):
    """Rows of forces.csv up to the deepest, the summary, and the depth map."""
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out"
        command = [program, "run", str(ROOT / f"trajectories/foam_{face}_{reamer}.yaml"), "-o", str(out), "--quiet"]
        settings = {"render.enabled": "false", "output.vti": "false", "motion.plunge.retract_mm_s": 200, **settings}
        for key, value in settings.items():
            command += ["--set", f"{key}={value}"]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        rows = list(csv.DictReader((out / "forces.csv").open()))
        summary = json.loads((out / "summary.json").read_text())
        columns = list(csv.DictReader((out / "depth_map.csv").open()))
    removed = itertools.accumulate(float(row["removed_mm3"]) for row in rows)
    curve = [(float(row["depth_mm"]), volume) for row, volume in zip(rows, removed)]
    deepest = max(range(len(curve)), key=lambda i: (curve[i][0], -i))
    return curve[: deepest + 1], summary, columns


def volume_at(curve, depth_mm):
    """Removed volume at a depth beyond first contact, linear between frames."""
    for (d0, v0), (d1, v1) in zip(curve, curve[1:]):
        if d0 <= depth_mm <= d1 and d1 > d0:
            return v0 + (v1 - v0) * (depth_mm - d0) / (d1 - d0)
    return curve[-1][1]


def contact_areas(curve):
    """(depth, area of the face in contact across the axis), mm and mm²."""
    last = curve[-1][0] - WINDOW_MM
    out = []
    for depth in (0.05 * i for i in range(1, int(last / 0.05))):
        low, high = max(depth - WINDOW_MM, 0), depth + WINDOW_MM
        out.append((depth, (volume_at(curve, high) - volume_at(curve, low)) / (high - low)))
    return out


def depth_of_contact(curve, fraction):
    """First depth at which the contact is this fraction of the largest."""
    areas = contact_areas(curve)
    largest = max(area for _, area in areas)
    return next(d for d, area in areas if area >= fraction * largest)


def true_area_mm2(columns, reamer, voxel_mm):
    total = 0.0
    step = sorted({float(c["x_mm"]) for c in columns})
    side = min(b - a for a, b in zip(step, step[1:]))
    for column in columns:
        if not column["depth_mm"] or float(column["depth_mm"]) < 0.1 * voxel_mm:
            continue
        r = math.hypot(float(column["x_mm"]), float(column["y_mm"]))
        cosine = math.sqrt(1 - (r / CONVEX_RADIUS_MM) ** 2) if reamer == "convex" else 1
        total += side * side / cosine
    return total


def to_end_points(program, voxel_mm):
    entry = {}
    curves = {}
    for case in CASES:
        curves[case], summary, _ = run(program, *case, {"bone.voxel_mm": voxel_mm, "motion.plunge.depth_mm": DEEP_MM})
        # Travel from the entry point to first contact.
        entry[case] = DEEP_MM - summary["max_depth_mm"]
    rules = [("3 mm beyond first contact", lambda c: 3.0)]
    for percent in (80, 95):
        rules.append((f"{percent} % of the maximum contact", lambda c, p=percent: depth_of_contact(c, p / 100)))
    print("| end point | face | reamer | depth, mm | removed, mm³ | reamed face, true area, mm² |")
    print("|---|---|---|---|---|---|")
    for name, rule in rules:
        for face, reamer in CASES:
            depth = rule(curves[face, reamer])
            plunge = f"{entry[face, reamer] + depth:.4f}"
            settings = {"bone.voxel_mm": voxel_mm, "motion.plunge.depth_mm": plunge}
            _, summary, columns = run(program, face, reamer, settings)
            area = true_area_mm2(columns, reamer, voxel_mm)
            figures = f"{depth:.2f} | {summary['removed_mm3']:.0f} | {area:.0f}"
            print(f"| {name} | {face} | {reamer} | {figures} |", flush=True)


def to_corrections(program, voxel_mm):
    """The uniconcave face with the axis inclined about the superior axis, to 95 % of the maximum contact."""
    print("\n| correction | reamer | depth, mm | removed, mm³ |\n|---|---|---|---|")
    for degrees in (0, 5, 10):
        for reamer in REAMERS:
            s, c = math.sin(math.radians(degrees)), math.cos(math.radians(degrees))
            settings = {
                "bone.voxel_mm": voxel_mm,
                "motion.plunge.entry_mm": f"[{-7 * s:.5f}, 0, {7 * c:.5f}]",
                "motion.plunge.axis": f"[{s:.6f}, 0, {-c:.6f}]",
                "motion.plunge.depth_mm": 7 + 6,
            }
            curve, _, _ = run(program, "uniconcave", reamer, settings)
            depth = depth_of_contact(curve, 0.95)
            print(f"| {degrees}° | {reamer} | {depth:.2f} | {volume_at(curve, depth):.0f} |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) not in (2, 3):
        sys.exit(__doc__)
    size = float(sys.argv[2]) if len(sys.argv) == 3 else 0.25
    to_end_points(sys.argv[1], size)
    to_corrections(sys.argv[1], size)
