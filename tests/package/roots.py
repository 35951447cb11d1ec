# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Roots of Debian for the tests of packages, image and releases: made with mmdebstrap from the mirror that apt of this machine uses,
and entered in a mount namespace of their own, whose mounts end with it."""

import os
import pathlib
import re
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


def apt(*command):
    return run([*command]).splitlines()


def mirror():
    """Where apt of this machine gets Debian's main from."""
    lines = apt("apt-get", "indextargets", "--format", "$(REPO_URI) $(RELEASE)", "Created-By: Packages", "Origin: Debian",
                "Component: main")
    found = sorted({line.split()[0] for line in lines if "-" not in line.split()[1]})
    return found[0] if found else skip("apt of this machine knows no mirror of Debian; run apt-get update")


def own_release():
    """The release of this machine, as mmdebstrap names it."""
    return re.search(r"^VERSION_CODENAME=(\w+)$", pathlib.Path("/etc/os-release").read_text(), re.M)[1]


def bootstrap(root, release):
    """A minimal Debian of this release, with apt's settings of this machine: a proxy, an archive whose dates have passed."""
    wanted = re.compile(r"Acquire::(Check-Valid-Until|Check-Date|https?::Proxy) ")
    settings = [f"--aptopt={line}" for line in apt("apt-config", "dump") if wanted.match(line)]
    begin = time.monotonic()
    run(["mmdebstrap", "--variant=minbase", *settings, release, root, mirror()])
    print(f"mmdebstrap --variant=minbase {release}: {time.monotonic() - begin:.0f} s, {size_mb(root):.0f} MB", flush=True)
    shutil.copy("/etc/resolv.conf", root / "etc/resolv.conf")


def size_mb(root):
    """Of the files in it, without the packages that apt keeps."""
    run(["rm", "-rf", *pathlib.Path(root, "var/cache/apt").glob("*")])
    return int(run(["du", "-sxk", "--exclude=proc", "--exclude=var/lib/apt/lists", root]).split()[0]) / 1e3


def entered(root, *command, more_mounts="", user=None, environment=()):
    """The command line and the environment that run a command in the root: by default as its root with a home, otherwise as an
    ordinary user without one. The settings of `environment` are the only ones beside PATH and LANG."""
    fixed = ["PATH=/usr/bin:/bin:/usr/sbin:/sbin", "LANG=C.UTF-8", *environment]
    if user is None:
        who = ["env", "-i", *fixed[:2], "HOME=/root", "DEBIAN_FRONTEND=noninteractive", *environment]
    else:
        who = ["setpriv", f"--reuid={user}", f"--regid={user}", "--clear-groups", "--no-new-privs", "--inh-caps=-all", "env", "-i", *fixed]
    script = f"set -e\n{ENTER}{more_mounts}\nexec chroot \"$root\" \"$@\""
    return (["unshare", "--mount", "--propagation", "private", "bash", "-c", script, "bash", *who, *(str(part) for part in command)],
            {**os.environ, "root": str(root)})


def enter(root, *command, **more):
    """Runs a command in the root (entered()), and returns what it prints."""
    line, environment = entered(root, *command, **more)
    return run(line, env=environment)
