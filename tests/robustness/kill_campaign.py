# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Kills runs at random moments and continues them: each must end with the bytes of a run without interruption.

    kill_campaign.py REAMSIM ROOT KILLS

KILLS SIGKILLs are spread over scenarios: a phantom without pictures, one with pictures, resolved cutting edges, erosion
`remove`, and the shoulder CT where REAMSIM_DATA is set. Every kill hits a run that continues the one before. Kills come
in turn at four kinds of moments: at random, in the first 0.3 s (while the run resumes), while a checkpoint is written, and
while the results are listed and moved to their place, where an older result is replaced. Checks
after each kill: scenario.yaml present once there is a row, `reamsim render` works from
the first checkpoint on (every tenth time). At the end: the same forces.csv, grids and summary (times and memory apart).
"""

import collections
import filecmp
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

SEED = 20261123
BLOCK = """version: 2
bone:
  source: phantom
  voxel_mm: {voxel}
  phantom: {{shape: half_space, size_mm: [12, 12, 6]}}
tool: {{mesh: {root}/assets/{tool}{more_tool}}}
motion:
  frame_rate_hz: 200
  plunge: {{approach_mm: 0.3, feed_mm_s: 0.02, depth_mm: 0.6, dwell_s: 0, retract_mm: 1, retract_mm_s: 20, spin_rpm: 200}}
