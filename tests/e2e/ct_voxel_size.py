# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""ct_voxel_size.py REAMSIM SCENARIO: force and energy on a real CT do not depend on the voxel size. Exits with 77
(skipped) without the data."""

import json
import pathlib
import subprocess
import sys
import tempfile

import real_data


# 30 mm about the glenoid, which is as far as the reamer reaches.
CROP = ["--set=bone.ct.crop_min_mm=[96, 145, -471]", "--set=bone.ct.crop_max_mm=[157, 206, -410]"]


def run(program, scenario, out, voxel_mm):
    sets = [f"--set=bone.voxel_mm={voxel_mm}", "--set=motion.plunge.depth_mm=2.2", "--set=motion.frame_rate_hz=250",
            "--set=render.enabled=false", "--set=output.meshes=false", "--set=output.vti=false", "--set=output.plots=false"]
    subprocess.run([program, "run", scenario, "-o", str(out), "--quiet", *CROP, *sets], check=True)
    return json.loads((out / "summary.json").read_text())


def main():
    program, scenario = sys.argv[1:]
    real_data.require(scenario)
    with tempfile.TemporaryDirectory() as folder:
        coarse, fine = (run(program, scenario, pathlib.Path(folder) / str(v), v) for v in (0.4, 0.2))

    def difference(value):
        return value(fine) / value(coarse) - 1

    bars = {"mean thrust": (lambda s: s["forces"]["mean_axial_force_n"], 0.03),
            "peak thrust": (lambda s: s["forces"]["peak_axial_force_n"], 0.01),
            "energy per removed volume": (lambda s: s["energy_mj"] / s["removed_mm3"], 0.005)}
    for name, (value, bar) in bars.items():
        print(f"{name}: {value(coarse):.3f} at 0.4 mm, {value(fine):.3f} at 0.2 mm, {100 * difference(value):+.2f} %")
        assert abs(difference(value)) < bar, f"{name} depends on the voxel size"


main()
