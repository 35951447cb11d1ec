# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""render_neutral.py REAMSIM SCENARIO: pictures or none, of any size and number, change neither forces.csv nor reamed.vdb."""

import pathlib
import subprocess
import sys
import tempfile

import grids

WAYS = {
    "upright": {"width_px": 333, "height_px": 777, "cameras": "[overview]", "supersampling": 2, "every_frames": 100000,
                "background": "transparent", "report": "false"},
    "many": {"width_px": 96, "height_px": 64, "every_frames": 70, "cameras": "[section]", "report": "false"},
    "film": {"width_px": 160, "height_px": 100, "every_frames": 100, "film": "webp", "turntable_pictures": 3, "tool": "false"},
}


def run(program, scenario, out, settings):
    sets = [f"--set=render.{key}={value}" for key, value in settings.items()]
    subprocess.run([program, "run", scenario, "-o", str(out), "--quiet", *sets], check=True)
    path = str(out / "reamed.vdb")
    found = grids.read(path)
    metadata = [grids.vdb.readMetadata(path), *(grid.metadata for grid in found.values())]
    return (out / "forces.csv").read_bytes(), found, metadata


def main():
    program, scenario = sys.argv[1:]
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        forces, reference, metadata = run(program, scenario, root / "none", {"enabled": "false"})
        assert forces.count(b"\n") > 100
        assert len(metadata[0]) > 5, metadata[0]
        for name, settings in WAYS.items():
            again, found, found_metadata = run(program, scenario, root / name, {"enabled": "true", **settings})
            assert (root / name / "reamed.png").exists(), name
            assert again == forces, f"{name}: forces.csv differs"
            assert found_metadata == metadata, f"{name}: {found_metadata} instead of {metadata}"
            for grid in grids.UNITS:
                assert grids.same(reference[grid], found[grid]), f"{name}: grid {grid} differs"


main()
