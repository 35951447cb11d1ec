# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""releases.py [--folder DIR] [--tests root|user] [RELEASE...]: the two commands of the README on releases of Debian, as a table.

In a root of each release, made once and kept in DIR (build/roots), a clean clone of HEAD is built and run by `./run.sh`, as an
ordinary user with sudo and again as root, and then makes the sums of tests/e2e/same_bytes.py. --tests: also `./test.sh`, as root
or as that user, whose failures and skips are listed. The output of every step is in DIR/RELEASE.log. Needs root, mmdebstrap and
the mirror of Debian's packages; without them it says so and ends with 77. bookworm, trixie and testing without arguments: on two
cores a quarter of an hour for each, an hour with the tests."""

import argparse
import os
import pathlib
import re
import resource
import shutil
import subprocess
import sys
import time

import roots

PLACE = "/home/surgeon/reamsim"  # of the clone in a root
BUILD = f"{PLACE}/build/release"
RELEASES = ["bookworm", "trixie", "testing"]
COLUMNS = ["release", "compiler", "pictures", "packages", "build", "default run", "bytes", "rusticl", "tests"]
USER = ("id surgeon >/dev/null 2>&1 || { apt-get update -q && apt-get install -y -q --no-install-recommends sudo && "
        "useradd -m -s /bin/bash surgeon && echo 'surgeon ALL=(ALL) NOPASSWD: ALL' >/etc/sudoers.d/surgeon; }")


class Release:
    """A root of Debian with a clone of HEAD."""

    def __init__(self, name, folder):
        self.name, self.root, self.log = name, folder / name, folder / f"{name}.log"
        self.row = dict.fromkeys(COLUMNS, "not run") | {"release": name}
        self.log.write_text("")
        if not self.root.exists():
            roots.bootstrap(self.root, name)
        self.run("bash", "-c", USER)
        clone = self.root / PLACE.strip("/")
        shutil.rmtree(clone, ignore_errors=True)
        roots.run(["git", "clone", "-q", roots.ROOT, clone])
        self.run("chown", "-R", "surgeon:surgeon", PLACE)

    def run(self, *command, user=False):
        """Runs in the clone, output to the log. Returns seconds of wall and of processor, and whether it succeeded."""
        who = ["sudo", "-u", "surgeon", "-E", "HOME=/home/surgeon"] if user else []
        where = ["bash", "-c", f'cd {PLACE} 2>/dev/null; exec "$@"', "bash"]
        mounts = ""
        data = os.environ.get("REAMSIM_DATA", str(roots.ROOT / "../shared/data"))
        environment = []
        if pathlib.Path(data).is_dir():
            mounts = f'mkdir -p "$root/data" && mount --bind "{data}" "$root/data"'
            environment = ["REAMSIM_DATA=/data"]
        line, variables = roots.entered(self.root, *who, *where, *command, more_mounts=mounts, environment=environment)
        begin, before = time.monotonic(), resource.getrusage(resource.RUSAGE_CHILDREN)
        with self.log.open("a") as log:
            status = subprocess.run(line, env=variables, stdout=log, stderr=subprocess.STDOUT).returncode
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return time.monotonic() - begin, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, status == 0

    def file(self, path):
        return self.root / path.strip("/")


def minutes(wall_s, processor_s, ok):
    return f"{wall_s / 60:.1f} min, {processor_s / 60:.1f} of processor{'' if ok else ', FAILED'}"


def first_commands(release):
    """Packages, build and default run: what ./run.sh does, in steps that are timed, and then ./run.sh itself."""
    step = 'set -euo pipefail; source cmake/setup.sh; {}'
    row = release.row
    row["packages"] = minutes(*release.run("bash", "-c", step.format('install_missing "${build_packages[@]}"'), user=True))
    row["build"] = minutes(*release.run("bash", "-c", step.format('build_release OFF all "$build_minutes"'), user=True))
    wall_s, _, ok = release.run("./run.sh", user=True)
    release.run("rm", "-rf", f"{PLACE}/out")
    *_, ok_as_root = release.run("./run.sh")
    row["default run"] = f"{wall_s:.0f} s" if ok and ok_as_root else "FAILED"
    configured = release.file(f"{BUILD}/CMakeCache.txt")
    if configured.exists():
        found = [line for line in configured.parent.glob("CMakeFiles/*/CMakeCXXCompiler.cmake")]
        version = re.search(r'CMAKE_CXX_COMPILER_VERSION "([^"]+)"', found[0].read_text()) if found else None
        row["compiler"] = f"GCC {version[1]}" if version else "none"
        offscreen = re.search(r"pictures are rendered with (\w+)", release.file(f"{BUILD}/configure.log").read_text())
        row["pictures"] = offscreen[1] if offscreen else "none"


def sums(release):
    """The bytes of same_bytes.json."""
    release.run("bash", "-c", "apt-get install -y -q --no-install-recommends python3-openvdb python3-numpy")
    offset = release.log.stat().st_size
    *_, ok = release.run("python3", f"{PLACE}/tests/e2e/same_bytes.py", f"{BUILD}/cli/reamsim", PLACE, "--targets")
    lines = [line for line in release.log.read_text()[offset:].splitlines() if re.search(r" [0-9a-f]{64} ", line + " ")]
    different = sum("DIFFERS" in line for line in lines)
    release.row["bytes"] = f"{len(lines) - different} of {len(lines)} the same" + ("" if ok or different else ", FAILED")
    return lines


def rusticl(release):
    """A second OpenCL driver, of another compiler: Mesa's on the processor, with and without double precision."""
    *_, offered = release.run("bash", "-c", "apt-cache policy mesa-opencl-icd | grep -q 'Candidate: [^(]' && ! grep -q bookworm /etc/os-release")
    if not offered:
        release.row["rusticl"] = "not in this release"
        return
    *_, installed = release.run("apt-get", "install", "-y", "-q", "--no-install-recommends", "mesa-opencl-icd")
    if not installed:
        release.row["rusticl"] = "FAILED: cannot be installed"
        return
    said = []
    for features in ("", "fp64"):
        wall_s, _, ok = release.run("env", "RUSTICL_ENABLE=llvmpipe", f"RUSTICL_FEATURES={features}",
                                    "OCL_ICD_VENDORS=/etc/OpenCL/vendors/rusticl.icd", f"{BUILD}/cli/reamsim", "verify", "--quick",
                                    "--device", "llvmpipe", "-o", "/tmp/verify", "--overwrite")
        said.append(f"{features or 'no fp64'}: {'passed' if ok else 'FAILED'}, {wall_s:.0f} s")
    release.row["rusticl"] = "; ".join(said)


