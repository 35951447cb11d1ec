# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""The package as `cmake --install` and pip install it: used from elsewhere, without this checkout."""

import os
import pathlib
import re
import shutil
import subprocess
import sys

import pytest
from conftest import ROOT

BUILD = os.environ["REAMSIM_BUILD"]
VERSION = re.search(r"project\(reamsim VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text())[1]

USE = """
import importlib.metadata, pathlib, sys, reamsim
print(reamsim.__file__)
print(reamsim.__version__, importlib.metadata.version("reamsim"))
print(reamsim.find_program())
print((pathlib.Path(reamsim.__file__).parent / "py.typed").exists())
run = reamsim.run({"bone": {"source": "phantom", "voxel_mm": 0.5, "phantom": {"shape": "half_space", "size_mm": [9, 9, 6]}},
                   "tool": {"mesh": sys.argv[1]}, "motion": {"frame_rate_hz": 50, "plunge": {"feed_mm_s": 9, "depth_mm": 1}},
                   "render": {"enabled": False}, "engine": {"device": "serial"}}, "out")
print(run.summary["removed_mm3"] > 50, run.fill.values.shape)
"""

IN_PROCESS = """
import sys, reamsim
try:
    simulation = reamsim.Simulation(
        {"bone": {"source": "phantom", "voxel_mm": 0.5, "phantom": {"shape": "half_space", "size_mm": [9, 9, 6]}},
         "tool": {"mesh": sys.argv[1]}, "motion": {"frame_rate_hz": 50, "plunge": {"feed_mm_s": 9, "depth_mm": 1}},
         "engine": {"device": "serial"}})
    simulation.run(simulation.planned_poses())
    print(simulation.removed_mm3 > 50)
    print(sys.modules["reamsim._simulation"].__file__)
except reamsim.ProgramNotFound as error:
    print(error)
"""


def used(python, folder, environment, code=USE):
    """What the package says of itself in another folder."""
    (folder / "elsewhere").mkdir(exist_ok=True)
    clean = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "REAMSIM"))}
    done = subprocess.run([python, "-c", code, str(ROOT / "assets/reamer_flat.stl")], cwd=folder / "elsewhere",
                          env={**clean, **environment}, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_cmake_installs_the_package_beside_the_program(tmp_path):
    prefix = tmp_path / "prefix"
    subprocess.run(["cmake", "--install", BUILD, "--prefix", str(prefix)], check=True, stdout=subprocess.DEVNULL)
    package = prefix / os.environ["REAMSIM_PYTHON_DIR"]
    said = used(sys.executable, tmp_path, {"PYTHONPATH": str(package)})
    assert said[0] == str(package / "reamsim/__init__.py")
    assert said[1] == f"{VERSION} {VERSION}"
    assert said[2] == str(prefix / "bin/reamsim"), "the program of the same prefix"
    assert said[3] == "True" and said[4].startswith("True")
    installed, path = used(sys.executable, tmp_path, {"PYTHONPATH": str(package)}, IN_PROCESS)
    assert installed == "True" and pathlib.Path(path).parent == package / "reamsim"
    assert not list(prefix.rglob("__pycache__")) or not list((ROOT / "python").rglob("__pycache__"))


def test_debian_finds_the_package_under_usr_and_usr_local():
    """Without PYTHONPATH: the folder is on the path of Debian's Python for both prefixes."""
    known = subprocess.run(["/usr/bin/python3", "-c", "import sys; print(*sys.path, sep='\\n')"], check=True,
                           env={"PATH": "/usr/bin"}, capture_output=True, text=True).stdout.splitlines()
    for prefix in ("/usr", "/usr/local"):
        folder = f"{prefix}/{os.environ['REAMSIM_PYTHON_DIR']}"
        if not pathlib.Path(folder).is_dir():
            pytest.skip(f"{folder} does not exist here, so Python does not list it")
        assert folder in known


def test_pip_installs_the_package_without_a_network(tmp_path):
    checkout = tmp_path / "checkout"
    checkout.mkdir()
    shutil.copy(ROOT / "CMakeLists.txt", checkout)
    shutil.copytree(ROOT / "python", checkout / "python", ignore=shutil.ignore_patterns("__pycache__", "*.egg-info", "build"))
    subprocess.run(["/usr/bin/python3", "-m", "venv", "--system-site-packages", str(tmp_path / "venv")], check=True)
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTHON")}
    done = subprocess.run([str(tmp_path / "venv/bin/pip"), "install", "--no-build-isolation", "--no-index", "-q", "./python"],
                          cwd=checkout, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr
    shutil.rmtree(checkout)
    said = used(str(tmp_path / "venv/bin/python"), tmp_path, {"REAMSIM_PROGRAM": os.environ["REAMSIM_PROGRAM"]})
    assert said[0].startswith(str(tmp_path / "venv/lib"))
    assert said[1] == f"{VERSION} {VERSION}"
    assert said[3] == "True" and said[4].startswith("True")
    python = str(tmp_path / "venv/bin/python")
    built, path = used(python, tmp_path, {"REAMSIM_PROGRAM": os.environ["REAMSIM_PROGRAM"]}, IN_PROCESS)
    assert built == "True" and pathlib.Path(path).parent == pathlib.Path(BUILD, "python"), "the one built with the program"
    other = tmp_path / "cli/reamsim"
    other.parent.mkdir()
    other.write_text("#!/bin/sh\n")
    other.chmod(0o755)
    (message,) = used(python, tmp_path, {"REAMSIM_PROGRAM": str(other)}, IN_PROCESS)
    assert message.startswith("reamsim.Simulation needs the module _simulation") and "./run.sh" in message
    assert str(tmp_path / "python") in message, "it says where it searched"
