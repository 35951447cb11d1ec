# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""documented_commands.py REAMSIM ROOT BUILD: every command in README and docs works as it is written.
documented_commands.py --list ROOT: what is done with each, without running any.

A command without placeholders runs in a copy of the project's folders, where small pictures and coarse voxels save time. Of a synopsis,
such as `reamsim run SCENARIO [-o DIR]`, every option must be one of the program, and an example of it runs. What a page says
that a command prints is compared, but for times and memory. A command of ctest works from the root of the checkout and selects tests.
What other tests or people run is named in run_elsewhere.yaml. Any other line of a shell fails the test. With the
shoulder of REAMSIM_DATA the README's scenario is that of the README; without it a phantom takes its place."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

import yaml

import dicom_folder
import documented

SMALL = {"width_px": 160, "height_px": 120, "every_frames": 500}
COARSE_MM, COARSE_HZ = 1, 200  # voxels and frames of the scenarios, of which other tests run those that ship
# What a page prints is compared with a run as it ships, or as init wrote it, without pictures.
PLAIN = "--overwrite --set render.enabled=false --set output.meshes=false --set output.vti=false --set output.plots=false"

# Results of which a page shows or draws pictures; others are without, for less time.
DRAWN = {"out/default", "out/my", "out/s"}

RUN_ELSEWHERE = yaml.safe_load(pathlib.Path(__file__).with_name("run_elsewhere.yaml").read_text())
REASON = {command: reason for reason, commands in RUN_ELSEWHERE.items() for command in commands}
# What stands for something of the user's. `{scan}` is the scan at hand.
EXAMPLES = {
    "reamsim run SCENARIO": "reamsim run s.yaml -o out/s --device serial",
    "reamsim run SCENARIO -o DIR --resume": "reamsim run s.yaml -o out/resumed --resume",
    "reamsim run --set render.enabled=false": "reamsim run s.yaml -o out/plain --set render.enabled=false --set output.meshes=false",
    "reamsim run --verbose": "reamsim run s.yaml -o out/verbose --verbose",
    "reamsim check SCENARIO": "reamsim check s.yaml --picture scenario.png",
    "REAMSIM_DATA=... reamsim check FILE": "reamsim check s.yaml",
    "reamsim render DIR.partial": "",  # of an interrupted run: cli_test (Resume)
    "reamsim render DIR": "reamsim render out/s --only pictures --width 96 --height 64",
    "reamsim reforce DIR": "",  # cli_test (Reforce); the how-to names others
    "reamsim fit DIR": "",
    "reamsim compare": "reamsim compare out/s out/plain -o out/compared",
    "reamsim preview BONE": "reamsim preview {scan} -o bone.html --tool assets/reamer_convex.stl",
    "reamsim init": "",  # docs/guide/ct.md, with and without a point
    "reamsim uq": "reamsim uq uq.yaml -o out/uq",
    "reamsim validate": "",  # docs/validation.md has one
    "reamsim sweep": "reamsim sweep run reamers",
    "reamsim sweep run STUDY.yaml --shard": "reamsim sweep run trajectories/studies/reamers.yaml -o out/swept --shard 2/8",
    "reamsim sweep collect": "reamsim sweep collect reamers",
    "reamsim sweep submit": "reamsim sweep submit trajectories/studies/reamers.yaml --slurm --to out/scripts",
    "reamsim sweep status": "reamsim sweep status reamers",
    "reamsim import": "reamsim import s.yaml -o bone.vdb",
    "reamsim devices": "reamsim devices --json",
    "reamsim cite": "reamsim cite out/s",
    "reamsim cache": "reamsim cache",
    "reamsim help": "reamsim help sweep run",
    "reamsim bench": "",  # cli_test (Bench)
    "reamsim verify": "",  # cli_test (Verify)
    "reamsim run trajectories/mesh_scapula.yaml --set bone.voxel_mm=V": "",  # its data: e2e.mesh_scapula
    "reamsim run trajectories/compliance.yaml --set": "reamsim run trajectories/compliance.yaml -o out/springs --set motion.plunge.depth_mm=0.2 "
                                                      "--set motion.plunge.dwell_s=0 --set render.enabled=false --set output.meshes=false",
    "reamsim run trajectories/study_X.yaml": "reamsim run trajectories/study_eccentric_10deg.yaml",
}
PLACEHOLDER = re.compile(r"\b(COMMAND|STUDY|SCENARIO|DIR|BONE|CT|MESH|FILE|PAGE|SCAN_OR_SCENARIO)\b|=[VK]\b|_X\b|\[-")
# The name of a command, perhaps with an option: the words of a sentence, not a command on its own.
IN_A_SENTENCE = re.compile(r"^(build/release/cli/)?reamsim( sweep)?( \w+)?$|^(?!reamsim)([A-Z_]+=\S+ )?[\w-]+( --?\w[\w-]*)?$|^\./run\.sh$")
RUN_HERE = re.compile(r"(build/release/cli/)?reamsim |\./run\.sh |gnuplot |cd out/default; ")
NEEDS_SCAN = re.compile(r"~/scans|\bglenoid\.yaml|\bscapula")
MOTION = {
    "plunge": {"approach_mm": 0.5, "feed_mm_s": 5, "depth_mm": 1, "retract_mm": 2},
    "keyframes": [{"time_s": 0, "position_mm": [0, 0, 1], "axis": [0, 0, 1]},
                  {"time_s": 0.5, "position_mm": [0, 0, -1], "axis": [0, 0, 1]}],
}


