# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""messages.py REAMSIM ROOT: every message of docs/guide/troubleshooting.md still occurs, and every mistake here is on that page.

Each case makes a mistake of its kind. Its message has to match one of the page, in which … stands for anything."""

import pathlib
import re
import subprocess
import sys
import tempfile

import scans

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "e2e"))
import documented  # noqa: E402

PAGE = "docs/guide/troubleshooting.md"
SCENARIOS = {
    "phantom.yaml": "bone: {source: phantom, side: left, voxel_mm: 1, phantom: {shape: half_space, size_mm: [36, 36, 10]}}\n"
                    "motion: {plunge: {depth_mm: 1, approach_mm: 0.5}}\n",
    "ct.yaml": "bone: {source: ct, side: left, voxel_mm: 1, ct: {path: ball.nrrd}}\n"
               "motion: {plunge: {entry_mm: [19.5, 19.5, 33], depth_mm: 1}}\n",
    "mesh.yaml": "bone: {source: mesh, side: left, voxel_mm: 1, mesh: {path: box.stl},\n"
                 "  glenoid: {center_mm: [15, 15, 30], normal: [0, 0, 1], superior: [0, 1, 0]}}\n"
                 "motion: {frame: glenoid, plunge: {depth_mm: 1}}\n",
}
REST = "version: 2\ntool: {mesh: reamer.stl}\nrender: {enabled: false}\n"
LABEL = "--set bone.ct.label_map.path=ball.seg.nrrd --set bone.ct.label_map.label"
NEAR = "--set bone.glenoid.near_mm=[19.5,19.5,33]"
CASES = [
    "check phantom.yaml --set bone.voxel=0.5",
    "check phantom.yaml --set motion.plunge.depth_mm=3,5",
    "check tab.yaml",
    "check short.yaml",
    "check ct.yaml --set motion.frame=glenoid",
    "check mesh.yaml --set bone.side=null",
    "check mesh.yaml --set bone.mesh.path=nofile.stl",
    "check phantom.yaml --set tool.mesh=part.step",
    "check phantom.yaml --set tool.mesh='${NOWHERE}/x.stl'",
    "sweep plan empty_study.yaml",
    "init nothing -o new.yaml",
    "check ct.yaml --set bone.ct.path=unoriented.nrrd",
    "check ct.yaml --set bone.ct.seed_mm=[1,1,1]",
    f"check ct.yaml {NEAR} --set bone.ct.separate=humerus",
    f"check ct.yaml {NEAR}",
    "init ball.nrrd -o new.yaml",
    f"check ct.yaml {LABEL}=humerus",
    f"check ct.yaml {LABEL}=1 --set bone.ct.threshold_hu=200",
    "check mesh.yaml --set bone.mesh.path=open.stl",
    "check mesh.yaml --set bone.mesh.path=small.stl",
    "init box.stl -o new.yaml",
    "check phantom.yaml --set motion.plunge.entry_mm=[60,0,0]",
    "check phantom.yaml --set motion.plunge.entry_mm=[0,0,-5]",
    "check mesh.yaml --set bone.glenoid.normal=[0,0,-1] --set motion.plunge.from=contact",
    "check mesh.yaml --set bone.glenoid.center_mm=[15,15,60] --set motion.plunge.from=contact",
    "check phantom.yaml --set motion.push.thrust_n=10",
    "check phantom.yaml --set motion.plunge=null --set motion.csv.path=semicolons.csv",
    "check phantom.yaml --device nvidia",
    "check mesh.yaml --set bone.voxel_mm=0.01",
    "run phantom.yaml -o done",
    "run phantom.yaml -o mine --overwrite",
    "reforce done --set cutting.normal_ratio=0.4 -o other",
    "render done --only film",
]


def write_inputs(folder, root):
    for name, text in SCENARIOS.items():
        (folder / name).write_text(text + REST)
    (folder / "tab.yaml").write_text("version: 2\nbone:\n\tsource: phantom\n")
    (folder / "short.yaml").write_text("bone: {source: phantom}\n")
    (folder / "empty_study.yaml").write_text("version: 1\n")
    (folder / "semicolons.csv").write_text("time_s;x_mm;y_mm;z_mm;qw;qx;qy;qz\n0;0;0;0;1;0;0;0\n")
    (folder / "part.step").write_text("ISO-10303-21;\n")
    (folder / "nothing").mkdir()
    (folder / "nothing/readme.txt").write_text("no scan")
    (folder / "reamer.stl").symlink_to(root / "assets/reamer_convex.stl")
    scans.write_scan(folder / "ball.nrrd")
    scans.write_scan(folder / "unoriented.nrrd", space="space dimension: 3")
    scans.write_label_map(folder / "ball.seg.nrrd")
    scans.write_box(folder / "box.stl", 30)
    scans.write_box(folder / "open.stl", 30, open_side=True)
    scans.write_box(folder / "small.stl", 0.15)


def messages_of(program, folder, case):
    done = subprocess.run(f"{program} {case}", shell=True, cwd=folder, capture_output=True, text=True, timeout=120)
    return [line for line in done.stderr.splitlines() if line.startswith(("reamsim: error:", "reamsim: warning:"))]


def pattern(line):
    return re.compile(".*".join(map(re.escape, line.split("…"))) + "$")


def main():
    program, root = sys.argv[1], pathlib.Path(sys.argv[2]).resolve()
    blocks = documented.blocks((root / PAGE).read_text(), "text")
    lines = [line for block in blocks for line in block.splitlines()]
    assert len(lines) >= 25 and len(set(lines)) == len(lines), lines
    met = set()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        write_inputs(folder, root)
        for results in ("done", "mine"):
            subprocess.run([program, "run", "phantom.yaml", "-o", results, "--quiet", "--device", "serial"], cwd=folder, check=True)
        (folder / "mine/mine.txt").write_text("a file of the user")
        for case in CASES:
            said = messages_of(program, folder, case)
            matched = [line for line in lines for message in said if pattern(line).match(message)]
            assert matched, f"reamsim {case} says what the page does not have:\n" + "\n".join(said)
            met.update(matched)
    assert met == set(lines), "no longer said:\n" + "\n".join(set(lines) - met)
    print(f"{len(lines)} messages, {len(CASES)} mistakes")


main()
