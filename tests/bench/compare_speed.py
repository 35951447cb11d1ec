# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""compare_speed.py OLD NEW [ROUNDS] [--scenario FILE] [--set KEY=VALUE]...: two builds of reamsim side by side on a
scenario (default: frozen.yaml).

Runs both programs in turn and prints medians of the simulation time, their ratio round by round (which noise of the
machine shifts least), and memory. It asserts nothing.
"""

import argparse
import json
import pathlib
import statistics
import subprocess
import tempfile

SCENARIO = pathlib.Path(__file__).with_name("frozen.yaml")


def run(program, options, out):
    keys = [text for value in options.set for text in ("--set", value)]
    command = [program, "run", str(options.scenario), "-o", str(out), "--quiet", "--overwrite"]
    subprocess.run(command + keys, check=True)
    return json.loads((out / "summary.json").read_text())


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("old")
    parser.add_argument("new")
    parser.add_argument("rounds", type=int, nargs="?", default=7)
    parser.add_argument("--scenario", type=pathlib.Path, default=SCENARIO)
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    options = parser.parse_args()
    programs, rounds = (options.old, options.new), options.rounds
    seconds = [[], []]
    memory = [{}, {}]
    with tempfile.TemporaryDirectory() as folder:
        for turn in range(rounds):
            for i in (0, 1) if turn % 2 == 0 else (1, 0):
                summary = run(programs[i], options, pathlib.Path(folder) / f"out{i}")
                seconds[i].append(summary["timings_s"]["simulate"])
                memory[i] = summary["memory_mb"]
    for program, times, used in zip(programs, seconds, memory):
        print(f"{program}: simulate {statistics.median(times):.3f} s (median of {rounds}); memory {used}")
    ratios = sorted(new / old for old, new in zip(*seconds))
    print(f"new/old: median {statistics.median(ratios):.3f}, from {ratios[0]:.3f} to {ratios[-1]:.3f}")


main()
