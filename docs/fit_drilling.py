#!/usr/bin/env python3
# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""The constants of trajectories/validation/drilling_models.csv, from the published means alone (docs/validation.md).

    python3 docs/fit_drilling.py build/release/cli/reamsim

Runs trajectories/validation/drilling_fit.yaml, a plunge at three spindle speeds, without and with a size effect and with
an edge force, and calls `reamsim fit` on it: each published mean of drilling.csv holds for the time in which the drill is
1.5 to 2.2, 2.3 to 3.0 and 3.1 to 3.8 mm deep. For the rows "..., predicted" the speed of the row is left out of the fit.
Warnings of R² come from models that do not describe the thrust.
"""
import csv
import json
import pathlib
import subprocess
import sys
import tempfile

FOLDER = pathlib.Path(__file__).resolve().parent.parent / "trajectories/validation"
SPEED = "motion.plunge.spin_rpm"
START_S = {1000: 0.85, 1250: 1.25, 1500: 1.65}  # depth is 2 t - 0.2 mm
SAMPLES, STEP_S = 35, 0.01
# m = 0.30 is the slope of the human torques over the speed, n^-0.70; that of the artificial ones is 0.43.
MODELS = {"plain law": {},
          "size effect": {"exponent": 0.3, "reference_mm": 0.05, "cutting_edges": 2},
          "edge force": {"tangential_n_mm": 1, "normal_n_mm": 1, "cutting_edges": 2}}
SECTIONS = {"size effect": "cutting.size_effect.", "edge force": "cutting.edge_force."}
KEYS = {"u0": "cutting.specific_energy_j_mm3", "k_n": "cutting.normal_ratio", "K_t": "cutting.edge_force.tangential_n_mm",
        "K_n": "cutting.edge_force.normal_n_mm"}


def published():
    """{material: {speed: {"axial_force_n": mean, "spin_torque_nmm": mean}}}."""
    lines = (FOLDER / "drilling.csv").read_text().splitlines()
    out = {}
    for row in csv.DictReader(line for line in lines if not line.startswith("#")):
        column = next(name for name in ("axial_force_n", "spin_torque_nmm") if name in row["result"])
        out.setdefault(row["name"], {}).setdefault(int(row[SPEED]), {})[column] = float(row["value"])
    return out


def fitted(program, run, means, speeds, folder):
    """{key: constant} from the means at these speeds."""
    measured = folder / "measured.csv"
    with measured.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["time_s", "axial_force_n", "spin_torque_nmm"])
        table.writerows([round(START_S[speed] + i * STEP_S, 6), *means[speed].values()]
                        for speed in speeds for i in range(SAMPLES))
    subprocess.run([program, "fit", run, measured, "-o", folder / "fit.json", "--overwrite", "--quiet"], check=True)
    constants = json.loads((folder / "fit.json").read_text())["constants"]
    return {KEYS[one["name"]]: f"{one['value']:.4g}" for one in constants if one["fitted"]}


def main(program):
    rows = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for model, section in MODELS.items():
            keys = {SECTIONS[model] + key: value for key, value in section.items()}
            sets = [part for key, value in keys.items() for part in ("--set", f"{key}={value}")]
            run = folder / model
            subprocess.run([program, "run", FOLDER / "drilling_fit.yaml", "-o", run, *sets, "--quiet"], check=True)
            for material, means in published().items():
                whole = fitted(program, run, means, list(means), folder)
                for speed in means:
                    others = fitted(program, run, means, [one for one in means if one != speed], folder)
                    for label, constants in ((model, whole), (f"{model}, predicted", others)):
                        rows.append({"label": label, "name": material, SPEED: speed, **keys, **constants})
    names = list(dict.fromkeys(name for row in rows for name in row))
    with (FOLDER / "drilling_models.csv").open("w", newline="") as file:
        table = csv.DictWriter(file, names, lineterminator="\n")
        table.writeheader()
        table.writerows(sorted(rows, key=lambda row: ("predicted" in row["label"], list(MODELS).index(row["label"].split(",")[0]))))


if __name__ == "__main__":
    main(sys.argv[1])
