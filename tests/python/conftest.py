# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Runs that the tests share."""

import copy
import pathlib
import warnings

import pytest
import reamsim

ROOT = pathlib.Path(__file__).resolve().parents[2]

# A flat reamer of 12 mm radius, and more, over a block of 10 x 10 mm: every column loses the depth of the plunge.
SMALL = {
    "bone": {"source": "phantom", "voxel_mm": 0.5, "phantom": {"shape": "half_space", "size_mm": [10, 10, 6]}},
    "tool": {"mesh": str(ROOT / "assets/reamer_flat.stl")},
    "motion": {"frame_rate_hz": 100,
               "plunge": {"approach_mm": 0.5, "feed_mm_s": 5, "depth_mm": 1, "retract_mm": 2, "retract_mm_s": 20}},
    "render": {"enabled": False},
    "output": {"plots": False},
    "engine": {"device": "serial"},
}

# A convex reamer in a block; slow enough for windows of smooth motion.
BLOCK = {
    "bone": {"source": "phantom", "voxel_mm": 0.5,
             "phantom": {"shape": "half_space", "density_g_cm3": 0.6, "size_mm": [20, 20, 6]}},
    "tool": {"mesh": str(ROOT / "assets/reamer_convex.stl")},
    "motion": {"frame_rate_hz": 500,
               "plunge": {"approach_mm": 0.2, "depth_mm": 1, "feed_mm_s": 2, "dwell_s": 0.05, "retract_mm": 2,
                          "retract_mm_s": 20}},
    "render": {"enabled": False},
    "output": {"meshes": False, "vti": False, "plots": False},
}


@pytest.fixture
def small():
    return copy.deepcopy(SMALL)


@pytest.fixture
def block():
    return copy.deepcopy(BLOCK)


@pytest.fixture(scope="session")
def small_run(tmp_path_factory):
    return reamsim.run(SMALL, tmp_path_factory.mktemp("runs") / "small")


@pytest.fixture(scope="session")
def glenoid_run(tmp_path_factory):
    """A convex reamer on a coarse glenoid phantom."""
    folder = tmp_path_factory.mktemp("runs") / "glenoid"
    return reamsim.run(ROOT / "tests/e2e/small.yaml", folder, render__enabled=False)


@pytest.fixture
def fake_program(tmp_path, monkeypatch):
    """Makes a shell script the program, and returns the path of its text."""

    def make(script):
        path = tmp_path / "fake_reamsim"
        path.write_text("#!/bin/sh\n" + script)
        path.chmod(0o755)
        monkeypatch.setenv("REAMSIM_PROGRAM", str(path))
        return path

    return make


@pytest.fixture(autouse=True)
def warnings_of_the_program_are_seen():
    """An unexpected warning of the program fails the test."""
    with warnings.catch_warnings():
        warnings.simplefilter("error", reamsim.ReamsimWarning)
        yield