def coarsen(bone):
    """Coarse voxels; of a scan 90 mm about the glenoid, which take an eighth of the time."""
    bone["voxel_mm"] = COARSE_MM
    if "ct" in bone:
        middle = bone["glenoid"].get("near_mm") or bone["glenoid"]["center_mm"]
        bone["ct"] |= {"crop_min_mm": [x - 45 for x in middle], "crop_max_mm": [x + 45 for x in middle]}


class Place:
    """A folder like the project's, with a home, a scan and scenarios of a user."""

    def __init__(self, program, root, folder):
        self.root, self.folder, self.done, self.help = root, folder, set(), {}
        self.printed = {}  # the output that pages show, by command
        for page in documented.pages(root):
            self.printed.update(documented.printed((root / page).read_text()))
        for name in ("build/release/cli", "bin", "home/scans", "home/.cache"):
            (folder / name).mkdir(parents=True)
        # Compiled kernels and lists of fonts of the real home; the store of bones is one of this folder.
        for cache in ("pocl", "mesa_shader_cache", "fontconfig", "matplotlib"):
            if (real := pathlib.Path(os.path.expanduser("~/.cache"), cache).absolute()).is_dir():
                (folder / "home/.cache" / cache).symlink_to(real)
        # A copy, so that the names of shipped scenarios are those of this folder.
        shutil.copy(program, folder / "build/release/cli/reamsim")
        (folder / "bin/reamsim").symlink_to(folder / "build/release/cli/reamsim")
        (folder / "bin/scontrol").write_text("#!/bin/sh\nexit 9\n")
        (folder / "bin/scontrol").chmod(0o755)
        (folder / "assets").symlink_to(root / "assets")
        (folder / "python").symlink_to(root / "python")
        shutil.copytree(root / "trajectories", folder / "trajectories")
        (folder / "poses.csv").write_text("time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n0,0,0,1,1,0,0,0\n0.5,0,0,-1,1,0,0,0\n")
        measured, = documented.blocks((root / "docs/guide/uncertainty.md").read_text(), "csv")
        (folder / "measured.csv").write_text(measured)
        self.environment = dict(os.environ, HOME=str(folder / "home"), PATH=f"{folder}/bin:{os.environ['PATH']}")
        self.shrink_scenarios()
        self.add_users_scan()
        self.set_motion("plunge")
        self.write("scenario.yaml", yaml.safe_load((folder / "s.yaml").read_text()))
        self.write("uq.yaml", {"version": 1, "base": "s.yaml",
                               "sample": {"n": 8, "of": {"cutting.normal_ratio": {"uniform": [0.4, 0.6]}}}})
        self.write_studies()
        self.write_run_sh()

    def write_studies(self):
        """The studies of the guide, at fewer and coarser levels."""
        for page, name, keys in (("resolution", "convergence.yaml", {"bone.voxel_mm": [1, 0.5]}), ("push", "thrusts.yaml", {"motion.push.thrust_n": [40, 80]})):
            study, = [block for block in map(yaml.safe_load, documented.blocks((self.root / f"docs/guide/{page}.md").read_text(), "yaml")) if "base" in block]
            study["vary"] = [{key: keys.get(key, values[:1]) for key, values in entry.items()} for entry in study["vary"]]
            study["set"] = {**study.get("set", {}), "bone.voxel_mm": 1} if page == "push" else study.get("set", {})
            self.write(name, study)
        study = yaml.safe_load((self.root / "trajectories/studies/reamers.yaml").read_text())
        self.write("trajectories/studies/reamers.yaml", {**study, "vary": study["vary"][1:2] + [{"motion.plunge.feed_mm_s": [0.5, 1]}]})
        study = yaml.safe_load(documented.blocks((self.root / "docs/guide/uncertainty.md").read_text(), "yaml")[1])
        self.write("uncertain.yaml", {**study, "sample": {**study["sample"], "n": 4}})

    def write(self, name, scenario):
        (self.folder / name).write_text(yaml.safe_dump(scenario, sort_keys=False))

    def shrink_scenarios(self):
        drilling = self.folder / "trajectories/validation/drilling_models.csv"
        drilling.write_text("".join(line for line in drilling.open() if line.startswith(("label,", "plain law,"))))
        for path in (self.folder / "trajectories").glob("*.yaml"):
            scenario = yaml.safe_load(path.read_text())
            scenario["render"] = {**(scenario.get("render") or {}), **SMALL}
            if "voxel_mm" in scenario["bone"]:
                scenario["bone"]["voxel_mm"] = COARSE_MM
            scenario["motion"].setdefault("frame_rate_hz", COARSE_HZ)
            self.write(f"trajectories/{path.name}", scenario)

    def add_users_scan(self):
        data = self.environment.get("REAMSIM_DATA", "")
        nrrd = pathlib.Path(data) / "shoulder_ct/shoulder_left.nrrd"
        mine = self.folder / "trajectories/my.yaml"
        if data and nrrd.exists():
            dicom_folder.write(nrrd, self.folder / "home/scans/shoulder")
            scenario = yaml.safe_load(documented.blocks((self.root / "README.md").read_text(), "yaml")[0])
            scenario["render"] = SMALL
            scenario["motion"]["frame_rate_hz"] = COARSE_HZ
            coarsen(scenario["bone"])
            self.write("trajectories/my.yaml", scenario)
            self.example = {"scan": "~/scans/shoulder"}
            (self.folder / "scapula_left.stl").symlink_to(nrrd.parents[1] / "scapula_mesh/scapula_left.stl")
        else:
            print("without REAMSIM_DATA: a phantom for the README's scan")
            shutil.copy(self.folder / "trajectories/default.yaml", mine)
            self.example = None
        # What the page of the preview saves.
        self.write("shoulder.yaml", {**yaml.safe_load(mine.read_text()), "tool": {"mesh": "assets/reamer_convex.stl"}})

    def set_motion(self, kind):
        self.write("s.yaml", {
            "version": 2, "bone": {"source": "phantom", "voxel_mm": 0.5, "phantom": {"shape": "half_space", "size_mm": [10, 10, 6]}},
            "tool": {"mesh": "assets/reamer_flat.stl"}, "motion": {"frame_rate_hz": 100, kind: MOTION[kind]}, "render": SMALL})

    def write_run_sh(self):
        """run.sh without the part that installs and builds."""
        runs = (self.root / "run.sh").read_text().split('cd "$start"\n')[1]
        head = 'set -euo pipefail\nroot=$PWD\nbuild=$PWD/build/release\nsay() { echo "$@"; }\n'
        (self.folder / "run.sh").write_text(f"#!/usr/bin/env bash\n{head}{runs}")
        (self.folder / "run.sh").chmod(0o755)

    def run(self, command, where=".", expected=0):
        before = os.times()
        done = subprocess.run(["bash", "-c", command], cwd=self.folder / where, env=self.environment, capture_output=True,
                              text=True, timeout=300)
        assert done.returncode == expected, f"{command}\nended with {done.returncode}\n{done.stdout[-2000:]}{done.stderr}"
        after = os.times()
        print(f"{sum(after[2:4]) - sum(before[2:4]):6.1f} processor s $ {command}", flush=True)
        return done.stdout + done.stderr

    def help_of(self, program):
        if program not in self.help:
            self.help[program] = self.run(f"{program} --help")
        return self.help[program]

    def at_full_resolution(self, command):
        """The command that gives the results of a page, of which this test runs a coarse form. `fit` takes the default scenario, which
        a page before has run."""
        if command.startswith("reamsim fit"):
            return f"{command.replace('out/basis', 'out/full_default')} --overwrite"
        name = command.split()[-1 if "sweep" in command else 2]
        if "sweep" in command:
            return f"reamsim sweep run {self.root}/trajectories/studies/{name}.yaml -o out/full_{name}"
        path = f"as_written_{name}" if name.endswith(".yaml") else self.root / f"trajectories/{name}.yaml"
        return f"reamsim run {path} -o out/full_{name} {PLAIN}{' --set output.force_basis=true' if name == 'default' else ''}"

    def run_documented(self, command):
        """Runs a command of a user, who has no results of that name yet, and expects the lines that a page says it prints. Once,
        however often pages name it."""
        if command in self.done:
            return
        self.done.add(command)
        where = "out/my" if command.startswith("gnuplot") else "."
        executed = command
        if re.match(r"(build/release/cli/)?reamsim run ", command):
            self.set_motion("keyframes" if "keyframes" in command else "plunge")
            named = re.search(r"-o (\S+)", command)
            scenario = re.search(r"reamsim run (?:\S*/)?(\w+)", command)
            results = named[1] if named else f"out/{scenario[1]}"
            shutil.rmtree(self.folder / results, ignore_errors=True)
            if "render." not in command and (results not in DRAWN or "--set" in command):
                executed += " --set render.enabled=false --set output.plots=false"
        printed = self.printed.get(command, [])
        said = self.run(executed, where, expected=2 if any("error:" in line for line in printed) else 0)
        if printed and command.startswith(("reamsim run", "reamsim fit", "reamsim sweep")):
            said = self.run(self.at_full_resolution(command))
        for line in printed:
            shown = line.replace("/usr/share/reamsim", str(self.folder.resolve()))
            assert shown in said, f"{command}: the page says that it prints\n{line}\nbut it printed\n{said}"
        written = re.search(r"reamsim init .*-o (\S+)", command)
        if written:
            scenario = yaml.safe_load((self.folder / written[1]).read_text())
            self.write(f"as_written_{written[1]}", scenario)
            coarsen(scenario["bone"])
            self.write(written[1], {**scenario, "render": SMALL})


