# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""shoulder_errors.py REAMSIM ROOT: some runs of the study of errors on a real shoulder (docs/guide/uncertainty.md) are like the
scenario without errors. Exits with 77 (skipped) without the data."""

import csv
import pathlib
import subprocess
import sys
import tempfile

import real_data
import yaml

# 30 mm about the glenoid, which is as far as the reamer reaches; coarse, for less time.
LESS = {"bone.ct.crop_min_mm": [96, 145, -471], "bone.ct.crop_max_mm": [157, 206, -410], "bone.voxel_mm": 0.5, "motion.frame_rate_hz": 250}


def main():
    program, root = sys.argv[1], pathlib.Path(sys.argv[2])
    real_data.require(root / "trajectories/ct_shoulder.yaml")
    shipped = yaml.safe_load((root / "trajectories/studies/shoulder_errors.yaml").read_text())
    with tempfile.TemporaryDirectory() as folder:
        study = f"{folder}/study.yaml"
        pathlib.Path(study).write_text(yaml.safe_dump(
            {**shipped, "base": str(root / "trajectories/ct_shoulder.yaml"), "set": {**shipped["set"], **LESS}}, sort_keys=False))
        subprocess.run([program, "sweep", "run", study, "-o", folder + "/out", "--shard", "1/128", "--jobs", "2"], check=True)
        subprocess.run([program, "sweep", "collect", study, "-o", folder + "/out"], check=True)
        rows = list(csv.DictReader(open(folder + "/out/runs.csv", newline="")))
    assert len(rows) == 256
    done = [row for row in rows if row["status"] == "done"]
    assert len(done) == 2, [row["status"] for row in rows]
    for row in done:
        # Without errors -0.6 and 21.2 degrees, 94 %.
        assert abs(float(row["metrics.orientation.reamed.version_deg"]) + 0.6) < 8, row
        assert abs(float(row["metrics.orientation.reamed.inclination_deg"]) - 21.2) < 8, row
        assert 60 < float(row["metrics.seating.seated_percent"]) <= 100, row
    assert len({row["metrics.orientation.reamed.version_deg"] for row in done}) == 2, "errors change nothing"


main()
