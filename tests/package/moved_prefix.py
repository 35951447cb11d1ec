# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""moved_prefix.py REAMSIM BUILD ROOT: what `cmake --install` puts below a prefix works after the prefix was moved, without the
checkout: shipped scenarios by name, their reamers, the Python package."""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

QUICK = ["--device", "serial", "--set", "bone.voxel_mm=1", "--set", "motion.plunge.feed_mm_s=5", "--set",
         "motion.frame_rate_hz=50", "--set", "render.width_px=96", "--set", "render.height_px=64"]
PYTHON = """
import reamsim
print(reamsim.find_program())
print(reamsim.run("half_space", "from python", device="serial", bone__voxel_mm=1, motion__frame_rate_hz=50,
                  motion__plunge__feed_mm_s=5, render__enabled=False).summary["removed_mm3"])
print(reamsim.Simulation("half_space", device="serial", bone__voxel_mm=1, motion__frame_rate_hz=50).frame_s)
"""


class Installed:
    def __init__(self, folder):
        self.folder = folder
        self.work = folder / "work"
        self.work.mkdir()
        keep = {name: value for name, value in os.environ.items() if not name.startswith(("REAMSIM", "PYTHON"))}
        self.environment = {**keep, "HOME": str(folder / "home")}
        for component in ("program", "python"):
            subprocess.run(["cmake", "--install", BUILD, "--prefix", folder / "first", "--component", component, "--strip"],
                           check=True, stdout=subprocess.DEVNULL)
        self.prefix = folder / "moved to/a place"
        self.prefix.parent.mkdir()
        (folder / "first").rename(self.prefix)

    def call(self, *arguments, status=0, program=None, **environment):
        done = subprocess.run([program or self.prefix / "bin/reamsim", *arguments], cwd=self.work, capture_output=True, text=True,
                              env={**self.environment, **environment})
        assert done.returncode == status, f"{arguments}\n{done.stdout}{done.stderr}"
        return done.stdout + done.stderr


def check_run(installed):
    installed.call("run", "half_space", *QUICK)
    results = installed.work / "out/half_space"
    forces = (results / "forces.csv").read_bytes()
    assert (results / "reamed.png").stat().st_size > 1000
    assert f"{installed.prefix}/share/reamsim/assets/reamer_convex.stl" in (results / "scenario.yaml").read_text()
    for path in results.rglob("*"):  # where it was built or first installed is not in the results
        if path.is_file():
            text = path.read_bytes()
            assert str(installed.folder / "first").encode() not in text and str(ROOT).encode() not in text, path
    installed.call("run", ROOT / "trajectories/half_space.yaml", *QUICK, "--set", "render.enabled=false", "--set",
                   "output.meshes=false", "-o", "of the build", program=PROGRAM)
    assert (installed.work / "of the build/forces.csv").read_bytes() == forces
    return len(forces)


def check_names(installed):
    message = installed.call("run", "nonsense", status=2)
    listed = re.search(r"one of (.*)", message)[1].split(", ")
    assert listed == sorted(path.stem for path in (ROOT / "trajectories").glob("*.yaml")), listed
    installed.call("sweep", "submit", "reamers", "--parallel", "--to", "scripts")
    script = (installed.work / "scripts/reamers.parallel.sh").read_text()
    assert f"{installed.prefix}/share/reamsim/trajectories/studies/reamers.yaml" in script
    assert "frames" in installed.call("check", "several_passes", "--set", "bone.voxel_mm=1")


def check_statistics(installed):
    """They are computed by the program's own copy of the Python package."""
    (installed.work / "u.yaml").write_text(
        "version: 1\nbase: half_space\nset: {bone.voxel_mm: 1, motion.plunge.feed_mm_s: 5, motion.frame_rate_hz: 50, "
        "engine.device: serial}\nsample: {n: 4, of: {cutting.normal_ratio: {uniform: [0.4, 0.6]}}}\n")
    assert "cutting.normal_ratio (" in installed.call("uq", "u.yaml", "-o", "uq", PYTHONPATH="/nowhere")
    assert (installed.work / "uq/uq.png").stat().st_size > 1000
    assert not list(installed.prefix.rglob("__pycache__")), "a run writes nothing into the prefix"


def check_python(installed):
    (package,) = installed.prefix.glob("lib/python3*/dist-packages")
    said = installed.call("-c", PYTHON, program="/usr/bin/python3", PYTHONPATH=str(package)).splitlines()
    assert said[0] == str(installed.prefix / "bin/reamsim"), said
    assert float(said[1]) > 50, said
    assert float(said[2]) == 0.02, said


PROGRAM, BUILD, ROOT = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])
with tempfile.TemporaryDirectory() as temporary:
    place = Installed(pathlib.Path(temporary).resolve())
    size = check_run(place)
    check_names(place)
    check_statistics(place)
    check_python(place)
print(f"forces.csv of {size} bytes from a moved prefix and from the build")