def check_options(place, command):
    """Every option of a synopsis is one of the program."""
    program = re.match(r".*?reamsim (sweep \w+|\w+)", command)
    name = "sweep run" if program[1].startswith("sweep") and command[program.end():].startswith("|") else program[1]
    known = place.help_of(f"reamsim {name}")
    for option in re.findall(r"--[a-z-]+", command):
        assert re.search(rf"{option}\b", known), f"{command}: reamsim {program[1]} has no {option}"


def check_filter(build, command):
    """A command of ctest works from the root of the checkout, and selects tests. Some are there only in a build with browsers."""
    assert "--preset" in command or "--test-dir build/release " in command, f"{command}: add --test-dir build/release"
    if "--preset" in command or "browser" in command:
        return
    listed = subprocess.run(["bash", "-c", f"{command.replace('build/release', build)} -N"], capture_output=True, text=True, check=True).stdout
    assert "Total Tests: 0" not in listed, f"{command} selects no test"


def example_of(command):
    starts = [start for start in EXAMPLES if command.startswith(start)]
    assert starts, f"{command}: no example for its placeholders; add one to EXAMPLES"
    return EXAMPLES[max(starts, key=len)]


def treatment(command):
    """What is done with a command, and by what."""
    if command in REASON:
        return "elsewhere", REASON[command]
    if command.startswith("ctest"):
        return "filter", "selects tests"
    if IN_A_SENTENCE.match(command):
        return "sentence", "--help" if "reamsim" in command else ""
    if PLACEHOLDER.search(command) or "..." in command or re.match(r"reamsim run --", command):
        return "example", example_of(command)
    assert RUN_HERE.match(command), f"{command}: this test cannot run it: name in run_elsewhere.yaml what does"
    return "run", ""