def tests(release, who):
    offset = release.log.stat().st_size
    if who == "user":  # what root has written in the clone
        release.run("chown", "-R", "surgeon:surgeon", PLACE)
    wall_s, _, _ = release.run("./test.sh", user=who == "user")
    text = release.log.read_text()[offset:]
    found = re.search(r"(\d+) tests passed, (\d+) tests failed out of (\d+)|(\d+)% tests passed, (\d+) tests failed out of (\d+)", text)
    release.row["tests"] = f"{found[0] if found else 'did not run'}; {who}, {wall_s / 60:.0f} min"
    return re.findall(r"^\s*\d+ - .*\((?:Failed|Skipped|Timeout|Not Run|SEGFAULT|Subprocess aborted)\).*$", text, re.M)


def table(rows):
    lines = [COLUMNS, ["---"] * len(COLUMNS), *([row[column] for column in COLUMNS] for row in rows)]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--folder", type=pathlib.Path, default=roots.ROOT / "build/roots")
    parser.add_argument("--tests", choices=["root", "user"])
    parser.add_argument("releases", nargs="*", default=RELEASES)
    options = parser.parse_args()
    roots.require("mmdebstrap", "unshare", "git")
    options.folder.mkdir(parents=True, exist_ok=True)
    rows, ok = [], True
    for name in options.releases:
        release = Release(name, options.folder.resolve())
        first_commands(release)
        said = sums(release)
        if options.tests:
            said += tests(release, options.tests)
        rusticl(release)  # a second platform, which the tests would meet
        print(f"\n{name}: {release.log}", *said, table([release.row]), sep="\n  ", flush=True)
        rows.append(release.row)
        ok = ok and not re.search("FAILED|did not run", " ".join(release.row.values()))
    print("\n" + table(rows))
    sys.exit(0 if ok else 1)


main()
