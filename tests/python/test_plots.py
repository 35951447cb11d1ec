# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Figures: what is drawn is what the files hold."""

import types

import numpy
import pytest
import reamsim
from reamsim import plots

pytest.importorskip("matplotlib")


def run_of(depth, force, dt=0.01):
    """A run of a plunge with these depths (mm) and forces (N); contact where the force is not 0."""
    rows = numpy.zeros(len(depth), dtype=[(name, float) for name in (
        "time_s", "depth_mm", "axial_force_n", "spin_torque_nmm", "removed_mm3", "contacts")])
    rows["time_s"], rows["depth_mm"], rows["axial_force_n"] = dt * numpy.arange(len(depth)), depth, force
    rows["removed_mm3"] = rows["contacts"] = rows["axial_force_n"] != 0
    return types.SimpleNamespace(force_array=rows, summary={"scenario": "made"})


def test_curves_begin_at_contact_and_end_at_the_greatest_depth():
    run = run_of([0, 0, 0, 1, 2, 2 + 1e-9, 1], [0, 0, 5, 7, 8, 0, 0])
    x, y = plots.curve(run, "axial_force_n")
    assert list(x) == [0, 1, 2] and list(y) == [5, 7, 8]
    x, y = plots.curve(run, "axial_force_n", "time")
    assert x == pytest.approx([0, 0.01, 0.02, 0.03, 0.04]) and list(y) == [0, 5, 7, 8, 0]
    assert list(plots.curve(run, "removed_mm3")[1]) == [1, 2, 3]


def test_a_run_without_contact_draws_empty_curves():
    run = run_of([0, 0], [0, 0])
    assert plots.curve(run, "axial_force_n")[0].size == 0
    plots.plot_forces(run).savefig("/dev/null", format="png")
    with pytest.raises(ValueError, match="no run with contact"):
        plots.bands([run])


def test_unknown_columns_and_axes_are_refused(small_run):
    with pytest.raises(ValueError, match="no such column"):
        plots.curve(small_run, "axial_force")
    with pytest.raises(ValueError, match="expected 'time' or 'depth'"):
        small_run.plot_forces("frames")


def test_bands_are_percentiles_over_runs():
    """Forces u * (1 + depth) with u = 1 ... 101, of runs with other steps and other depths."""
    runs = []
    for u in range(1, 102):
        depth = numpy.concatenate([[0], numpy.linspace(0, 2 + u % 3, 40 + u % 7)])
        runs.append(run_of(depth, numpy.concatenate([[0], u * (1 + depth[1:])])))
    x, (low, middle, high) = plots.bands(runs)
    assert x[0] == 0 and x[-1] == 2
    assert low == pytest.approx(6 * (1 + x)) and middle == pytest.approx(51 * (1 + x))
    assert high == pytest.approx(96 * (1 + x))


def test_figures_show_the_files(glenoid_run, tmp_path):
    figure = glenoid_run.plot_forces("depth")
    assert [axes.get_ylabel() for axes in figure.axes] == ["Axial force (N)", "Spin torque (N·mm)",
                                                           "Removed volume (mm³)"]
    _, y = figure.axes[2].lines[0].get_data()
    assert y[-1] == pytest.approx(glenoid_run.summary["removed_mm3"], rel=0.02)
    x, y = figure.axes[0].lines[0].get_data()
    assert y.max() == pytest.approx(glenoid_run.summary["forces"]["peak_axial_force_n"], rel=0.05)
    assert x[-1] == pytest.approx(glenoid_run.summary["max_depth_mm"], abs=1e-5)
    assert figure.axes[2].get_xlabel() == "Tool depth (mm)"
    for number, made in enumerate([figure, glenoid_run.plot_forces(), glenoid_run.plot_depth_map(),
                                   reamsim.plot_bands([glenoid_run, glenoid_run], over="time")]):
        made.savefig(tmp_path / f"{number}.png")
        assert (tmp_path / f"{number}.png").stat().st_size > 10000
        assert made._repr_png_().startswith(b"\x89PNG"), "a notebook shows it"


def test_the_depth_map_lies_where_the_file_says(glenoid_run):
    axes = glenoid_run.plot_depth_map().axes[0]
    image = axes.images[1]
    depth_map = glenoid_run.depth_map
    assert tuple(image.get_extent()) == pytest.approx(depth_map.extent_mm)
    drawn = image.get_array()
    assert numpy.array_equal(drawn.filled(0), numpy.nan_to_num(depth_map.values).T), "a row of the picture is a y"
