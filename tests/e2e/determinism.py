# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""determinism.py REAMSIM SCENARIO BLOCK EROSION [--full]: the same scenario gives the same bytes and grids, whatever runs it.

The block, which is the smaller one, in every way; the scenario in the ways that differ most. Without --full the block is
repeated twice, not four times, and each size of work-groups is tried with one number of threads, not with both.
"""

import os
import pathlib
import subprocess
import sys
import tempfile

import grids


def run(program, scenario, out, threads="2", tuning="", **settings):
    sets = [f"--set={key.replace('__', '.')}={value}" for key, value in settings.items()]
    command = [program, "run", scenario, "-o", str(out), "--quiet", "--set=render.enabled=false", "--set=output.meshes=false",
               "--set=output.vti=false", "--set=output.plots=false", *sets]
    subprocess.run(command, check=True, env={**os.environ, "POCL_MAX_PTHREAD_COUNT": threads, "REAMSIM_ENGINE_TUNING": tuning})
    return (out / "forces.csv").read_bytes(), grids.read(str(out / "reamed.vdb"))


def every_way(engines, full):
    ways = {f"repeat{i}": {} for i in range(4 if full else 2)}
    pairs = [(t, g) for t in "12" for g in (16, 100, 256)] if full else [("1", 100), ("2", 16), ("2", 256)]
    ways |= {f"threads{t}_group{g}": {"threads": t, "tuning": f"work_group_size={g}"} for t, g in pairs}
    ways |= {f"batch{n}": {"engine__batch_frames": n} for n in (1, 10, 1000)}
    ways |= {"gpu_shape": {"tuning": "kernel_shape=gpu"}, "unculled": {"tuning": "culling=false"}}
    ways |= {engine: {"engine__type": engine} for engine in engines}
    return ways | {"serial": {"engine__device": "serial"}}


def check(program, scenario, erosion, ways):
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        forces, reference = run(program, scenario, root / "reference", cutting__erosion=erosion)
        assert forces.count(b"\n") > 100
        assert any(float(row.split(b",")[20]) > 0 for row in forces.splitlines()[1:]), "the tool cuts nothing"
        for name, settings in ways.items():
            again, found = run(program, scenario, root / name, cutting__erosion=erosion, **settings)
            assert again == forces, f"{scenario}, {erosion}, {name}: forces.csv differs"
            for grid in grids.UNITS:
                assert grids.same(reference[grid], found[grid]), f"{scenario}, {erosion}, {name}: grid {grid} differs"


def main():
    program, scenario, block, erosion, *options = sys.argv[1:]
    ways = every_way(["direct", "octree"] if erosion == "remove" else [], "--full" in options)
    check(program, block, erosion, ways)
    check(program, scenario, erosion, {name: ways[name] for name in ("threads1_group100", "serial")})


main()