def check_page(place, build, commands):
    for command, kind, example in commands:
        if kind == "filter":
            check_filter(build, command)
        elif kind == "sentence" and "reamsim" in command:
            place.help_of(command)
        elif kind == "example":
            check_options(place, command)
            if "{scan}" in example and place.example is None:
                continue
            if example:
                example = example.format(**(place.example or {}))
                for made in re.findall(r"\S+\.(?:html|png|vdb)|first\.yaml", example):
                    (place.folder / made).unlink(missing_ok=True)
                shutil.rmtree(place.folder / "out/compared", ignore_errors=True)
                place.run_documented(example)
        elif kind == "run" and (place.example or not NEEDS_SCAN.search(command)):
            place.run_documented(command)


def known_commands(root):
    """(command, kind, example) of each page. Every command is known, and every one of run_elsewhere.yaml is on a page."""
    found = documented.all_commands(root)
    stale = REASON.keys() - {command for commands in found.values() for command in commands}
    assert not stale, f"on no page: {sorted(stale)}"
    return {page: [(command, *treatment(command)) for command in commands] for page, commands in found.items()}


def check_python(place, text):
    for block in documented.blocks(text, "python"):
        if "bpy." in block:
            continue  # tests/browser/blender_results.py runs it
        script = place.folder / "block.py"
        script.write_text(block)
        place.run(f"{sys.executable} block.py")


