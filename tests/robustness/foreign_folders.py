# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Aims `reamsim run --overwrite` at folders that are not its own, and starts pairs of runs into one folder.

    foreign_folders.py REAMSIM ROOT PAIRS

Each set-up puts something foreign where the run would write. The run must end with status 2, or with 0 where nothing
foreign is in the way, and in both cases every foreign file must be there afterwards with its bytes. Mounts need a
namespace of their own (`unshare -rm`); where that is not allowed they are reported as not tried. Of each PAIR at least one
run finishes, and one that does not must end with status 2 and say which process holds the folder.
"""

import os
import shutil
import socket
import subprocess
import sys
import tempfile

SCENARIO = """version: 2
bone:
  source: phantom
  voxel_mm: 0.5
  phantom: {{shape: half_space, size_mm: [10, 10, 6]}}
tool: {{mesh: {mesh}}}
motion:
  frame_rate_hz: 100
  plunge: {{approach_mm: 0.5, feed_mm_s: 5, depth_mm: 1, dwell_s: 0, retract_mm: 2, retract_mm_s: 20}}
render: {{enabled: false}}
engine: {{device: serial}}
"""


def write(path, text="years of work"):
    os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
    with open(path, "w", encoding="utf-8") as file:
        file.write(text)


def result(at="out"):
    shutil.copytree("finished", at)


def into(folder, place, text="years of work"):
    """A finished result with a foreign file in it."""
    return lambda: (result(folder), write(f"{folder}/{place}", text))


def link(target, name):
    return lambda: os.symlink(target, name)


def bound_socket():
    with socket.socket(socket.AF_UNIX) as end:
        end.bind("out")


def under_home():
    os.makedirs("out/me")
    write("out/me/letter.txt")
    os.environ["HOME"] = os.path.abspath("out/me")


# Name: what is done in an empty folder, output (-o), status expected, mounts as root of a namespace.
SETUPS = [
    ("a folder of documents", lambda: write("out/chapters/one.tex"), "out", 2, ""),
    ("a folder of folders", lambda: os.makedirs("out/a/b/c"), "out", 2, ""),
    ("a result with a note", into("out", "notes.txt"), "out", 2, ""),
    ("a result with a hidden file", into("out", ".hidden"), "out", 2, ""),
    ("a result with a file among its pictures", into("out", "frames/mine.png"), "out", 2, ""),
    ("a result with a picture named as its own", into("out", "frames/999999.png"), "out", 2, ""),
    ("a result whose plots are a link",
     lambda: (write("mine/a.txt"), result(), shutil.rmtree("out/plots", True), os.symlink("../mine", "out/plots")),
     "out", 2, ""),
    ("an unfinished folder with a note", lambda: write("out.partial/notes.txt"), "out", 2, ""),
    ("an unfinished folder that is a link", lambda: (write("mine/a.txt"), os.symlink("mine", "out.partial")), "out", 2, ""),
    ("an unfinished folder that is a file", lambda: write("out.partial"), "out", 2, ""),
    ("a lock that is a document", lambda: write("out.lock"), "out", 2, ""),
    ("a lock that is a link", lambda: (write("mine.txt"), os.symlink("mine.txt", "out.lock")), "out", 2, ""),
    ("a lock that is a folder", lambda: write("out.lock/a.txt"), "out", 2, ""),
    ("a file", lambda: write("out"), "out", 2, ""),
    ("a socket", bound_socket, "out", 2, ""),
    ("a pipe", lambda: os.mkfifo("out"), "out", 2, ""),
    ("a device", link("/dev/null", "out"), "out", 2, ""),
    ("a link to nothing", link("nowhere", "out"), "out", 2, ""),
    ("a link to documents", lambda: (write("mine/a.txt"), os.symlink("mine", "out")), "out", 2, ""),
    ("a link to itself", link("out", "out"), "out", 2, ""),
    ("the current folder", lambda: write("mine.txt"), ".", 2, ""),
    ("the folder above", lambda: write("mine.txt"), "..", 2, ""),
    ("the root", lambda: None, "/", 2, ""),
    ("a folder above a home", under_home, "out", 2, ""),
    ("the folder of the scenario", lambda: None, os.path.join("..", "scenario"), 2, ""),
    ("a name with dots", lambda: (result(), write("mine.txt")), "out/../out/./", 0, ""),
    ("a result beside documents", lambda: (result(), write("out2/mine.txt"), write("out.old/mine.txt")), "out", 0, ""),
    ("a result with a hard link to a document", lambda: (result(), write("mine.txt"), os.remove("out/forces.csv"),
                                                         os.link("mine.txt", "out/forces.csv")), "out", 0, ""),
    ("a mounted disk", lambda: (result(), write("mine/a.txt")), "out", 2, "mount --bind mine out"),
    ("a disk mounted in a result", lambda: (result(), write("mine/a.txt"), os.makedirs("out/plots", exist_ok=True)),
     "out", 2, "mount --bind mine out/plots"),
    ("an empty mounted disk", lambda: os.makedirs("out"), "out", 2, "mount -t tmpfs none out"),
    ("a disk that is read only", lambda: (os.makedirs("disk"), write("mine.txt")), "disk/out", 2,
     "mount -t tmpfs -o ro none disk"),
]


def foreign_files(folder):
    """Every foreign file with its bytes, links with their targets."""
    found = {}
    for at, folders, files in os.walk(folder):
        for name in folders + files:
            path = os.path.join(at, name)
            if os.path.islink(path):
                found[path] = os.readlink(path)
            elif os.path.isfile(path):
                with open(path, "rb") as file:
                    text = file.read()
                if text == b"years of work":
                    found[path] = text
    return found


def can_mount():
    return subprocess.run(["unshare", "-rm", "true"], stderr=subprocess.DEVNULL, check=False).returncode == 0


def try_setup(program, scenario, finished, setup, home):
    name, prepare, output, expected, mount = setup
    with tempfile.TemporaryDirectory(prefix="reamsim-foreign-") as outer:
        shutil.copytree(os.path.dirname(scenario), f"{outer}/scenario")
        os.mkdir(f"{outer}/work")
        os.chdir(f"{outer}/work")
        shutil.copytree(finished, "finished")
        os.environ["HOME"] = home
        prepare()
        before = foreign_files(outer)
        command = [program, "run", f"{outer}/scenario/s.yaml", "-o", output, "--overwrite", "--quiet"]
        if mount:
            command = ["unshare", "-rm", "sh", "-c", f'{mount} && exec "$@"', "sh", *command]
        run = subprocess.run(command, capture_output=True, text=True, check=False)
        after = foreign_files(outer)
        os.chdir("/")
        # The old results may hold a second name of a document; that name is theirs.
        lost = {path for path in before if after.get(path) != before[path] and not path.endswith("out/forces.csv")}
        good = run.returncode == expected and not lost and (expected == 0 or run.stderr.count("\n") == 1)
        print(f"{'kept' if good else 'FAILED'}: {name}: status {run.returncode}; {run.stderr.strip()[-160:]} {lost or ''}")
        return good


def race(program, scenario):
    """Two runs into one folder. Returns how many finished."""
    with tempfile.TemporaryDirectory(prefix="reamsim-race-") as folder:
        runs = [subprocess.Popen([program, "run", scenario, "-o", f"{folder}/out", "--overwrite", "--quiet"],
                                 stderr=subprocess.PIPE, text=True) for _ in range(2)]
        done = 0
        for run in runs:
            _, error = run.communicate()
            done += run.returncode == 0
            if run.returncode != 0:
                assert run.returncode == 2 and "is in use by reamsim process " in error, (run.returncode, error)
        left = sorted(os.listdir(folder))
        assert done >= 1 and left == ["out"] and os.path.exists(f"{folder}/out/manifest.json"), (done, left)
        return done


def main():
    program, root, pairs = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2]), int(sys.argv[3])
    home = os.environ.get("HOME", "/")
    with tempfile.TemporaryDirectory(prefix="reamsim-finished-") as folder:
        scenario = f"{folder}/scenario/s.yaml"
        write(scenario, SCENARIO.format(mesh=f"{root}/assets/reamer_flat.stl"))
        subprocess.run([program, "run", scenario, "-o", f"{folder}/finished", "--quiet"], check=True)
        os.makedirs(f"{folder}/finished/frames", exist_ok=True)
        mounts = can_mount()
        tried = [setup for setup in SETUPS if mounts or not setup[4]]
        kept = sum(try_setup(program, scenario, f"{folder}/finished", setup, home) for setup in tried)
        print(f"{kept} of {len(tried)} set-ups kept" + ("" if mounts else "; mounts were not tried: no namespaces"))
        done = [race(program, scenario) for _ in range(pairs)]
        print(f"{pairs} pairs: {sum(done)} runs finished, {done.count(1)} refused")
        assert kept == len(tried)


main()
