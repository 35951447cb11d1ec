# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""same_bytes.py REAMSIM ROOT [--targets | --renew]: a scenario gives the same forces.csv and the same grids on every release of Debian,
with every compiler, and on every instruction set of the processor.

Compares the SHA-256 sums of each case with those in same_bytes.json. --targets: PoCL compiles the kernels for the instruction
sets of TARGETS in turn, those that this processor has. --renew: writes the sums of this program into same_bytes.json, for a
change that is meant to change forces."""

import hashlib
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy

import grids
import real_data

EXPECTED = pathlib.Path(__file__).with_name("same_bytes.json")
# Two as they ship, the others coarse and short: every byte depends on the same code, and paper.numbers and docs.reference_long compare
# numbers of these scenarios as they ship.
SHORT = ["bone.voxel_mm=0.5", "motion.frame_rate_hz=250"]
CASES = {
    "default": ("default", []),
    "ct_shoulder": ("ct_shoulder", []),
    "half_space": ("half_space", SHORT),
    "cutting_edges": ("default", [*SHORT, "motion.plunge.depth_mm=0.8", "tool.mesh={root}/assets/reamer_convex_edges.stl", "tool.spin=resolved"]),
    "remove": ("half_space", [*SHORT, "cutting.erosion=remove"]),
    "push": ("push", [*SHORT, "motion.push.depth_mm=0.5"]),
    "compliance": ("compliance", [*SHORT, "motion.plunge.depth_mm=0.8"]),
}
# PoCL's names of a processor and of its built-in library, and the flag of /proc/cpuinfo that it needs.
TARGETS = {
    "SSE2": ("x86-64", "sse2", "sse2"),
    "AVX2": ("haswell", "avx2", "avx2"),
    "AVX-512": ("skylake-avx512", "avx512", "avx512f"),
}


def sums_of(results):
    """SHA-256 of forces.csv, and of the values of each grid on its whole lattice."""
    sums = {"forces.csv": hashlib.sha256((results / "forces.csv").read_bytes()).hexdigest()}
    for name, grid in grids.read(str(results / "reamed.vdb")).items():
        low, high = grid.evalActiveVoxelBoundingBox()
        values = numpy.empty(tuple(b - a + 1 for a, b in zip(low, high)), dtype=numpy.float32)
        grid.copyToArray(values, ijk=low)
        sums[name] = hashlib.sha256(repr((low, high)).encode() + values.tobytes()).hexdigest()
    return sums


def run(program, root, case, environment):
    scenario, settings = CASES[case]
    with tempfile.TemporaryDirectory() as folder:
        sets = [f"--set={one.format(root=root)}" for one in [*settings, "render.enabled=false", "output.meshes=false", "output.vti=false", "output.plots=false"]]
        subprocess.run([program, "run", root / f"trajectories/{scenario}.yaml", "-o", f"{folder}/out", "--quiet", *sets], check=True,
                       env={**os.environ, **environment})
        return sums_of(pathlib.Path(folder, "out"))


def runnable(root):
    """The cases whose data are here."""
    try:
        real_data.require(root / "trajectories/ct_shoulder.yaml")
        return list(CASES)
    except SystemExit:
        return [case for case in CASES if case != "ct_shoulder"]


def environments(targets):
    if not targets:
        return {"this processor": {}}
    flags = pathlib.Path("/proc/cpuinfo").read_text().split()
    for name, (_, _, flag) in TARGETS.items():
        if flag not in flags:
            print(f"{name}: this processor has none")
    return {name: {"POCL_LLVM_CPU_NAME": cpu, "POCL_KERNELLIB_NAME": f"kernel-x86_64-pc-linux-gnu-{library}"}
            for name, (cpu, library, flag) in TARGETS.items() if flag in flags}


def main():
    program, root, *options = sys.argv[1:]
    root = pathlib.Path(root).resolve()
    expected = json.loads(EXPECTED.read_text()) if EXPECTED.exists() else {}
    different = []
    for target, environment in environments("--targets" in options).items():
        for case in runnable(root):
            with tempfile.TemporaryDirectory() as kernels:
                found = run(program, root, case, {"POCL_CACHE_DIR": kernels, **environment} if environment else {})
            if "--renew" in options:
                expected[case] = found
            for name, value in found.items():
                print(f"{target:15} {case:15} {name:15} {value} {'' if value == expected[case][name] else 'DIFFERS'}", flush=True)
            different += [f"{target}, {case}: {name}" for name, value in found.items() if value != expected[case][name]]
    if "--renew" in options:
        EXPECTED.write_text(json.dumps(expected, indent=1) + "\n")
    assert not different, f"other bytes than in {EXPECTED.name}: {', '.join(different)}"


main()
