# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""library_example.py BUILD EXAMPLE SCENARIO: the installed library builds a program outside the tree, with CMake and with
pkg-config, and the program reams."""

import os
import pathlib
import re
import subprocess
import sys
import tempfile

BUILD, EXAMPLE, SCENARIO = (pathlib.Path(argument).resolve() for argument in sys.argv[1:4])


def output_of(*command, **more):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, **more)
    assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
    return done.stdout


def removed_by(program):
    said = output_of(program, SCENARIO, 1.0)
    travel = [float(value) for value in re.findall(r"travel ([0-9.]+) mm", said)]
    assert travel == sorted(travel) and travel[-1] > 0.3, said
    removed = float(re.search(r"removed ([0-9.]+) mm3", said)[1])
    assert removed > 1, said
    return removed


def accepts(version_file, own, wanted):
    """Whether an installed library of a version is one that find_package(reamsim WANTED) takes."""
    (folder / "version.cmake").write_text(re.sub(r"(?<![\d.])\d+\.\d+\.\d+(?![\d.])", own, version_file.read_text()))
    (folder / "ask.cmake").write_text(f"""set(PACKAGE_FIND_VERSION {wanted})
string(REGEX MATCH "^([0-9]+)" PACKAGE_FIND_VERSION_MAJOR {wanted})
set(CMAKE_SIZEOF_VOID_P 8)
include({folder}/version.cmake)
message(STATUS "compatible: ${{PACKAGE_VERSION_COMPATIBLE}}")
""")
    return "compatible: TRUE" in output_of("cmake", "-P", folder / "ask.cmake")


with tempfile.TemporaryDirectory() as folder:
    folder = pathlib.Path(folder)
    prefix = folder / "prefix"
    output_of("cmake", "--install", BUILD, "--prefix", prefix)
    output_of("cmake", "-S", EXAMPLE, "-B", folder / "built", f"-DCMAKE_PREFIX_PATH={prefix}", "-DCMAKE_BUILD_TYPE=Release")
    output_of("cmake", "--build", folder / "built")
    by_cmake = removed_by(folder / "built/impedance")
    (pc,) = prefix.rglob("reamsim.pc")
    flags = output_of("pkg-config", "--cflags", "--libs", "reamsim", env={**os.environ, "PKG_CONFIG_PATH": str(pc.parent)})
    output_of("c++", "-std=c++20", "-O1", EXAMPLE / "impedance.cpp", "-o", folder / "by_pkg_config", *flags.split())
    assert removed_by(folder / "by_pkg_config") == by_cmake
    # What docs/stability.md promises: the same major version.
    (version_file,) = prefix.rglob("reamsimConfigVersion.cmake")
    assert accepts(version_file, "1.7.2", "1.0") and accepts(version_file, "1.0.0", "1.0.0")
    assert not accepts(version_file, "2.0.0", "1.0") and not accepts(version_file, "1.0.0", "1.1")
    mistake = subprocess.run([str(folder / "built/impedance"), "none.yaml", "1"], capture_output=True, text=True)
    assert mistake.returncode == 1 and "none.yaml" in mistake.stderr, mistake.stderr
print(f"removed {by_cmake} mm3")
