# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""debian_packages.py BUILD ROOT: `cpack -G DEB` makes three packages that lintian finds nothing in, with files at the places of
the FHS and with what is needed at run time."""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

BUILD, ROOT = (pathlib.Path(argument).resolve() for argument in sys.argv[1:3])
VERSION = re.search(r"project\(reamsim VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1] + "-1"
# A file of each kind, as a pattern of its whole path.
PLACES = {
    "reamsim": ["usr/bin/reamsim", "usr/share/reamsim/assets/reamer_convex.stl", "usr/share/reamsim/assets/scenario.schema.json",
                "usr/share/reamsim/trajectories/default.yaml", "usr/share/reamsim/trajectories/studies/reamers.yaml",
                "usr/share/reamsim/python/src/reamsim/lab/fit.py", "usr/share/doc/reamsim/docs/keys.md", "usr/share/doc/reamsim/docs/examples/library/impedance.cpp"],
    "libreamsim-dev": ["usr/include/reamsim/simulation.h", r"usr/lib/[^/]+-linux-gnu/reamsim/libsim_api\.a",
                       r"usr/lib/[^/]+-linux-gnu/cmake/reamsim/reamsimConfig\.cmake", r"usr/lib/[^/]+-linux-gnu/pkgconfig/reamsim\.pc"],
    "python3-reamsim": [r"usr/lib/python3/dist-packages/reamsim/__init__\.py",
                        r"usr/lib/python3/dist-packages/reamsim/_simulation\.cpython-3\d+-\S+\.so"],
}
# Mesa has no OSMesa since 25.1.
OFFSCREEN = "libosmesa6" if subprocess.run("ldconfig -p | grep -q libOSMesa", shell=True).returncode == 0 else "libegl1"
NEEDS = {
    "reamsim": ["libc6", "libopenvdb", "libinsighttoolkit5", "pocl-opencl-icd | opencl-icd", "gnuplot-nox | gnuplot",
                "fonts-dejavu-core", "python3-scipy", "python3-matplotlib", OFFSCREEN],
    "libreamsim-dev": ["libopenvdb-dev", "libinsighttoolkit5-dev", "libseccomp-dev", "pkgconf | pkg-config"],
    "python3-reamsim": ["python3-numpy", "python3-yaml", f"reamsim (= {VERSION})", "python3 (<< 3."],
}


def output_of(*command):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
    return done.stdout


def check_links(file, folder):
    """Links of the documents lead to files of the package, pictures too."""
    output_of("dpkg-deb", "-x", file, folder)
    links = [(page, link) for page in folder.rglob("*.md")
             for link in re.findall(r"\]\(([^)#\s]+)|(?<=src=\")([^\"]+)", page.read_text()) for link in link if link]
    assert any(link.endswith(".png") for _, link in links) and any(link.endswith(".md") for _, link in links), links
    for page, link in links:
        assert "://" in link or (page.parent / link).exists(), f"{page}: {link}"


def check_licences(folder):
    """The pictures of public data have licences of their own, whose whole texts `copyright` contains, in its format."""
    text = (folder / "usr/share/doc/reamsim/copyright").read_text()
    for name in ("CC-BY-3.0", "CC-BY-SA-3.0"):
        found, = [part for part in text.split("\n\n") if part.startswith(f"License: {name}\n")]
        lines = found.rstrip().split("\n")[1:]
        assert all(line.startswith(" ") for line in lines), lines
        said = " ".join(line for line in lines if line != " .").split()
        assert said == (ROOT / f"LICENSES/{name}.txt").read_text().split(), name


def check(package, file):
    listed = [line.split(maxsplit=5) for line in output_of("dpkg-deb", "-c", file).splitlines()]
    names = [fields[5].removeprefix("./") for fields in listed]
    documents = f"usr/share/doc/{package}"
    for place in [*PLACES[package], *(f"{documents}/{name}" for name in ("copyright", "changelog.gz", "changelog.Debian.gz"))]:
        assert any(re.fullmatch(place, name) for name in names), f"{package} has no {place}"
    assert not [name for name in names if name and not name.startswith("usr")], names
    assert {fields[1] for fields in listed} == {"root/root"}
    assert not [fields for fields in listed if "w" in fields[0][4:] and not fields[0].startswith("l")], "others could write"
    needs = output_of("dpkg-deb", "-f", file, "Depends")
    for need in NEEDS[package]:
        assert need in needs, f"{package} needs no {need}: {needs}"
    assert not re.search(r"\b(g\+\+|gcc|clang|cmake|ninja)", needs), needs  # libgcc-s1 is a library


os.umask(0o002)  # as ordinary users have it: permissions in the packages must not depend on it
with tempfile.TemporaryDirectory() as folder:
    # gzip takes less time than xz, and packs the same files.
    output_of("cpack", "--config", BUILD / "CPackConfig.cmake", "-B", folder, "-G", "DEB", "-D", "CPACK_DEBIAN_COMPRESSION_TYPE=gzip")
    files = {package: next(pathlib.Path(folder).glob(f"{package}_{VERSION}_*.deb")) for package in PLACES}
    for name, path in files.items():
        check(name, path)
    check_links(files["reamsim"], pathlib.Path(folder) / "reamsim")
    check_licences(pathlib.Path(folder) / "reamsim")
    found = subprocess.run(["lintian", "--allow-root", "--fail-on", "error,warning", "--tag-display-limit", "0", *files.values()],
                           capture_output=True, text=True)
    assert found.returncode == 0 and not found.stdout.strip(), found.stdout + found.stderr
    print(*(f"{path.name}: {path.stat().st_size / 1e6:.1f} MB" for path in files.values()), sep="\n")
