#!/usr/bin/env python3
# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Checks a build against the numbers of docs/reference/expected.json (docs/verification.md).

    python3 docs/reference/check.py build/release/cli/reamsim [--renew] [NAME...]

Runs the shipped scenarios and validation studies below, or those named. Of a scenario it compares the removed volume and the sums
of columns of forces.csv, exactly: these bytes are the same on every system (docs/reliability.md). Of a study it compares each simulated
number, within 1e-9 of it: fits of the reamed face depend on the mathematical library. Prints a table of what differs; exit status 1
if anything does. --renew writes expected.json instead, for a change that is meant to change numbers.
"""
import csv
import json
import math
import pathlib
import subprocess
import sys
import tempfile

SCENARIOS = ("default", "half_space", "push", "compliance", "several_passes", "plan_implant", "foam_uniconcave_flat",
             "foam_biconcave_convex", "study_concentric", "study_eccentric_10deg")
STUDIES = ("drilling", "foam", "pegs", "augments")  # trajectories/validation/NAME.yaml
SUMS = ("removed_mm3", "energy_mj", "axial_force_n", "spin_torque_nmm", "force_x_n", "force_y_n", "force_z_n", "contacts")
STUDY_TOLERANCE = 1e-9  # relative
PLAIN = ("render.enabled=false", "output.vti=false", "output.meshes=false", "output.plots=false")

HERE = pathlib.Path(__file__).resolve().parent
EXPECTED = HERE / "expected.json"


def call(program, *arguments):
    subprocess.run([program, *arguments, "--quiet"], check=True, stdout=subprocess.DEVNULL)


def of_scenario(program, name, folder):
    """The removed volume of summary.json, and the sums of SUMS over forces.csv."""
    call(program, "run", HERE.parents[1] / f"trajectories/{name}.yaml", "-o", folder / name, *(f"--set={one}" for one in PLAIN))
    rows = list(csv.DictReader((folder / name / "forces.csv").open()))
    removed = json.loads((folder / name / "summary.json").read_text())["removed_mm3"]
    return {"summary: removed_mm3": removed,
            **{f"sum of {column}": math.fsum(float(row[column]) for row in rows) for column in SUMS}}


def of_study(program, name, folder):
    """Every simulated number, by model and row, and the verdicts of the models."""
    call(program, "validate", HERE.parents[1] / f"trajectories/validation/{name}.yaml", "-o", folder)
    rows = list(csv.DictReader((folder / name / "comparison.csv").open()))
    published = ("value", "low", "high", "unit", "simulated", "verdict", "verdict_of_model")
    found = {", ".join(value for key, value in row.items() if key not in published): float(row["simulated"]) for row in rows}
    return found | {f"{row['model']}: verdict": row["verdict_of_model"] for row in rows}


def same(name, found, expected):
    if name in STUDIES and isinstance(found, float) and isinstance(expected, float):
        return math.isclose(found, expected, rel_tol=STUDY_TOLERANCE)
    return found == expected


def main(program, *options):
    names = [one for one in options if one != "--renew"] or [*SCENARIOS, *STUDIES]
    for name in set(names) - {*SCENARIOS, *STUDIES}:
        sys.exit(f"check.py: found {name}; expected one of {', '.join((*SCENARIOS, *STUDIES))}")
    expected = json.loads(EXPECTED.read_text()) if EXPECTED.exists() else {}
    different = 0
    for name in names:
        with tempfile.TemporaryDirectory() as folder:
            found = (of_study if name in STUDIES else of_scenario)(program, name, pathlib.Path(folder))
        known = expected.get(name, {})
        wrong = [key for key in {**known, **found} if not same(name, found.get(key), known.get(key))]
        print(f"{name}: {len(found)} numbers, {len(wrong)} differ from expected.json", flush=True)
        if "--renew" in options:
            expected[name] = found
            continue
        different += len(wrong)
        for key in wrong:
            print(f"| {name} | {key} | expected {known.get(key)} | found {found.get(key)} |")
    if "--renew" in options:
        EXPECTED.write_text(json.dumps(expected, indent=1) + "\n")
    return 1 if different else 0


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
