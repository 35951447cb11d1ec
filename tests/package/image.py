# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""image.py BUILD ROOT: `podman build` of the checkout makes an image, from a plain image of Debian that mmdebstrap makes here, whose
runs, by an ordinary user without a home, with a read-only root, without network and with one volume, have the bytes of a run
outside. Needs podman, root and the mirror of Debian's packages; skipped (77) otherwise. --release NAME: the base, trixie
without it."""

import os
import pathlib
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
# A machine that forbids containers of their own namespaces may still build in a chroot.
BUILDERS = (["podman", "build"], ["podman", "--runtime=runc", "build"], ["podman", "build", "--isolation=chroot"])


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


def build_image(source, folder, release):
    """The image `reamsim` from the checkout, on a base that is imported as an image."""
    base = folder / "base"
    roots.bootstrap(base, release)
    roots.run(["tar", "-cf", folder / "base.tar", "-C", base, "."])
    roots.run(["podman", "import", folder / "base.tar", "debian-base"])
    for builder in BUILDERS:
        begin = time.monotonic()
        done = subprocess.run([*builder, "--network=host", "--build-arg=DEBIAN=localhost/debian-base", "--tag", "reamsim",
                               str(source)], capture_output=True, text=True)
        if done.returncode == 0:
            size = roots.run(["podman", "image", "inspect", "--format", "{{.Size}}", "reamsim"])
            print(f"{' '.join(builder)}: {time.monotonic() - begin:.0f} s; image of {float(size) / 1e6:.0f} MB", flush=True)
            return
        print(f"{' '.join(builder)}: {done.stderr.strip().splitlines()[-1]}", flush=True)
    raise AssertionError(done.stdout[-4000:] + done.stderr[-4000:])


def check(results, expected):
    assert (results / "forces.csv").read_bytes() == expected, "other bytes in forces.csv"
    for name in ("reamed.png", "forces.png", "report.html", "reamed.vdb"):
        assert (results / name).stat().st_size > 1000, name
    assert (results / "forces.csv").stat().st_uid == roots.USER


def main():
    build, source = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
    release = sys.argv[4] if sys.argv[3:4] == ["--release"] else "trixie"
    roots.require("mmdebstrap", "unshare", "podman")
    with tempfile.TemporaryDirectory() as temporary:
        folder = pathlib.Path(temporary)
        folder.chmod(0o755)
        own_storage(folder)
        build_image(source, folder, release)
        roots.run([build / "cli/reamsim", *RUN, "-o", folder / "outside"])
        expected = (folder / "outside/forces.csv").read_bytes()
        podman, reasons = podman_that_runs()
        for reason in reasons:
            print(f"not run with {reason}")
        assert podman, "podman runs no container here"
        check(in_podman(folder, podman), expected)
        print(f"user {roots.USER}, read-only root, one volume: the same {len(expected)} bytes of forces.csv")


main()
