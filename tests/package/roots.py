# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Roots of Debian for the tests of packages and image: made with mmdebstrap from the mirror that apt of this machine uses, and
entered in a mount namespace of their own, whose mounts end with it."""

import os
import pathlib
import shutil
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
USER = 1234
# The command of a namespace: mounts what a system has, then enters the root.
ENTER = """
mount --bind "$root" "$root"
mount -t proc proc "$root/proc"
mount --rbind /dev "$root/dev"
mount --rbind /sys "$root/sys"
"""


def skip(reason):
    print(reason)
    sys.exit(77)


def require(*programs):
    if os.geteuid() != 0:
        skip("needs root")
    missing = [program for program in programs if shutil.which(program) is None]
    if missing:
        skip(f"needs {', '.join(missing)} (apt-get install)")
    if subprocess.run(["unshare", "--mount", "true"], capture_output=True).returncode != 0:
        skip("needs a mount namespace, which this machine forbids")


def run(command, **more):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, **more)
    assert done.returncode == 0, f"{command}\n{done.stdout[-4000:]}{done.stderr[-4000:]}"
    return done.stdout


def packages(build, folder):
    """The packages of a build: by name."""
    begin = time.monotonic()
    run(["cpack", "--config", build / "CPackConfig.cmake", "-B", folder, "-G", "DEB"])
    print(f"cpack -G DEB: {time.monotonic() - begin:.0f} s", flush=True)
    found = {path.name.split("_")[0]: path for path in pathlib.Path(folder).glob("*.deb")}
    for name, path in found.items():
        print(f"  {name}: {path.stat().st_size / 1e6:.1f} MB")
    return found


def mirror(function):
    """What a function of cmake/package/apt_mirror.sh says."""
    return run(["bash", "-c", f"source '{ROOT}/cmake/package/apt_mirror.sh' && {function}"])


def bootstrap(root):
    """A minimal Debian 12 that knows the mirror."""
    settings = [f"--aptopt={line}" for line in mirror("apt_mirror_settings").splitlines()]
    sources = mirror("apt_mirror_sources")
    if not sources:
        skip("apt of this machine knows no mirror of Debian")
    begin = time.monotonic()
    run(["mmdebstrap", "--variant=minbase", *settings, "bookworm", root, "-"], input=sources)
    print(f"mmdebstrap --variant=minbase: {time.monotonic() - begin:.0f} s, {size_mb(root):.0f} MB", flush=True)
    shutil.copy("/etc/resolv.conf", root / "etc/resolv.conf")


def size_mb(root):
    """Of the files in it, without the packages that apt keeps."""
    run(["rm", "-rf", *pathlib.Path(root, "var/cache/apt").glob("*")])
    return int(run(["du", "-sxk", "--exclude=proc", "--exclude=var/lib/apt/lists", root]).split()[0]) / 1e3


def enter(root, *command, more_mounts="", user=None, environment=()):
    """Runs a command in the root: by default as its root with a home, otherwise as an ordinary user without one. The settings of
    `environment` are the only ones beside PATH and LANG."""
    fixed = ["PATH=/usr/bin:/bin:/usr/sbin:/sbin", "LANG=C.UTF-8", *environment]
    if user is None:
        who = ["env", "-i", *fixed, "HOME=/root", "DEBIAN_FRONTEND=noninteractive"]
    else:
        who = ["setpriv", f"--reuid={user}", f"--regid={user}", "--clear-groups", "--no-new-privs", "--inh-caps=-all", "env", "-i", *fixed]
    script = f"set -e\n{ENTER}{more_mounts}\nexec chroot \"$root\" \"$@\""
    return run(["unshare", "--mount", "--propagation", "private", "bash", "-c", script, "bash", *who, *command],
               env={**os.environ, "root": str(root)})