def check_batch_script(place, text):
    """The script for Slurm: of a run that ends, and of one that the batch system interrupts."""
    script, = [block for block in documented.blocks(text, "sh") if "SBATCH" in block]
    (place.folder / "job.sh").write_text(script)
    place.run("sh -n job.sh")
    shutil.rmtree(place.folder / "out/my", ignore_errors=True)
    place.run("SLURM_JOB_ID=7 sh job.sh")
    assert (place.folder / "out/my/summary.json").exists()


def main():
    root = pathlib.Path(sys.argv[2]).resolve()
    found = known_commands(root)
    if sys.argv[1] == "--list":
        print(*(f"{page}: {kind}: {command}  # {what}" for page, commands in found.items() for command, kind, what in commands), sep="\n")
        return
    program, _, build = sys.argv[1:]
    assert sum(map(len, found.values())) > 60, found
    for wanted in ("reamsim init", "reamsim preview", "reamsim check", "reamsim render"):
        assert any(wanted in command for command, *_ in found["README.md"]), wanted
    with tempfile.TemporaryDirectory() as folder:
        place = Place(program, root, pathlib.Path(folder))
        for name in ("default", "s.yaml -o out/s", "s.yaml -o out/plain"):  # results that commands name
            place.run_documented(f"reamsim run {name}")
        for page, commands in found.items():
            print(f"-- {page}")
            check_page(place, build, commands)
            if page in ("README.md", "docs/studies.md", "docs/guide/pictures.md"):
                check_python(place, (root / page).read_text())
        check_batch_script(place, (root / "docs/command-line.md").read_text())


main()
