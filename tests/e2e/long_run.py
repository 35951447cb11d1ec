# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""long_run.py REAMSIM SCENARIO growth|ten_million|ten_million_rows: memory of long runs.

growth: a run of 200,000 frames needs hardly more memory than one of 50,000.
ten_million: keyframes; the peak memory, the time after the simulation, and the estimate of `check`.
ten_million_rows: the same motion as a recorded CSV, whose rows are held in memory.

The last two take many minutes. They exit with 77 (skipped) unless REAMSIM_LONG_TESTS is set.
"""

import json
import os
import pathlib
import re
import resource
import subprocess
import sys
import tempfile
import time

SKIPPED = 77
SCENARIO_S = 10_000  # duration of the scenario
# 150,000 frames more, of which both runs hold the same number: 130 bytes a frame.
MOST_GROWTH_MB = 20
MOST_PEAK_MB = 500
ROWS_MB = 2000  # of ten million rows, while their vector grows
ESTIMATE = 0.2


def run(program, scenario, folder, rate_hz, *more):
    out = pathlib.Path(folder) / f"out-{rate_hz}"
    command = [program, "run", scenario, "-o", str(out), "--quiet", "--set", f"motion.frame_rate_hz={rate_hz}", *more]
    began_s = time.monotonic()
    subprocess.run(command, check=True)
    wall_s = time.monotonic() - began_s
    summary = json.loads((out / "summary.json").read_text())
    # The largest child so far, such as gnuplot or the program itself.
    children_mb = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss * 1024 / 1e6
    print(f"{summary['frames']} frames: {summary['memory_mb']}, largest child {children_mb:.0f} MB, "
          f"{summary['timings_s']}, all {wall_s:.0f} s", flush=True)
    summary["after_s"] = wall_s - summary["timings_s"]["load"] - summary["timings_s"]["simulate"]
    return summary, max(children_mb, summary["memory_mb"]["peak_process"])


def growth(program, scenario, folder):
    shorter, longer = (run(program, scenario, folder, rate_hz, "--set=output.plots=false")[0] for rate_hz in (5, 20))
    assert longer["frames"] == 20 * SCENARIO_S + 1, longer["frames"]
    grown_mb = longer["memory_mb"]["peak_process"] - shorter["memory_mb"]["peak_process"]
    print(f"{grown_mb:.1f} MB for 150,000 frames more")
    assert grown_mb < MOST_GROWTH_MB, grown_mb


def estimate_mb(program, scenario, *more):
    found = subprocess.run([program, "check", scenario, *more], check=True, capture_output=True, text=True).stdout
    return float(re.search(r"# memory: .* up to (\d+) MB in total", found)[1])


def judge(program, scenario, folder, *more, rows_mb=0):
    without = ["--set", "render.enabled=false", "--set", "output.meshes=false", *more]
    estimated_mb = estimate_mb(program, scenario, *without)
    summary, peak_mb = run(program, scenario, folder, 1000, *more)
    assert peak_mb < MOST_PEAK_MB + rows_mb, peak_mb
    assert summary["after_s"] <= summary["timings_s"]["simulate"], summary["timings_s"]
    plain, _ = run(program, scenario, pathlib.Path(folder) / "plain", 1000, *without)
    measured_mb = plain["memory_mb"]["peak_process"]
    print(f"estimate {estimated_mb} MB, measured {measured_mb} MB")
    assert abs(estimated_mb / measured_mb - 1) < ESTIMATE


def recorded(path):
    """The motion of the scenario's first keyframes, as rows at about 1 kHz."""
    with open(path, "w", encoding="utf-8") as csv:
        csv.write("time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz,spin_rpm\n")
        rows = SCENARIO_S * 1000
        for i in range(rows):
            t = i / rows
            csv.write(f"{i / 1000:.3f},{0.1 + 0.3 * t:.7f},0.2,{1 - 4 * t * (1 - t) * 2:.7f},1,0.01,0.02,0,250\n")


def main():
    program, scenario, what = sys.argv[1:]
    if what != "growth" and not os.environ.get("REAMSIM_LONG_TESTS"):
        print("skipped: takes many minutes; set REAMSIM_LONG_TESTS=1")
        sys.exit(SKIPPED)
    with tempfile.TemporaryDirectory() as folder:
        if what == "growth":
            growth(program, scenario, folder)
        elif what == "ten_million":
            judge(program, scenario, folder)
        else:
            poses = pathlib.Path(folder) / "poses.csv"
            recorded(poses)
            judge(program, scenario, folder, "--set", "motion.keyframes=null", "--set", f"motion.csv.path={poses}", rows_mb=ROWS_MB)


main()
