# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""oclgrind.py OCLGRIND REAMSIM SCENARIO KERNELS ENGINE...: the kernels neither race nor read or write astray.

Runs the scenario on oclgrind, a simulator of an OpenCL device that interprets kernels and watches every access, for each
engine, given as NAME or as NAME:key=value,... with further settings (tuning.NAME=value: REAMSIM_ENGINE_TUNING). Results have to equal those of the serial engine.
With ENGINE --planted a defect is planted in a copy of KERNELS instead, and oclgrind has to find it. With --windows before the engines
the scenario must have windows of smooth motion.
"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

DEVICE = "Oclgrind Simulator"
COMPLAINT = re.compile(r"data race|invalid (read|write|memory)|uninitialized|out of bounds|divergence", re.IGNORECASE)
# What to plant: the kernel's file, a passage of it, what takes its place, and what oclgrind has to say.
PLANTED = {
    "race": ("dense.cl", "atomic_inc(&contact_count[substep])", "(contact_count[substep]++)", "data race"),
    "overrun": ("dense.cl", "bone[e] = AIR;", "bone[e + 100000000u] = AIR;", "Invalid write"),
}


def run(command, folder, **environment):
    env = {**os.environ, **environment}
    return subprocess.run(command, cwd=folder, env=env, capture_output=True, text=True, check=False)


def simulate(program, scenario, out, settings, folder, oclgrind=None, kernels=None, tuning=""):
    """Runs the scenario, under oclgrind where it is given. Returns what the program and what oclgrind said."""
    command = [program, "run", str(scenario), "-o", str(out), "--quiet", *(f"--set={s}" for s in settings)]
    log = pathlib.Path(folder) / "oclgrind.log"
    log.unlink(missing_ok=True)
    if oclgrind is None:
        return run([*command, "--device", "serial"], folder, REAMSIM_ENGINE_TUNING=tuning), ""
    # --uninitialized is of no use: oclgrind does not count clEnqueueFillBuffer as a write.
    # Unoptimised: it does not know all that the optimiser makes of vectors and structs.
    watch = [oclgrind, "--data-races", "--build-options", "-cl-opt-disable", "--max-errors", "20", "--log", str(log)]
    environment = {"REAMSIM_KERNEL_DIR": str(kernels)} if kernels else {}
    environment["REAMSIM_ENGINE_TUNING"] = tuning
    result = run([*watch, *command, "--device", DEVICE], folder, **environment)
    return result, log.read_text() if log.exists() else ""


def check_engine(engine, oclgrind, program, scenario, folder):
    name, _, more = engine.partition(":")
    given = [s for s in more.split(",") if s]
    tuning = " ".join(s.removeprefix("tuning.") for s in given if s.startswith("tuning."))
    settings = [f"engine.type={name}", *(s for s in given if not s.startswith("tuning."))]
    out, reference = folder / "out", folder / "serial"
    for old in (out, reference):
        shutil.rmtree(old, ignore_errors=True)
    result, log = simulate(program, scenario, out, settings, folder, oclgrind, tuning=tuning)
    assert result.returncode == 0, f"{engine}: exit status {result.returncode}\n{result.stderr}\n{log}"
    assert not COMPLAINT.search(log + result.stderr), f"{engine}: oclgrind found\n{log}{result.stderr}"
    summary = json.loads((out / "summary.json").read_text())
    assert summary["device"] == DEVICE, f"{engine}: it ran on {summary['device']}"
    assert summary["contact_frames"] > 1, f"{engine}: too little contact to say anything"
    result, _ = simulate(program, scenario, reference, settings, folder)
    assert result.returncode == 0, f"{engine}: serial: {result.stderr}"
    same = (out / "forces.csv").read_bytes() == (reference / "forces.csv").read_bytes()
    assert same, f"{engine}: forces.csv differs from the serial engine's"
    print(f"{engine}: clean; {summary['tool']['shell_points']} points, {summary['frames']} frames")


def check_windows(program, scenario, folder):
    """Without windows the last digits of forces differ."""
    for windows in ("true", "false"):
        simulate(program, scenario, folder / windows, [], folder, tuning=f"windows={windows}")
    assert (folder / "true/forces.csv").read_bytes() != (folder / "false/forces.csv").read_bytes(), "no window of smooth motion"


def check_planted(oclgrind, program, scenario, kernels, folder):
    for name, (file, passage, defect, complaint) in PLANTED.items():
        planted = folder / name
        shutil.copytree(kernels, planted)
        source = (planted / file).read_text()
        assert passage in source, f"{file} has no passage {passage}"
        (planted / file).write_text(source.replace(passage, defect))
        settings = ["engine.type=direct"]
        result, log = simulate(program, scenario, folder / f"out_{name}", settings, folder, oclgrind, planted)
        found = log + result.stderr
        assert complaint in found and COMPLAINT.search(found), f"oclgrind did not find the {name}:\n{found}"
        print(f"{name}: found")


def main():
    oclgrind, program, scenario, kernels, *engines = sys.argv[1:]
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if engines == ["--planted"]:
            check_planted(oclgrind, program, scenario, kernels, folder)
            return
        if engines[0] == "--windows":
            check_windows(program, scenario, folder)
            engines.pop(0)
        for engine in engines:
            check_engine(engine, oclgrind, program, scenario, folder)


main()
