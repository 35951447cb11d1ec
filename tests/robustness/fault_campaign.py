# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Runs in which a call fails: writing, renaming and removing files, memory.

    fault_campaign.py REAMSIM LIBRARY ROOT short|long [CAMPAIGN] [FIRST] [LAST]

LIBRARY (faults/) makes the n-th call fail, once or from then on. Each run replaces an older result (--overwrite). Checks
after each: an exit status of the program, no signal; on failure one line on stderr that names a file or the memory; the
old result untouched or the new one complete, under DIR or, as the message says, under DIR.partial; a manifest.json that
says `complete` only where that is so. `long` also continues what was left with --resume, which must end with the same
bytes. Plots are written by a stand-in for gnuplot, whose failures another campaign covers. Exits with 1 on a complaint.
"""

import concurrent.futures
import errno
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time

SCENARIO = """version: 2
bone:
  source: phantom
  voxel_mm: 0.5
  phantom: {{shape: half_space, size_mm: [10, 10, 6]}}
tool: {{mesh: {root}/assets/reamer_flat.stl}}
motion:
  frame_rate_hz: 50
  plunge: {{approach_mm: 0.5, feed_mm_s: 5, depth_mm: {depth}, dwell_s: 0, retract_mm: 2, retract_mm_s: 20, spin_rpm: 200}}
