# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""The programs in docs/examples/python, against closed forms, and what a step costs."""

import math
import pathlib
import re
import subprocess
import sys

import pytest
import yaml
from conftest import ROOT


def output_of(example, *arguments):
    path = ROOT / "docs/examples/python" / example
    done = subprocess.run([sys.executable, str(path), *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def numbers_in(*patterns, text):
    return [float(re.search(pattern, text, re.MULTILINE)[1]) for pattern in patterns]


def scenario_of(block, folder: pathlib.Path):
    path = folder / "scenario.yaml"
    path.write_text(yaml.safe_dump({"version": 2, **block}))
    return path


def test_the_force_controlled_example_holds_its_force(block, tmp_path):
    block["motion"]["plunge"]["feed_mm_s"] = 5
    said = output_of("constant_force.py", scenario_of(block, tmp_path), 5, 1.2)
    depth_mm, mean_n, deviation_n = numbers_in(r"^(\S+) mm deep", r"mean (\S+) N", r"deviation (\S+) N", text=said)
    assert depth_mm >= 1.2 and mean_n == pytest.approx(5, rel=0.02) and deviation_n < 0.5


def test_the_impedance_example_deviates_as_its_spring(block, tmp_path):
    """While the plan dwells, nothing moves, so the spring holds nothing; in the feed it holds the force of the bone."""
    block["motion"]["plunge"]["dwell_s"] = 0.5
    soft, hard = (numbers_in(r"most force (\S+) N", r"deviation from the plan (\S+) mm", text=output_of(
        "impedance.py", scenario_of(block, tmp_path), stiffness_n_mm, 2)) for stiffness_n_mm in (20, 200))
    for (force_n, lag_mm), stiffness_n_mm in ((soft, 20), (hard, 200)):
        assert lag_mm == pytest.approx(force_n / stiffness_n_mm, rel=0.1)
    assert soft[0] < hard[0] and soft[1] > 3 * hard[1]


def test_the_search_finds_the_axis_normal_to_a_plane(block, tmp_path):
    """On a plane the best axis of a sphere is the normal, and the bone a cap that reaches the rim of the footprint."""
    block["bone"].update(phantom={"shape": "half_space", "density_g_cm3": 0.6, "size_mm": [36, 36, 10]})
    block["motion"]["plunge"].update(axis=[0.12, 0, -1])
    path = scenario_of(block, tmp_path)
    said = output_of("least_bone.py", path, 30, 7)
    assert said.startswith("seed 7; planned axis: ")
    planned_mm3, best_mm3, about_x, about_y = numbers_in(
        r"planned axis: (\S+) mm3", r"best axis: (\S+) mm3", r"tilted by (\S+) and", r"and (\S+) degrees", text=said)
    depth_mm = 29 - math.sqrt(29**2 - 10**2) - 0.5
    cap_mm3 = math.pi * depth_mm**2 * (3 * 29 - depth_mm) / 3
    assert cap_mm3 < best_mm3 < 1.25 * cap_mm3 < planned_mm3 / 3
    assert math.hypot(about_x, abs(about_y) - math.degrees(math.atan(0.12))) < 1


def test_the_cost_of_a_step_is_measured():
    """docs/python.md has the figures. A call from Python costs less than a step in the bone."""
    done = subprocess.run([sys.executable, str(ROOT / "tests/bench/step_cost.py"), "300"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    out_us, in_us = numbers_in(r"out of the bone: step\(\) (\S+) us", r"in the bone: step\(\) (\S+) us", text=done.stdout)
    assert out_us < 0.5 * in_us
