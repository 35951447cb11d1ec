# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""batch_systems.py slurm|snakemake|parallel REAMSIM ROOT: the study of 36 runs, submitted in 4 shards, has the table of
a plain `sweep run`. `measure` prints the times of docs/cluster.md instead.

With Slurm, one array task is killed and requeued, and one meets its time limit and is requeued from its checkpoints.
Snakemake submits to Slurm, and one of its jobs is cancelled."""

import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import time

import local_slurm
from local_slurm import call, squeue, wait_until

SHARDS = 4
CPUS = 2
# More frames and smaller voxels make a shard take longer than a minute, so that the signal before the time limit, which
# Slurm looks for every 30 s only, comes in the middle of a run.
SHARD_S = 110
FRAMES = ["--set", "motion.frame_rate_hz=96000"]
VOXEL_MM = 0.5


class Study:
    def __init__(self, program, root, work, settings=()):
        self.program, self.work, self.settings = program, work, list(settings)
        self.file = root / "trajectories/studies/reamers.yaml"
        self.output = work / "out of shards"

    def slow_down(self):
        """Makes a shard take SHARD_S or more on this machine."""
        self.settings = FRAMES
        begin = time.monotonic()
        self.sweep("run", "--jobs", 1, "--shard", f"1/{3 * SHARDS}", "-o", self.work / "trial")
        shard_s = 3 * (time.monotonic() - begin)
        # Time grows with the voxels of the tool's surface.
        voxel_mm = round(VOXEL_MM * min(1, shard_s / SHARD_S) ** 0.5, 2)
        print(f"a shard takes {shard_s:.0f} s at {VOXEL_MM} mm: this test takes {voxel_mm} mm")
        self.settings = [*FRAMES, "--set", f"bone.voxel_mm={voxel_mm}"]

    def sweep(self, command, *more):
        return call(self.program, "sweep", command, self.file, *self.settings, *more)

    def submit(self, system, *more, shards=SHARDS):
        """The folder with the scripts, whose name needs quotes."""
        folder = self.work / f"it's scripts of {shards}"
        self.sweep("submit", f"--{system}", "--shards", shards, "-o", self.output, "--to", folder, *more)
        return folder

    def check(self):
        """Whether the shards give the table of one command."""
        begin = time.monotonic()
        self.sweep("run", "--jobs", CPUS, "-o", self.work / "plain")
        print(f"plain sweep run --jobs {CPUS}: {time.monotonic() - begin:.1f} s")
        table = (self.output / "runs.csv").read_bytes()
        assert table.count(b",done,") == 36, table.decode()[:2000]
        assert table == (self.work / "plain/runs.csv").read_bytes(), "the tables differ"


def overhead(work, tasks=20):
    """Seconds that Slurm adds to a task, from an array of empty ones."""
    script = work / "empty.sh"
    script.write_text("#!/bin/sh\n")
    begin = time.monotonic()
    call("sbatch", f"--array=1-{tasks}", "--output=/dev/null", script)
    wait_until(lambda: not squeue(), "empty tasks", 120)
    print(f"overhead of Slurm: {(time.monotonic() - begin) / tasks * CPUS:.2f} s per empty array task and processor")


def finished_runs(study):
    folder = study.output / "runs"
    return [path for path in folder.iterdir() if not path.suffix] if folder.exists() else []


def kill_task(task):
    """Kills reamsim of an array task, as the kernel does where memory runs out."""
    killed = 0
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            if f"SLURM_ARRAY_TASK_ID={task}".encode() not in (process / "environ").read_bytes().split(b"\0"):
                continue
            if (process / "cmdline").read_bytes().split(b"\0")[1:2] == [b"sweep"]:
                os.kill(int(process.name), signal.SIGKILL)
                killed += 1
        except (FileNotFoundError, ProcessLookupError):
            pass  # it has ended
    assert killed > 0, "no process of the task found"


def continued(log):
    """The frames after which runs were continued, as a task's log says."""
    return [int(frame) for frame in re.findall(r"continued after frame (\d+)", log)]


