# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Main effects: closed forms, files, figure and the table on the terminal."""

import csv
import re
import subprocess
import sys

import numpy
import pytest
from reamsim.lab import effects, effects_figure
from reamsim.lab.effects import Column, main_effects, study_table, two_lines
from reamsim.lab.tables import draw_with_script

FORCE = "headline.peak_axial_force_n"
RESULTS = {FORCE: ("Peak axial force (N)", "N"), "removed_mm3": ("Removed volume (mm³)", "mm³"),
           "headline.depth_mm": ("Tool depth (mm)", "mm"), "energy_mj": ("Cutting energy (mJ)", "mJ")}


def parameter(key, cells, title="", shown=None):
    cells = [str(cell) for cell in cells]
    try:
        numbers = numpy.array([float(cell) for cell in cells])
    except ValueError:
        numbers = None
    return Column(key, title or key, cells, shown or [cell.split("/")[-1].removesuffix(".stl") for cell in cells], numbers)


def result(key, values, unit=""):
    title, known_unit = RESULTS.get(key, (key, unit))
    return Column(key, title, numbers=numpy.array(values, dtype=float), unit=known_unit)


def effect(effects, key, of_result):
    p = [one.column.key for one in effects.parameters].index(key)
    return effects.effects[p][[one.key for one in effects.results].index(of_result)]


def grid(samples, folder="tools/"):
    """Tools, depths and a sampled ratio k; the force is proportional to the length of the tool's name, depth and k."""
    random = numpy.random.RandomState(3)
    rows = [(name, depth, k) for name in ("flat", "convex", "hemispherical") for depth in (1, 2)
            for k in random.uniform(0.4, 0.6, samples)]
    force = [len(name) * depth * k for name, depth, k in rows]
    parameters = [parameter("tool.mesh", [f"{folder}reamer_{name}.stl" for name, _, _ in rows], "Tool mesh"),
                  parameter("motion.plunge.depth_mm", [depth for _, depth, _ in rows], "Plunge depth (mm)"),
                  parameter("cutting.normal_ratio", [k for _, _, k in rows], "Normal ratio")]
    return parameters, [result(FORCE, force), result("removed_mm3", [10.0 * depth for _, depth, _ in rows])]


def test_of_an_additive_model_are_its_terms():
    """y = 3·depth + b(tool) in a full grid: sums of squares are those of the terms."""
    depths, tools = [1, 1, 2, 2, 4, 4], ["a/reamer_flat.stl", "a/reamer_convex.stl"] * 3
    force = [3 * depth + 6 * ("convex" in tool) for depth, tool in zip(depths, tools)]
    found = main_effects([parameter("tool.mesh", tools), parameter("depth", depths)], [result(FORCE, force)])
    depth = effect(found, "depth", FORCE)
    assert [(group.x, group.mean, group.runs) for group in depth.groups] == [(1, 6, 2), (2, 9, 2), (4, 15, 2)]
    assert depth.groups[2].sd == pytest.approx(6 / 2 ** 0.5)
    # Variances of the terms: 9·(14/9) of the depth, 9 of the tool.
    assert depth.explained == pytest.approx(14 / 23) and effect(found, "tool.mesh", FORCE).explained == pytest.approx(9 / 23)
    assert [one.column.key for one in found.parameters] == ["depth", "tool.mesh"], "the dominant one first"
    assert [one.levels for one in found.parameters] == [["1", "2", "4"], ["flat", "convex"]], "in the order of the plan"


def test_of_sampled_parameters_are_means_over_intervals():
    """y = x + e with uniform x and e of the same variance; another parameter changes nothing."""
    x, other, e = numpy.random.RandomState(7).uniform(size=(3, 4000))
    found = main_effects([parameter("other", other), parameter("x", x)], [result(FORCE, x + e)])
    of_x = effect(found, "x", FORCE)
    assert [group.runs for group in of_x.groups] == [500] * 8
    assert all(group.mean == pytest.approx(group.x + 0.5, abs=0.06) and group.least < group.most for group in of_x.groups)
    assert of_x.explained == pytest.approx(0.5, abs=0.03), "half of the variance, less 1/64 within intervals"
    assert effect(found, "other", FORCE).explained < 0.005, "corrected for chance"


