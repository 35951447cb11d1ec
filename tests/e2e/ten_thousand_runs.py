# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""ten_thousand_runs.py REAMSIM ROOT [RUNS]: a study of ten thousand runs of a small block, without pictures, one of which
fails: the rate, and what `collect` takes. The figures of docs/studies.md."""

import csv
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import time

JOBS = 2
LEAST_RUNS_PER_S = 20  # on two processors that nothing else uses
MOST_COLLECT_MB = 400


def write_study(folder, root, runs):
    """Depth and specific energy are drawn; the run in the middle has a depth that is no number."""
    rng = random.Random(1)
    rows = [["label", "motion.plunge.depth_mm", "cutting.specific_energy_j_mm3"]]
    rows += [[f"R{i}", f"{rng.uniform(0.5, 1.5):.6f}", f"{rng.lognormvariate(-1.9, 0.3):.6f}"] for i in range(runs)]
    rows[runs // 2][1] = "deep"
    with (folder / "cohort.csv").open("w", newline="") as out:
        csv.writer(out).writerows(rows)
    base = root / "tests/e2e/ten_thousand_runs.yaml"
    (folder / "study.yaml").write_text(f"version: 1\nbase: {base}\ntable: cohort.csv\nkeep: [summary]\n")


def timed(*command):
    """Runs a command; returns its exit status, its seconds and its output."""
    begin = time.monotonic()
    result = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    return result.returncode, time.monotonic() - begin, result.stdout + result.stderr


def peak_mb(*command):
    """The peak memory of a command."""
    process = subprocess.Popen([str(word) for word in command], stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    assert os.waitstatus_to_exitcode(status) == 0, status
    return usage.ru_maxrss / 1000


def main():
    program, root = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2]).resolve()
    runs = int(sys.argv[3]) if len(sys.argv) > 3 else 10_000
    with tempfile.TemporaryDirectory(prefix="reamsim-") as name:
        folder = pathlib.Path(name)
        write_study(folder, root, runs)
        study, out = folder / "study.yaml", folder / "out"
        timed(program, "sweep", "run", study, "--shard", "1/1000", "-o", folder / "first")  # compiles the kernels
        status, run_s, text = timed(program, "sweep", "run", study, "--jobs", JOBS, "-o", out)
        assert status == 1 and "1 runs failed" in text, text
        print(f"{runs} runs, --jobs {JOBS}: {run_s:.0f} s with the table, {runs / run_s:.1f} runs/s")
        before = (out / "runs.csv").read_bytes()
        status, collect_s, text = timed(program, "sweep", "collect", study, "-o", out)
        assert status == 0, text
        peak = peak_mb(program, "sweep", "collect", study, "-o", out)
        print(f"collect: {collect_s:.1f} s, {peak:.0f} MB; runs.csv {len(before) / 1e6:.1f} MB, "
              f"sweep.html {(out / 'sweep.html').stat().st_size / 1e6:.1f} MB")
        assert (out / "runs.csv").read_bytes() == before
        with (out / "runs.csv").open(newline="") as table:
            rows = list(csv.DictReader(table))
        assert len(rows) == runs
        failed = [row for row in rows if row["status"] != "done"]
        assert [row["run"] for row in failed] == [str(runs // 2)] and "deep" in failed[0]["message"], failed
        assert peak < MOST_COLLECT_MB
        assert runs / run_s >= LEAST_RUNS_PER_S or runs < 10_000, "less than 20 runs/s: is the machine free?"
    print("passed")


main()
