#!/usr/bin/python3
# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""What a user waits for: user_waits.py REAMSIM [OLD] [--repeats N]

Prints a table of wall time and processor time (medians) of the commands below: the first time on a bone, with an empty
store of bones and compiled kernels, and again. With OLD, another reamsim, its figures too, measured alternately, and
the ratios. Needs REAMSIM_DATA for the rows of a CT. Run it on an idle machine; it is no test.
"""

import argparse
import os
import resource
import shutil
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

TRAJECTORIES = Path(__file__).resolve().parents[2] / "trajectories"
WITHOUT_PICTURES = ["--set", "render.enabled=false", "--set", "output.vti=false", "--set", "output.meshes=false"]


def rows(data):
    """Name of a row and its arguments; "OUT" is a folder that does not exist."""
    for name in ["default"] + (["ct_shoulder", "mesh_scapula"] if data else []):
        scenario = str(TRAJECTORIES / f"{name}.yaml")
        yield f"run {name}", ["run", scenario, "-o", "OUT", "--quiet"]
        yield f"run {name}, no pictures, VTI or meshes", ["run", scenario, "-o", "OUT", "--quiet", *WITHOUT_PICTURES]
        yield f"check {name}", ["check", scenario]
        yield f"run {name} --draft", ["run", scenario, "-o", "OUT", "--quiet", "--draft"]
    if data:
        ct = f"{data}/shoulder_ct/shoulder_left.nrrd"
        yield "init CT", ["init", ct, "--side", "left", "-o", "OUT.yaml"]
        yield "preview CT", ["preview", ct, "-o", "OUT.html"]


def seconds(program, arguments, cache, folder):
    """Wall time and processor time of a command."""
    out = Path(tempfile.mkdtemp(dir=folder)) / "out"
    command = [program] + [text.replace("OUT", str(out)) for text in arguments]
    environment = {**os.environ, "XDG_CACHE_HOME": cache}
    for variable in ("POCL_CACHE_DIR", "MESA_SHADER_CACHE_DIR"):  # compiled kernels and shaders stay
        environment[variable] = f"{folder}/{variable}"
        os.makedirs(environment[variable], exist_ok=True)
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    begin = time.monotonic()
    done = subprocess.run(command, env=environment, capture_output=True, text=True)
    wall_s = time.monotonic() - begin
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(command)}: exit status {done.returncode}: {done.stderr}")
    shutil.rmtree(out.parent)
    return wall_s, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measure(programs, arguments, repeats, folder):
    """By program and turn (first, again): the medians of wall and processor time."""
    found = {}
    for program in programs:
        seconds(program, arguments, tempfile.mkdtemp(dir=folder), folder)  # compiles kernels
    for _ in range(repeats):
        for program in programs:
            cache = tempfile.mkdtemp(dir=folder)
            for turn in ("first", "again"):
                found.setdefault((program, turn), []).append(seconds(program, arguments, cache, folder))
    return {key: [statistics.median(each) for each in zip(*times)] for key, times in found.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("program")
    parser.add_argument("old", nargs="?")
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    programs = [options.program] + ([options.old] if options.old else [])
    print("| command | turn | wall, s | processor, s |" + (" old wall, s | ratio |" if options.old else ""))
    print("|---|---|---|---|" + ("---|---|" if options.old else ""))
    with tempfile.TemporaryDirectory() as folder:
        for name, arguments in rows(os.environ.get("REAMSIM_DATA")):
            old = options.old if "--draft" not in arguments else None
            times = measure(programs if old else programs[:1], arguments, options.repeats, folder)
            for turn in ("first", "again"):
                wall_s, processor_s = times[options.program, turn]
                line = f"| `{name}` | {turn} | {wall_s:.2f} | {processor_s:.2f} |"
                if old:
                    line += f" {times[old, turn][0]:.2f} | {wall_s / times[old, turn][0]:.2f} |"
                print(line, flush=True)


if __name__ == "__main__":
    main()
