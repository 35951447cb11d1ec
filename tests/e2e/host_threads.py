# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""host_threads.py REAMSIM SCENARIO: a whole run with the serial engine, for the thread sanitizer to watch.

Coarser than the scenario is and with a picture or two, because the sanitizer is slow. Exits with 77 (skipped) where the
scenario needs data that is not there.
"""

import pathlib
import subprocess
import sys
import tempfile

import real_data

COARSE = {
    "bone.voxel_mm": 0.6,
    "motion.frame_rate_hz": 100,
    "render.every_frames": 400,
    "render.width_px": 320,
    "render.height_px": 180,
}


def main():
    program, scenario = sys.argv[1:]
    real_data.require(scenario)
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out"
        sets = [f"--set={key}={value}" for key, value in COARSE.items()]
        command = [program, "run", scenario, "-o", str(out), "--quiet", "--device", "serial", *sets]
        subprocess.run(command, check=True)
        assert (out / "reamed.png").stat().st_size > 0


main()