def test_leave_out_what_is_no_parameter():
    runs = range(24)
    parameters = [parameter("label", [f"P{i % 3}" for i in runs]), parameter("bone.ct.path", [f"p{i % 3}.nrrd" for i in runs]),
                  parameter("bone.glenoid.normal", [f"[0, 0.{i}, 1]" for i in runs]),
                  parameter("bone.glenoid.normal.tilt_1_deg", [0.01 * i for i in runs]),
                  parameter("bone.side", ["left"] * 24), parameter("name", [f"run {i}" for i in runs])]
    depth = [float("nan") if i == 4 else 0.1 * i for i in runs]
    found = main_effects(parameters, [result(FORCE, [i % 3 for i in runs]), result("removed_mm3", [5] * 24),
                                      result("headline.depth_mm", depth)])
    assert {one.column.key: one.also for one in found.parameters} == {"label": ["bone.ct.path"],
                                                                      "bone.glenoid.normal.tilt_1_deg": []}
    assert [one.key for one in found.results] == [FORCE, "headline.depth_mm"], "the volume does not vary"
    assert sum(group.runs for group in effect(found, "label", "headline.depth_mm").groups) == 23, "a missing value"


def test_rounding_is_no_variation():
    depth = [parameter("depth", [1, 2])]
    assert not main_effects(depth, [result(FORCE, [0.3, 0.1 + 0.2])])
    assert not main_effects(depth, [result("version", [5.01, 5.09], "°")]), "hundredths of a degree of a fitted face"
    one_each = main_effects(depth, [result("version", [5.0, 6.0], "°")])
    assert one_each and one_each.effects[0][0].groups[0].sd == 0
    assert not main_effects([parameter("depth", [])], [result(FORCE, [])])


