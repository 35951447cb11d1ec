# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""real_bone.py REAMSIM SCENARIO: a ream of real bone behaves like one. Exits with 77 (skipped) without the data."""

import csv
import pathlib
import subprocess
import sys
import tempfile

import grids
import real_data


def main():
    program, scenario = sys.argv[1:]
    real_data.require(scenario)
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out"
        sets = ["--set=render.enabled=false", "--set=output.plots=false", "--set=output.meshes=false", "--set=output.vti=false", "--set=bone.voxel_mm=0.6", "--set=motion.frame_rate_hz=200"]
        command = [program, "run", scenario, "-o", str(out), "--quiet", *sets]
        subprocess.run(command, check=True)
        rows = [{k: float(v) for k, v in row.items()} for row in csv.DictReader((out / "forces.csv").open())]
        density = grids.read(str(out / "reamed.vdb"))["density"]

    touching = [i for i, row in enumerate(rows) if row["contacts"] > 0]
    first, last = touching[0], touching[-1]
    assert first > 10 and last < len(rows) - 10, "contact should begin after the approach and end before the retraction does"
    assert all(row["axial_force_n"] == 0 for row in rows[:first] + rows[last + 1:]), "force without contact"
    assert abs(rows[-1]["balance"]) < 1e-4, f"balance {rows[-1]['balance']}"

    def mean_force(begin, end):
        return sum(row["axial_force_n"] for row in rows[begin:end]) / (end - begin)

    tenth = (last - first) // 10
    assert mean_force(first, first + tenth) < 0.6 * mean_force(first + 4 * tenth, first + 6 * tenth), "force should rise"

    # Energy per volume says how dense the bone is that goes: most in the subchondral plate,
    # less deeper, in trabecular bone.
    def specific_energy(begin, end):
        return sum(r["energy_mj"] for r in rows[begin:end]) / sum(r["removed_mm3"] for r in rows[begin:end])

    by_fifth = [specific_energy(first + i * (last - first) // 5, first + (i + 1) * (last - first) // 5) for i in range(5)]
    print("energy per removed volume, mJ/mm3, by fifth of the contact:", [round(e, 2) for e in by_fifth])
    assert by_fifth[4] < 0.9 * max(by_fifth[:4]), "the subchondral layer should be densest"
    assert density.activeVoxelCount() * 0.6**3 > 40_000, "a scapula has more than 40 cm3"


main()
