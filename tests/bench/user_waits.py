#!/usr/bin/python3
# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""What a user waits for: user_waits.py REAMSIM [OLD] [--repeats N] [--store]

Prints a table of wall time and processor time (medians) of the commands below: the first time on a bone, with an empty
store of bones and compiled kernels, and again; then peak memory, MB, and the ratio of the wall time to that in
user_waits.json, which --store replaces. With OLD, another reamsim, its figures too, measured alternately, and the
ratios. Needs REAMSIM_DATA for the rows of a CT. Run it on an idle machine; it is no test.
"""

import argparse
import json
import os
import shutil
import statistics
import subprocess
import tempfile
import time
from pathlib import Path

STORED = Path(__file__).with_suffix(".json")
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
    """Wall time, processor time and peak memory, MB, of a command."""
    out = Path(tempfile.mkdtemp(dir=folder)) / "out"
    command = [program] + [text.replace("OUT", str(out)) for text in arguments]
    environment = {**os.environ, "XDG_CACHE_HOME": cache}
    for variable in ("POCL_CACHE_DIR", "MESA_SHADER_CACHE_DIR"):  # compiled kernels and shaders stay
        environment[variable] = f"{folder}/{variable}"
        os.makedirs(environment[variable], exist_ok=True)
    begin = time.monotonic()
    with tempfile.TemporaryFile("w+") as errors:
        process = subprocess.Popen(command, env=environment, stdout=subprocess.DEVNULL, stderr=errors)
        _, status, used = os.wait4(process.pid, 0)
        wall_s = time.monotonic() - begin
        process.returncode = os.waitstatus_to_exitcode(status)
        if process.returncode != 0:
            errors.seek(0)
            raise SystemExit(f"{' '.join(command)}: exit status {process.returncode}: {errors.read()}")
    shutil.rmtree(out.parent)
    return wall_s, used.ru_utime + used.ru_stime, used.ru_maxrss / 1000


def measure(programs, arguments, repeats, folder):
    """By program and turn (first, again): the medians of seconds()."""
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
    parser.add_argument("--store", action="store_true")
    options = parser.parse_args()
    programs = [options.program] + ([options.old] if options.old else [])
    stored = json.loads(STORED.read_text()) if STORED.exists() else {}
    measured = {}
    print("| command | turn | wall, s | processor, s | peak, MB | of stored |" + (" old wall, s | ratio |" if options.old else ""))
    print("|---|---|---|---|---|---|" + ("---|---|" if options.old else ""))
    with tempfile.TemporaryDirectory() as folder:
        for name, arguments in rows(os.environ.get("REAMSIM_DATA")):
            old = options.old if "--draft" not in arguments else None
            times = measure(programs if old else programs[:1], arguments, options.repeats, folder)
            for turn in ("first", "again"):
                wall_s, processor_s, peak_mb = times[options.program, turn]
                measured[f"{name}, {turn}"] = round(wall_s, 2)
                before = stored.get(f"{name}, {turn}")
                ratio = f"{wall_s / before:.2f}" if before else "none"
                line = f"| `{name}` | {turn} | {wall_s:.2f} | {processor_s:.2f} | {peak_mb:.0f} | {ratio} |"
                if old:
                    line += f" {times[old, turn][0]:.2f} | {wall_s / times[old, turn][0]:.2f} |"
                print(line, flush=True)
    if options.store:
        STORED.write_text(json.dumps(measured, indent=1) + "\n")


if __name__ == "__main__":
    main()