render: {{width_px: 64, height_px: 64, every_frames: 1000, cameras: [oblique]}}
engine: {{batch_frames: 4, device: {device}}}
output: {{checkpoint_s: 0.0001}}
"""
GNUPLOT = '#!/bin/sh\nfor kind in png svg pdf; do echo plot > "${2%.gp}.$kind"; done\n'
TIMEOUT_S = 120
STATUSES = (0, 1, 2, 75, 130)
# Name: kind of call, errno, whether it lasts, without RENAME_EXCHANGE, device.
CAMPAIGNS = {
    "write": ("write", errno.EIO, False, False, "serial"),
    "write, disk full": ("write", errno.ENOSPC, True, False, "serial"),
    "write, OpenCL": ("write", errno.ENOSPC, False, False, "auto"),
    "rename": ("rename", errno.EIO, False, False, "serial"),
    "rename, lasting": ("rename", errno.EACCES, True, False, "serial"),
    "rename, no exchange": ("rename", errno.EIO, False, True, "serial"),
    "allocation": ("allocation", errno.ENOMEM, False, False, "serial"),
    "allocation, large": ("allocation", errno.ENOMEM, True, False, "serial"),
    "allocation, OpenCL": ("allocation", errno.ENOMEM, False, False, "auto"),
}
FIRST_ALLOCATIONS = 2000
LARGE_BYTES = 16384


def contents(folder):
    out = {}
    for place, _, names in os.walk(folder):
        for name in names:
            path = os.path.join(place, name)
            with open(path, "rb") as file:
                out[os.path.relpath(path, folder)] = file.read()
    return out


def comparable(files):
    """The files of a result without what differs between two equal runs."""
    out = {}
    for name, text in files.items():
        if name in ("timings.csv", "report.html", "scenario.yaml", "manifest.json") or name.endswith(".pdf"):
            text = b""
        if name == "summary.json":
            summary = json.loads(text)
            text = {k: v for k, v in summary.items() if k not in ("timings_s", "memory_mb", "inputs")}
        out[name] = text
    return out


def manifest_of(files):
    try:
        return json.loads(files["manifest.json"])
    except (KeyError, ValueError):
        return None


def says_complete(files):
    manifest = manifest_of(files)
    return manifest is not None and manifest.get("complete") is True


def first_difference(files, expected, listed=True):
    """What makes a result differ from the expected one, or None."""
    # Checkpoints are removed once the manifest is there; an unfinished manifest may be impossible to remove.
    files = {name: text for name, text in files.items()
             if not name.startswith("checkpoint-") and name != "manifest.json.tmp"}
    if not listed:
        files = files | {"manifest.json": expected["manifest.json"]}
    manifest = manifest_of(files)
    if manifest is None or not manifest["complete"]:
        return "no complete manifest.json"
    if sorted(manifest["files"]) != sorted(set(files) - {"manifest.json"}):
        return "manifest.json: " + " ".join(set(manifest["files"]) ^ (set(files) - {"manifest.json"}))
    if sorted(files) != sorted(expected):
        return "files: " + " ".join(set(files) ^ set(expected))
    a, b = comparable(files), comparable(expected)
    return next((name + " differs" for name in sorted(a) if a[name] != b[name]), None)


def contents_of_report(place):
    try:
        with open(f"{place}/report", encoding="utf-8", errors="replace") as file:
            return file.read()
    except FileNotFoundError:
        return ""


class Runs:
    """The old and the new result of a device, and runs of the scenario with a fault."""

    def __init__(self, program, library, root, folder, device):
        self.program, self.library, self.folder = program, library, folder
        os.makedirs(f"{folder}/bin")
        with open(f"{folder}/bin/gnuplot", "w", encoding="utf-8") as file:
            file.write(GNUPLOT)
        os.chmod(f"{folder}/bin/gnuplot", 0o755)
        self.environment = os.environ | {"PATH": f"{folder}/bin:" + os.environ["PATH"]}
        for name, depth in (("old", 0.5), ("new", 1)):
            with open(f"{folder}/{name}.yaml", "w", encoding="utf-8") as file:
                file.write(SCENARIO.format(root=root, depth=depth, device=device))
            status, text = self.run(["run", f"{folder}/{name}.yaml", "-o", f"{folder}/{name}", "--quiet"], {})
            assert status == 0, text
        self.old, self.new = contents(f"{folder}/old"), contents(f"{folder}/new")
        assert first_difference(self.new, self.new) is None

    def run(self, arguments, environment):
        done = subprocess.run([self.program, *arguments], env=self.environment | environment, stderr=subprocess.PIPE,
                              stdout=subprocess.DEVNULL, timeout=TIMEOUT_S, check=False)
        return done.returncode, done.stderr.decode(errors="replace")

    def faulty(self, place, campaign, at):
        """A run over a copy of the old result. Returns status, stderr, report of the library."""
        kind, error, lasts, no_exchange, _ = campaign
        shutil.rmtree(place, ignore_errors=True)
        os.makedirs(place)
        shutil.copytree(f"{self.folder}/old", f"{place}/out")
        environment = {"LD_PRELOAD": self.library, "REAMSIM_FAULT": kind, "REAMSIM_FAULT_AT": str(at),
                       "REAMSIM_FAULT_ERROR": str(error), "REAMSIM_FAULT_LASTS": str(int(lasts)),
                       "REAMSIM_NO_EXCHANGE": str(int(no_exchange)), "REAMSIM_FAULT_DIR": f"{place}/",
                       "REAMSIM_FAULT_REPORT": f"{place}/report",
                       "REAMSIM_FAULT_BYTES": str(LARGE_BYTES if kind == "allocation" and lasts else 0)}
        status, text = self.run(
            ["run", f"{self.folder}/new.yaml", "-o", f"{place}/out", "--overwrite", "--quiet"], environment)
        return status, text, contents_of_report(place)


def complaint_about_message(status, text, kind):
    errors = [line for line in text.splitlines() if not line.startswith("reamsim: warning: ")]
    if status not in STATUSES:
        return f"status {status}"
    if status == 0:
        return "an error without a status" if errors else None
    if len(errors) != 1 or not errors[0].startswith("reamsim: error: "):
        return "not one line"
    if "internal error" in text:
        return "internal error"
    named = "memory" in text if kind == "allocation" else "/out" in text
    return None if named else "does not name the cause"


def complaint_about_success(runs, place, text):
    files = contents(f"{place}/out")
    named = [line.split(": ")[2] for line in text.splitlines() if "cannot be removed" in line]
    rest = {name for name in files if name.startswith("checkpoint-") and f"{place}/out.partial/{name}" in named}
    if rest:
        files = {name: content for name, content in files.items() if name not in rest}
        files["manifest.json"] = runs.new["manifest.json"]
    old = [name for name in os.listdir(place) if name not in ("out", "report", "out.lock")]
    if any(f"{place}/{name}" not in named for name in old):
        return "left without a word: " + " ".join(old)
    return first_difference(files, runs.new)


def complaint_about_failure(runs, place, text, removes):
    out, partial = contents(f"{place}/out"), contents(f"{place}/out.partial")
    whole = first_difference(out, runs.new) is None
    if not whole and out != runs.old:
        return "the old result is damaged and the new one not complete"
    if "the results" in text:
        where = partial if f"in {place}/out.partial" in text else out
        difference = first_difference(where, runs.new, "without their manifest" not in text)
        return "not complete: " + difference if difference else None
    if says_complete(partial) and first_difference(partial, runs.new) and partial != runs.old:
        return "the partial folder says that it is complete"
    kept = "finished frames are kept" in text
    if kept and not partial.get("forces.csv", b"").endswith(b"\n"):
        return "forces.csv ends within a row"
    if text.startswith("reamsim: ") and removes and not kept and not whole and os.path.exists(f"{place}/out.partial"):
        return "left without a word: out.partial"
    return None


def complaint_about_results(runs, place, status, text, removes):
    # After std::terminate() nothing is removed; the file of the lock then locks no more.
    removes = removes and "or a program error" not in text
    if status >= 0 and removes and os.path.exists(f"{place}/out.lock") and "out.lock" not in contents_of_report(place):
        return "the lock is left"
    if status == 0:
        return complaint_about_success(runs, place, text)
    return complaint_about_failure(runs, place, text, removes)


def complaint_about_rest(runs, place, status, text):
    """Continues what is left, as the message says."""
    partial = f"{place}/out.partial"
    if status == 0 or "the results" in text or says_complete(contents(partial)):
        return None
    status, again = runs.run(["run", f"{runs.folder}/new.yaml", "-o", f"{place}/out", "--overwrite", "--resume", "--quiet"], {})
    if status != 0:
        return f"--resume: status {status}: {again}"
    difference = first_difference(contents(f"{place}/out"), runs.new)
    return "--resume: " + difference if difference else None


class Campaign:
    def __init__(self, name, runs, resumes):
        self.name, self.settings, self.runs, self.resumes = name, CAMPAIGNS[name], runs, resumes
        self.statuses, self.complaints, self.struck = {}, [], 0

    def calls(self):
        status, text, report = self.runs.faulty(f"{self.runs.folder}/count", self.settings, 0)
        assert status == 0, text
        return int(report.split("count ")[1])

    def removes(self):
        """Not where every later removal fails."""
        kind, _, lasts, _, _ = self.settings
        return not (kind == "rename" and lasts)

    def one(self, at):
        place = f"{self.runs.folder}/at{at}"
        try:
            status, text, report = self.runs.faulty(place, self.settings, at)
            complaint = complaint_about_message(status, text, self.settings[0])
            complaint = complaint or complaint_about_results(self.runs, place, status, text, self.removes())
            if self.resumes and complaint is None:
                complaint = complaint_about_rest(self.runs, place, status, text)
        except subprocess.TimeoutExpired:
            status, text, report, complaint = "timeout", "", "", "takes too long"
        self.statuses[status] = self.statuses.get(status, 0) + 1
        self.struck += "fault" in report
        if complaint:
            fault = next((line for line in report.splitlines() if line.startswith("fault")), "")
            self.complaints.append(f"{self.name} {at}: {complaint}\n    {fault}\n    {text.strip()}")
            print(self.complaints[-1], flush=True)
        shutil.rmtree(place, ignore_errors=True)

    def run(self, points):
        begin = time.monotonic()
        with concurrent.futures.ThreadPoolExecutor(2) as pool:
            list(pool.map(self.one, points))
        return time.monotonic() - begin


def spaced(first, last, count):
    return sorted({round(first + (last - first) * i / max(1, count - 1)) for i in range(count)}) if last >= first else []


def points_of(name, calls, length):
    """The calls that fail, one in each run."""
    if length == "short":
        return spaced(1, calls, 3)
    if not name.startswith("allocation"):
        return range(1, calls + 1)
    first = FIRST_ALLOCATIONS if name == "allocation" else 0
    return list(range(1, first + 1)) + spaced(first + 1, calls, 500)


def main():
    program, library, root = (os.path.abspath(path) for path in sys.argv[1:4])
    length = sys.argv[4]
    chosen = [sys.argv[5]] if len(sys.argv) > 5 else list(CAMPAIGNS)
    limits = [int(text) for text in sys.argv[6:8]]
    base = "/dev/shm" if os.access("/dev/shm", os.W_OK) else None
    complaints = 0
    print("| campaign | calls | faults | of these injected | exit status: runs | complaints | time, s |\n|---|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory(prefix="reamsim-faults-", dir=base) as folder:
        made = {}
        for name in chosen:
            device = CAMPAIGNS[name][4]
            if device not in made:
                made[device] = Runs(program, library, root, f"{folder}/{device}", device)
            campaign = Campaign(name, made[device], length == "long" and not name.startswith("allocation"))
            calls = campaign.calls()
            points = range(limits[0], limits[1] + 1) if limits else points_of(name, calls, length)
            seconds = campaign.run(points)
            statuses = ", ".join(f"{status}: {n}" for status, n in sorted(campaign.statuses.items(), key=str))
            print(f"| {name} | {calls} | {len(points)} | {campaign.struck} | {statuses} | {len(campaign.complaints)} | {seconds:.0f} |",
                  flush=True)
            complaints += len(campaign.complaints)
    sys.exit(1 if complaints else 0)


main()