def test_files_have_the_numbers(tmp_path):
    found = main_effects(*grid(20))
    effects.write_table(str(tmp_path), found)
    with open(tmp_path / "effects.csv", encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["parameter", "result", "level", "from", "to", "runs", "mean", "sd", "explained"]
    tool = [row for row in rows if row["parameter"] == "tool.mesh" and row["result"] == "removed_mm3"]
    assert [(row["level"], row["from"], row["runs"]) for row in tool] == [
        ("flat", "", "40"), ("convex", "", "40"), ("hemispherical", "", "40")]
    assert ["motion.plunge.depth_mm", "removed_mm3", "2", "2", "2", "60", "20", "0", "1"] in [list(row.values()) for row in rows]
    sampled = next(row for row in rows if row["parameter"] == "cutting.normal_ratio")
    assert sampled["level"] == "" and 0.4 < float(sampled["from"]) < float(sampled["to"]) < 0.6


def test_figure_and_script_draw_the_same(tmp_path):
    draw_with_script(effects_figure, effects.figure_data(main_effects(*grid(20))), str(tmp_path), "effects")
    names = [f"effects.{ending}" for ending in ("png", "svg", "pdf")]
    before = [(tmp_path / name).read_bytes() for name in names]
    svg = before[1].decode()
    assert all(text in svg for text in ("hemispherical", "Plunge depth (mm)", "Mean ± SD", "100 %"))
    for name in names:
        (tmp_path / name).unlink()
    subprocess.run([sys.executable, tmp_path / "effects.py"], check=True)
    assert [(tmp_path / name).read_bytes() for name in names] == before


def test_names_are_no_formulas_and_no_code(tmp_path):
    evil = ["$\\frac{1}{$", "it's \"\"\" + exit(1) + r\"\"\", \\n {name} %s"]
    found = main_effects([parameter("label", evil * 3, "$\\bad$ {0}")], [result("removed_mm3", range(6))])
    draw_with_script(effects_figure, effects.figure_data(found), str(tmp_path), "effects")
    png = (tmp_path / "effects.png").read_bytes()
    subprocess.run([sys.executable, tmp_path / "effects.py"], check=True)
    assert (tmp_path / "effects.png").read_bytes() == png
    assert "$\\bad$ {0}" in (tmp_path / "effects.svg").read_text(encoding="utf-8")


def test_figure_of_many_parameters_has_those_that_explain_most():
    x = numpy.random.RandomState(5).uniform(size=(12, 400))
    found = main_effects([parameter(f"number {p}", x[p]) for p in range(12)],
                         [result("removed_mm3", (x * numpy.arange(12)[:, None]).sum(axis=0))])
    data = effects.figure_data(found)
    titles = [one["title"] for one in data["parameters"]]
    assert len(titles) == 6 and {"number 11", "number 10", "number 9", "number 8"} < set(titles) and "number 1" not in titles
    assert len(data["results"][0]["y"]) == 300


def lines_of(parameters, results, width=100, states=None):
    runs = len(parameters[0].cells)
    states = states or ["done"] * runs
    done = [i for i, state in enumerate(states) if state == "done"]
    found = main_effects([one.of(done) for one in parameters], [one.of(done) for one in results])
    names = [f"{i + 1:2} {state}" for i, state in enumerate(states)]
    return study_table(names, runs, parameters, results, found, len(done), width)


def test_table_fits_the_terminal():
    for samples in (2, 5, 200):
        lines = lines_of(*grid(samples, "a_long_folder/with_a_very_long_name_of_a_reamer_"))
        assert len(lines) > 5 and all(len(line) <= 100 for line in lines), lines


def test_table_has_a_row_per_run_or_per_level():
    assert sum("done" in line for line in lines_of(*grid(2))) == 12
    lines = lines_of(*grid(10))
    assert any(re.match(r"Plunge depth \(mm\) +1 +30 ", line) for line in lines), lines
    assert any(re.match(r"all +60 .* ± ", line) for line in lines), lines


def test_table_of_a_sample_has_quantiles():
    x = [0.001 * i for i in range(101)]
    lines = lines_of([parameter("cutting.normal_ratio", x, "Normal ratio")], [result("removed_mm3", range(101))])
    # The deviation is 29.3: two digits of it leave no decimals.
    assert re.match(r"Removed volume .mm³. +5 +50 +95 +Normal ratio \(9[0-9] %\)", lines[-1]), lines
    assert not any("over all runs" in line for line in lines_of(*grid(1)))


def test_table_shortens_lists_legibly():
    lines = lines_of([parameter("bone.glenoid.center_mm", ["[-41.200000, 9.200000, 36.600000]",
                                                           "[4958.800000, 5009.200000, 5036.600000]"]),
                      parameter("label", ["a name of more than twenty-four letters", "short"])], [result("removed_mm3", [1, 2])])
    assert any("[-41.2, 9.2, 36.6]" in line and "a name of more than twe…" in line for line in lines), lines
    assert any("[4959, 5009, 5037]" in line for line in lines), lines


def test_table_of_equal_and_of_failed_runs():
    same = [parameter("label", ["A", "A"])], [result("removed_mm3", [12.5, 12.5])]
    assert sum("12.5" in line for line in lines_of(*same)) == 2
    assert lines_of([parameter("depth", [1])], [], states=["failed"]) == []
    mixed = lines_of([parameter("depth", [1, 2])], [result("removed_mm3", [1, float("nan")])], states=["done", "failed"])
    assert re.match(r" 2 failed +2 +-", mixed[-1]), mixed


def test_titles_on_two_lines():
    assert two_lines("Peak spin torque (N·mm)") == ("Peak spin", "torque (N·mm)")
    assert two_lines("Inclination") == ("", "Inclination")