render: {{{render}}}
engine: {{batch_frames: 16}}
output: {{checkpoint_s: 0.1}}
{more}"""


def scenarios(root):
    block = {"root": root, "voxel": 0.2, "tool": "reamer_flat.stl", "more_tool": "", "more": "", "render": "enabled: false"}
    yield "phantom", BLOCK.format(**block)
    yield "pictures", BLOCK.format(**block | {"render": "width_px: 160, height_px: 120, every_frames: 1000"})
    teeth = {"tool": "reamer_convex_edges.stl", "more_tool": ", spin: resolved", "voxel": 0.5}
    yield "teeth", BLOCK.format(**block | teeth)
    yield "remove", BLOCK.format(**block | {"voxel": 0.4, "more": "cutting: {erosion: remove}\n"})
    if os.environ.get("REAMSIM_DATA"):
        with open(f"{root}/trajectories/ct_shoulder.yaml", encoding="utf-8") as file:
            text = file.read().replace("../assets", f"{root}/assets").replace("voxel_mm: 0.4", "voxel_mm: 0.6")
        text = text.replace("  cameras:", "  width_px: 320\n  height_px: 240\n  cameras:")
        yield "ct", text + "output: {checkpoint_s: 0.1}\n"
    else:
        print("no CT: REAMSIM_DATA is not set")


def same(a, b):
    """The first file that differs between two folders of results, or None."""
    for folder, _, files in os.walk(a):
        for name in files:
            place = os.path.relpath(os.path.join(folder, name), a)
            if name == "timings.csv" or name.endswith(".pdf"):
                continue
            if name in ("scenario.yaml", "summary.json", "report.html"):
                continue
            if not filecmp.cmp(f"{a}/{place}", f"{b}/{place}", shallow=False):
                return place
    summaries = []
    for folder in (a, b):
        with open(f"{folder}/summary.json", encoding="utf-8") as file:
            summary = json.load(file)
        summaries.append({k: v for k, v in summary.items() if k not in ("timings_s", "memory_mb")})
    return None if summaries[0] == summaries[1] else "summary.json"


class Campaign:
    def __init__(self, program, kills):
        self.program = program
        self.kills = kills
        self.random = random.Random(SEED)
        self.kinds = collections.Counter()
        self.torn = self.without_scenario = self.rendered = self.render_failures = self.done = self.tried = 0

    def run(self, arguments, kill_when=None):
        process = subprocess.Popen([self.program, *arguments, "--quiet"], stderr=subprocess.PIPE)
        begin = time.monotonic()
        while kill_when is not None and process.poll() is None:
            if kill_when(time.monotonic() - begin):
                process.send_signal(signal.SIGKILL)
                break
            time.sleep(0.0005)
        _, error = process.communicate()
        return process.returncode, error.decode()

    def moment(self, partial, seconds):
        """The next kind of moment, and a function that says whether it has come."""
        self.tried += 1  # a run may end before its moment comes
        kind = ("random", "resuming", "checkpoint", "renames")[self.tried % 4]
        after = self.random.uniform(0.05, 1.05) * seconds
        if kind == "random":
            return kind, lambda t: t > after
        if kind == "resuming":
            early = self.random.uniform(0, 0.3)
            return kind, lambda t: t > early
        if kind == "checkpoint":
            names = [f"{partial}/checkpoint-{i}.bin.tmp" for i in (0, 1)]
            return kind, lambda t: t > 0.3 * after and any(os.path.exists(name) for name in names)
        return kind, lambda t: os.path.exists(f"{partial}/manifest.json.tmp") or os.path.exists(f"{partial}/manifest.json")

    def check_partial(self, partial):
        log = f"{partial}/forces.csv"
        if not os.path.exists(log):
            return
        with open(log, "rb") as file:
            text = file.read()
        self.torn += text != b"" and not text.endswith(b"\n")
        self.without_scenario += text.count(b"\n") > 1 and not os.path.exists(f"{partial}/scenario.yaml")
        saved = any(os.path.exists(f"{partial}/checkpoint-{i}.bin") for i in (0, 1))
        if saved and self.done % 10 == 0:
            copy = partial + "_copy"
            shutil.copytree(partial, copy)
            status, error = self.run(["render", copy, "--only", "pictures", "--camera", "oblique"])
            self.rendered += 1
            self.render_failures += status != 0
            if status != 0:
                print("render:", error)
            shutil.rmtree(copy)

    def one(self, name, yaml, kills, folder):
        scenario, whole, cut = f"{folder}/{name}.yaml", f"{folder}/{name}_whole", f"{folder}/{name}_cut"
        with open(scenario, "w", encoding="utf-8") as file:
            file.write(yaml)
        begin = time.monotonic()
        status, error = self.run(["run", scenario, "-o", whole])
        assert status == 0, error
        seconds = time.monotonic() - begin
        killed = 0
        while killed < kills:
            while killed < kills:
                kind, when = self.moment(cut + ".partial", seconds)
                status, error = self.run(["run", scenario, "-o", cut, "--resume", "--overwrite"], when)
                if status == 0:
                    break
                assert status == -signal.SIGKILL, f"{name}: status {status} after a kill: {error}"
                killed += 1
                self.done += 1
                self.kinds[kind] += 1
                self.check_partial(cut + ".partial")
                assert not os.path.exists(cut) or same(whole, cut) is None, f"{name}: the older result has changed"
            if killed == kills:
                status, error = self.run(["run", scenario, "-o", cut, "--resume", "--overwrite"])
                assert status == 0, error
            different = same(whole, cut)
            assert different is None, f"{name}: {different} differs"
        print(f"{name}: {killed} kills of a run of {seconds:.1f} s, same results", flush=True)


def main():
    program, root, kills = sys.argv[1], sys.argv[2], int(sys.argv[3])
    print("seed", SEED)
    campaign = Campaign(program, kills)
    with tempfile.TemporaryDirectory(prefix="reamsim-kill-") as folder:
        listed = list(scenarios(root))
        for name, yaml in listed:
            campaign.one(name, yaml, -(-kills // len(listed)), folder)
    print("moments:", ", ".join(f"{count} {kind}" for kind, count in campaign.kinds.items()))
    print(f"{campaign.done} kills, {campaign.torn} incomplete rows, {campaign.without_scenario} without scenario.yaml, "
          f"{campaign.rendered} rendered, {campaign.render_failures} of these failed")
    # Linux may cut a write where SIGKILL meets it; readers skip the incomplete row.
    assert campaign.without_scenario == campaign.render_failures == 0


main()
