"""compare_speed.py OLD NEW [ROUNDS]: two builds of reamsim side by side on frozen.yaml.

Runs both programs in turn and prints medians of the simulation time, their ratio round by round (which noise of the
machine shifts least), and memory. It asserts nothing.
"""

import json
import pathlib
import statistics
import subprocess
import sys
import tempfile

SCENARIO = pathlib.Path(__file__).with_name("frozen.yaml")


def run(program, out):
    subprocess.run([program, "run", str(SCENARIO), "-o", str(out), "--quiet", "--overwrite"], check=True)
    return json.loads((out / "summary.json").read_text())


def main():
    programs = sys.argv[1:3]
    rounds = int(sys.argv[3]) if len(sys.argv) > 3 else 7
    seconds = [[], []]
    memory = [{}, {}]
    with tempfile.TemporaryDirectory() as folder:
        for turn in range(rounds):
            for i in (0, 1) if turn % 2 == 0 else (1, 0):
                summary = run(programs[i], pathlib.Path(folder) / f"out{i}")
                seconds[i].append(summary["timings_s"]["simulate"])
                memory[i] = summary["memory_mb"]
    for program, times, used in zip(programs, seconds, memory):
        print(f"{program}: simulate {statistics.median(times):.3f} s (median of {rounds}); memory {used}")
    ratios = sorted(new / old for old, new in zip(*seconds))
    print(f"new/old: median {statistics.median(ratios):.3f}, from {ratios[0]:.3f} to {ratios[-1]:.3f}")


main()