def slurm(study):
    study.slow_down()
    scripts = study.submit("slurm", "--time-limit", "00:02:00")
    os.chdir(scripts)
    overhead(study.work)
    begin = time.monotonic()
    job = call("sbatch", "--parsable", "./reamers.sbatch")
    call("sbatch", f"--dependency=afterany:{job}", "./reamers.collect.sbatch")
    wait_until(lambda: squeue().get(f"{job}_1") == "RUNNING" and finished_runs(study), "the first task", 120)
    kill_task(1)
    wait_until(lambda: f"{job}_1" not in squeue(), "the end of the killed task", 60)
    state = re.search(r"JobState=\S+|$", call("scontrol", "show", "job", f"{job}_1"))[0]
    print(f"task 1 killed after {time.monotonic() - begin:.1f} s: {state}")
    assert state == "JobState=FAILED", state
    call("scontrol", "requeue", f"{job}_1")
    wait_until(lambda: not squeue(), "all tasks", 1500)
    print(f"all tasks and the table: {time.monotonic() - begin:.1f} s")
    logs = {path.name: path.read_text() for path in sorted(scripts.glob("slurm-*.out"))}
    for name, text in logs.items():
        print(f"--- {name}\n{text[-1500:]}")
    restarts = {}
    for task in range(1, SHARDS + 1):
        state = call("scontrol", "show", "job", f"{job}_{task}")
        assert "JobState=COMPLETED" in state, state
        restarts[task] = int(re.search(r"Restarts=(\d+)", state)[1])
    print(f"requeued, by task: {restarts}")
    # Task 1 was requeued by hand; the others requeue themselves.
    met = [task for task in restarts if restarts[task] > 0 and task != 1]
    assert met, "no task met its time limit"
    after = {}
    for task in met:
        log = logs[f"slurm-{job}_{task}.out"]
        assert "interrupted; the same command continues" in log, log
        after[task] = continued(log)
    print(f"continued after frame, by task: {after}")
    # The signal may find a task between two runs, but not every time.
    assert any(frame > 0 for frames in after.values() for frame in frames), "no run was continued from a checkpoint"


def snakemake(study):
    scripts = study.submit("snakemake", "--time-limit", "00:10:00")
    begin = time.monotonic()
    home = {**os.environ, "HOME": str(study.work), "XDG_CACHE_HOME": str(study.work / "cache")}
    log = study.work / "snakemake.log"
    with log.open("w") as out:
        workflow = subprocess.Popen(["snakemake", "--profile", "profile"], cwd=scripts, env=home, stdout=out, stderr=out)
    wait_until(lambda: finished_runs(study) and "RUNNING" in squeue().values(), "the first job", 120)
    cancelled = next(job for job, state in squeue().items() if state == "RUNNING")
    call("scancel", cancelled)
    status = workflow.wait()
    print(log.read_text()[-3000:])
    assert status == 0, status
    assert "Trying to restart job" in log.read_text(), "the cancelled job was not repeated"
    assert len(list(scripts.glob("slurm-*.out"))) == SHARDS + 1, "the shards were not Slurm jobs"
    print(f"Snakemake with Slurm: {time.monotonic() - begin:.1f} s")


def parallel(study):
    scripts = study.submit("parallel")
    begin = time.monotonic()
    print(call("./reamers.parallel.sh", cwd=scripts))
    print(f"GNU parallel: {time.monotonic() - begin:.1f} s")


def measure(study):
    overhead(study.work)
    for shards in (4, 12):
        study.output = study.work / f"out of {shards}"
        scripts = study.submit("slurm", shards=shards)
        begin = time.monotonic()
        call("sbatch", "./reamers.sbatch", cwd=scripts)
        wait_until(lambda: not squeue(), "all tasks", 540)
        print(f"{shards} shards on {CPUS} processors through Slurm: {time.monotonic() - begin:.1f} s")


def main():
    system, program, root = sys.argv[1], pathlib.Path(sys.argv[2]).resolve(), pathlib.Path(sys.argv[3]).resolve()
    if system == "parallel":
        local_slurm.require("parallel")
    else:
        if system == "snakemake":
            local_slurm.require("snakemake")
        local_slurm.enter()
    with tempfile.TemporaryDirectory(prefix="reamsim-") as name:
        work = pathlib.Path(name)
        study = Study(program, root, work)
        if system == "parallel":
            parallel(study)
        else:
            daemons = work / "slurm"
            daemons.mkdir()
            work.chmod(0o755)
            with local_slurm.cluster(daemons, CPUS):
                {"slurm": slurm, "snakemake": snakemake, "measure": measure}[system](study)
            os.chdir("/")
        if system != "measure":
            study.check()
    print("passed")


main()
