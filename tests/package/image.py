# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""image.py BUILD: cmake/package/build_image.sh makes an image whose runs, by an ordinary user without a home, with a read-only root,
without network and with one volume, have the bytes of a run outside. With podman, where it can run; where it cannot, the test says
why, and enters the image's root with the settings of the Containerfile instead. Needs root and the mirror of Debian's packages;
skipped (77) otherwise."""

import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

import roots

RUN = ["run", "default"]
PODMAN = ["run", "--rm", "--read-only", "--read-only-tmpfs=false", "--network=none", f"--user={roots.USER}:{roots.USER}"]
# Podman as it is, with limits that it need not raise, and with a runtime that works with both kinds of control groups.
LIMITS = ["--ulimit=nofile=1024:1024", "--ulimit=nproc=4096:4096"]
KINDS = [(["podman"], []), (["podman"], LIMITS), (["podman", "--runtime=runc"], LIMITS)]
READ_ONLY = """
mount --bind "$results" "$root/results"
mount -o remount,bind,ro "$root"
"""


def own_storage(folder):
    """Podman's settings for images in a folder, without overlay mounts, which not every system has."""
    settings = folder / "storage.conf"
    settings.write_text(f'[storage]\ndriver = "vfs"\ngraphroot = "{folder}/images"\nrunroot = "{folder}/containers"\n')
    os.environ["CONTAINERS_STORAGE_CONF"] = str(settings)


def volume(folder, name):
    made = folder / name
    made.mkdir()
    os.chown(made, roots.USER, roots.USER)
    return made


def podman_that_runs():
    """A command that starts containers here, and why others do not: the command is empty where none does."""
    if shutil.which("podman") is None:
        return [], ["podman is not installed"]
    reasons = []
    for begin, limits in KINDS:
        command = [*begin, *PODMAN, *limits]
        tried = subprocess.run([*command, "reamsim", "--version"], capture_output=True, text=True)
        if tried.returncode == 0:
            return command, reasons
        reasons.append(f"{' '.join(begin + limits)}: {tried.stderr.strip().splitlines()[-1]}")
    return [], reasons


def in_podman(folder, podman):
    results = volume(folder, "of podman")
    for attempt in ("first", "second"):  # which finds compiled kernels in the volume
        begin = time.monotonic()
        roots.run([*podman, f"--volume={results}:/results", "reamsim", *RUN, "-o", attempt])
        print(f"podman run --read-only, {attempt} run: {time.monotonic() - begin:.1f} s", flush=True)
    writes = subprocess.run([*podman, "--entrypoint=/bin/touch", "reamsim", "/tmp/x"], capture_output=True, text=True)
    assert writes.returncode != 0 and "Read-only" in writes.stderr, writes.stderr
    return results / "first"


def in_namespace(folder):
    """The image's root, the user, the settings and the volume of the Containerfile without podman."""
    root, results = folder / "root", volume(folder, "of namespace")
    root.mkdir()
    roots.run(["tar", "-xf", folder / "image/rootfs.tar", "-C", root])
    environment = re.search(r"^ENV (.*)$", (folder / "image/Containerfile").read_text(), re.M)[1].split()
    os.environ["results"] = str(results)
    begin = time.monotonic()
    roots.enter(root, "sh", "-c", "! touch /tmp/x 2>/dev/null && cd /results && reamsim run default -o first",
                more_mounts=READ_ONLY, user=roots.USER, environment=environment)
    print(f"chroot with a read-only root: {time.monotonic() - begin:.1f} s", flush=True)
    return results / "first"


def check(results, expected):
    assert (results / "forces.csv").read_bytes() == expected, "other bytes in forces.csv"
    for name in ("reamed.png", "forces.png", "report.html", "reamed.vdb"):
        assert (results / name).stat().st_size > 1000, name
    assert (results / "forces.csv").stat().st_uid == roots.USER


def main():
    build, source = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
    roots.require("mmdebstrap", "unshare", "setpriv", "cpack")
    if not roots.mirror("apt_mirror_sources"):
        roots.skip("apt of this machine knows no mirror of Debian")
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        folder.chmod(0o755)
        own_storage(folder)
        made = roots.packages(build, folder / "packages")
        begin = time.monotonic()
        subprocess.run([source / "cmake/package/build_image.sh", folder / "image", made["reamsim"]], check=True)
        print(f"build_image.sh: {time.monotonic() - begin:.0f} s; rootfs.tar {(folder / 'image/rootfs.tar').stat().st_size / 1e6:.0f} MB",
              flush=True)
        roots.run([build / "cli/reamsim", *RUN, "-o", folder / "outside"])
        expected = (folder / "outside/forces.csv").read_bytes()
        podman, reasons = podman_that_runs()
        for reason in reasons:
            print(f"not run with {reason}")
        if podman:
            check(in_podman(folder, podman), expected)
        check(in_namespace(folder), expected)
        print(f"user {roots.USER}, read-only root, one volume: the same {len(expected)} bytes of forces.csv")


main()
