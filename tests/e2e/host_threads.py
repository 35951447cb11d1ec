"""host_threads.py REAMSIM SCENARIO DATA: a whole run with the serial engine, for the thread sanitizer to watch.

Coarser than the scenario is and with a picture or two, because the sanitizer is slow. Exits with 77 (skipped) where the
scenario needs data that is not there.
"""

import os
import pathlib
import subprocess
import sys
import tempfile

COARSE = {
    "bone.voxel_mm": 0.6,
    "motion.frame_rate_hz": 100,
    "render.every_frames": 400,
    "render.width_px": 320,
    "render.height_px": 180,
}


def main():
    program, scenario, default_data = sys.argv[1:]
    data = os.environ.get("REAMSIM_DATA", default_data)
    if "${REAMSIM_DATA}" in pathlib.Path(scenario).read_text() and not pathlib.Path(data).is_dir():
        print(f"skipped: no real data in {data}; set REAMSIM_DATA to the folder that holds it")
        sys.exit(77)
    with tempfile.TemporaryDirectory() as folder:
        out = pathlib.Path(folder) / "out"
        sets = [f"--set={key}={value}" for key, value in COARSE.items()]
        command = [program, "run", scenario, "-o", str(out), "--quiet", "--device", "serial", *sets]
        subprocess.run(command, check=True, env={**os.environ, "REAMSIM_DATA": data})
        assert (out / "reamed.png").stat().st_size > 0


main()
