"""determinism.py REAMSIM SCENARIO: the same scenario gives the same bytes and grids, whatever runs it."""

import os
import pathlib
import subprocess
import sys
import tempfile

import grids


def run(program, scenario, out, threads="2", **settings):
    sets = [f"--set={key.replace('__', '.')}={value}" for key, value in settings.items()]
    command = [program, "run", scenario, "-o", str(out), "--quiet", "--set=render.enabled=false", *sets]
    subprocess.run(command, check=True, env={**os.environ, "POCL_MAX_PTHREAD_COUNT": threads})
    return (out / "forces.csv").read_bytes(), grids.read(str(out / "reamed.vdb"))


def check(program, scenario, erosion, detectors):
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        forces, reference = run(program, scenario, root / "reference", cutting__erosion=erosion)
        assert forces.count(b"\n") > 100
        runs = [(f"repeat{i}", {}) for i in range(4)]
        runs += [(f"threads{t}_group{g}", {"threads": t, "engine__work_group_size": g}) for t in "12" for g in (16, 100, 256)]
        runs += [(f"batch{n}", {"engine__batch_frames": n}) for n in (1, 10, 1000)]
        runs += [("gpu_shape", {"engine__kernel_shape": "gpu"}), ("unculled", {"engine__culling": "false"})]
        runs += [(detector, {"engine__detector": detector}) for detector in detectors]
        runs += [("serial", {"engine__device": "serial"})]
        for name, settings in runs:
            again, found = run(program, scenario, root / name, cutting__erosion=erosion, **settings)
            assert again == forces, f"{erosion}, {name}: forces.csv differs"
            for grid in grids.UNITS:
                assert grids.same(reference[grid], found[grid]), f"{erosion}, {name}: grid {grid} differs"


check(*sys.argv[1:3], "exact", [])
check(*sys.argv[1:3], "remove", ["direct", "octree"])
