# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""bare_debian.py BUILD: the packages in a Debian without compilers, of the release of this machine, from nothing to pictures, with
recommended packages and without; without them also Python, a program that uses the library, and a run by an ordinary user without
a home and with a read-only root. Prints times and sizes (docs/install.md).
bare_debian.py FOLDER RELEASE: the same with the packages in FOLDER, which were built on RELEASE.
Needs root and the mirror of Debian's packages; skipped (77) otherwise."""

import pathlib
import shutil
import sys
import tempfile
import time

import roots

LIMIT_S = 180
COMPILERS = "for name in cc gcc g++ c++ clang cmake make ninja; do ! command -v $name || exit 1; done"
PYTHON = """
import reamsim
print(reamsim.load("/root/out/default").forces["axial_force_n"].max())
simulation = reamsim.Simulation("/usr/share/reamsim/trajectories/half_space.yaml", bone__voxel_mm=0.6)
simulation.run(simulation.planned_poses())
print(simulation.removed_mm3)
"""
# A root that cannot be written but for the folder of results.
READ_ONLY = """
mkdir -p "$root/results"
mount -t tmpfs -o mode=1777 tmpfs "$root/results"
mount -o remount,bind,ro "$root"
"""


NO_RECOMMENDED = "--no-install-recommends"


def install(root, *files, option=NO_RECOMMENDED):
    names = [f"/var/tmp/{path.name}" if isinstance(path, pathlib.Path) else path for path in files]
    for path in files:
        if isinstance(path, pathlib.Path):
            roots.run(["cp", path, root / "var/tmp"])
    before, begin = roots.size_mb(root), time.monotonic()
    options = [option] if option else []
    roots.enter(root, "apt-get", "install", "-y", "-q", *options, *names)
    words = " ".join(["apt install", *options, *(name.split("/")[-1] for name in names)])
    print(f"{words}: {time.monotonic() - begin:.0f} s, {roots.size_mb(root) - before:.0f} MB", flush=True)


def pictures(root, files, release, option):
    """From nothing to the pictures of the first run: seconds."""
    begin = time.monotonic()
    roots.bootstrap(root, release)
    roots.enter(root, "sh", "-c", COMPILERS)
    roots.enter(root, "apt-get", "update", "-q")
    install(root, files["reamsim"], option=option)
    started = time.monotonic()
    roots.enter(root, "sh", "-c", "cd && reamsim run default")
    taken = time.monotonic() - begin
    assert (root / "root/out/default/reamed.png").stat().st_size > 10_000
    print(f"reamsim run default: {time.monotonic() - started:.1f} s; from nothing to all its pictures: {taken:.0f} s", flush=True)
    message = roots.enter(root, "sh", "-c", "reamsim run nonsense 2>&1; test $? = 2")
    assert "compliance, " in message and "several_passes" in message, message
    return taken


def ordinary_user(root):
    """The same bytes for a user whom the system does not know, with nothing to write but one folder, and with TMPDIR alone."""
    expected = (root / "root/out/default/forces.csv").read_bytes()
    (root / "results").mkdir(exist_ok=True)
    for environment in (["XDG_CACHE_HOME=/results/.cache"], ["TMPDIR=/results"]):
        script = ("! touch /tmp/x 2>/dev/null && cd /results && reamsim run default >said && cmp /root-forces.csv out/default/forces.csv"
                  " && test -s out/default/reamed.png && test -s out/default/forces.png && find . -name program.bc | wc -l")
        (root / "root-forces.csv").write_bytes(expected)
        kernels = roots.enter(root, "sh", "-c", script, more_mounts=READ_ONLY, user=roots.USER, environment=environment)
        assert int(kernels) > 0, "no compiled kernels in the folder"
    print(f"user {roots.USER} without HOME, read-only root: the same {len(expected)} bytes of forces.csv")


def python(root, files):
    install(root, files["python3-reamsim"])
    force, removed = roots.enter(root, "python3", "-c", PYTHON).split()
    assert float(force) > 10 and float(removed) > 100, (force, removed)


def library(root, files):
    install(root, files["libreamsim-dev"], "g++", "cmake", "make")
    example = "/usr/share/doc/reamsim/docs/examples/library"
    script = (f"cd && cmake -S {example} -B example -DCMAKE_BUILD_TYPE=Release && cmake --build example && "
              "c++ -std=c++20 -O1 {0}/impedance.cpp -o by_pkg_config $(pkg-config --cflags --libs reamsim) && "
              "for program in example/impedance ./by_pkg_config; do $program /usr/share/reamsim/trajectories/half_space.yaml 1.0 | "
              "tail -n 1; done").format(example)
    begin = time.monotonic()
    said = roots.enter(root, "sh", "-c", script).splitlines()[-2:]
    print(f"a program of the library, by CMake and by pkg-config: {time.monotonic() - begin:.0f} s: {said[0]}")
    assert said[0] == said[1] and "removed" in said[0], said


def main():
    place, *release = sys.argv[1:]
    place = pathlib.Path(place).resolve()
    # CTest gives the checkout as second argument.
    release = release[0] if release and not pathlib.Path(release[0]).is_dir() else roots.own_release()
    roots.require("mmdebstrap", "unshare", "setpriv", "cpack")
    with tempfile.TemporaryDirectory() as temporary:
        built = (place / "CPackConfig.cmake").exists()
        made = roots.packages(place, temporary) if built else {path.name.split("_")[0]: path for path in place.glob("*.deb")}
        taken_s = [pictures(pathlib.Path(temporary, "recommended"), made, release, "")]
        shutil.rmtree(pathlib.Path(temporary, "recommended"))
        debian = pathlib.Path(temporary, "debian")
        taken_s.append(pictures(debian, made, release, NO_RECOMMENDED))
        ordinary_user(debian)
        python(debian, made)
        library(debian, made)
    assert max(taken_s) < LIMIT_S, f"{max(taken_s):.0f} s from nothing to pictures; the limit is {LIMIT_S} s on a free machine"


main()
