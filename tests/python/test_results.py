# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""reamsim.load(): what a folder holds, against what the run must give."""

import math
import shutil
import sys

import numpy
import pytest
import reamsim
import yaml
from conftest import ROOT

BLOCK_MM = (10, 10, 6)
DEPTH_MM = 1


def test_summary_forces_and_scenario_agree(small_run):
    forces, summary = small_run.force_array, small_run.summary
    assert len(forces) == summary["frames"]
    assert forces["removed_mm3"].sum() == pytest.approx(summary["removed_mm3"], rel=1e-9)
    assert forces["axial_force_n"].max() == summary["forces"]["peak_axial_force_n"]
    assert forces["frame"].dtype == numpy.int64 and forces["contacts"].dtype == numpy.int64
    assert small_run.scenario["motion"]["plunge"]["depth_mm"] == DEPTH_MM
    assert small_run.warnings == summary["warnings"]
    assert "small" in repr(small_run)


def test_the_table_is_the_same_with_and_without_pandas(small_run, monkeypatch):
    pandas = pytest.importorskip("pandas")
    frame = reamsim.load(small_run.dir).forces
    assert isinstance(frame, pandas.DataFrame)
    monkeypatch.setitem(sys.modules, "pandas", None)
    records = reamsim.load(small_run.dir).forces
    assert isinstance(records, numpy.recarray)
    assert list(frame.columns) == list(records.dtype.names)
    for name in frame.columns:
        assert frame[name].dtype == records[name].dtype
        assert numpy.array_equal(frame[name], records[name])


def test_grids_of_a_block(small_run):
    fill, density, voxel = small_run.fill, small_run.density, small_run.fill.voxel_mm
    assert voxel == 0.5
    bone = density.values > 0
    assert bone.sum() * voxel**3 == pytest.approx(math.prod(BLOCK_MM))
    assert density.values[bone] == pytest.approx(1.8) and density.unit == "g/cm³"
    assert fill.values.sum() * voxel**3 == pytest.approx(small_run.summary["bone"]["bone_after_mm3"], rel=1e-6)
    # The flat reamer takes the upper millimetre, except in its cannula: its axis is that of the block.
    assert fill.at([3.1, -3.1, -0.6]) == 0 and fill.at([3.1, -3.1, -1.4]) == 1
    assert fill.at([0.1, 0.1, -0.3]) == 1 and math.isnan(fill.at([0, 0, 400]))
    assert small_run.removed_frame.at([3.1, -3.1, -0.6]) > small_run.removed_frame.at([3.1, -3.1, -0.3]) > 0
    assert small_run.removed_frame.at([3.1, -3.1, -1.4]) == -1


def test_index_and_world(small_run):
    fill = small_run.fill
    assert fill.world_from_index([0, 0, 0]) == pytest.approx(fill.origin_mm)
    index = numpy.array([[1.0, 2.5, 3.0], [7.0, 0.0, 1.0]])
    assert fill.index_from_world(fill.world_from_index(index)) == pytest.approx(index)
    assert fill.centers_mm(2)[3] == pytest.approx(fill.world_from_index([0, 0, 3])[2])
    assert fill.extent_mm[0] == pytest.approx(fill.origin_mm[0] - 0.25)
    assert fill.extent_mm[5] - fill.extent_mm[4] == pytest.approx(0.5 * fill.values.shape[2])
    # The top of the block lies at z = 0 of the bone frame.
    bone = numpy.argwhere(small_run.density.values > 0)
    assert fill.world_from_index(bone.max(axis=0))[2] + 0.25 == pytest.approx(0)


def test_interpolation_is_exact_for_linear_values():
    x, y, z = numpy.meshgrid(numpy.arange(4.0), numpy.arange(5.0), numpy.arange(3.0), indexing="ij")
    grid = reamsim.Grid(1 + 2 * x - 3 * y + z, numpy.array([10.0, 20, 30]), 0.5)
    index = numpy.random.default_rng(1).uniform(0, [3, 4, 2], (50, 3))
    expected = 1 + index @ [2, -3, 1]
    assert grid.interpolated(grid.world_from_index(index)) == pytest.approx(expected)
    assert grid.interpolated(grid.world_from_index([3, 4, 2])) == pytest.approx(-3.0), "the last centre is inside"
    assert grid.interpolated(grid.world_from_index([0, 0, 0])) == 1
    assert numpy.isnan(grid.interpolated(grid.world_from_index([[-0.01, 0, 0], [0, 4.01, 0], [0, 0, 5]]))).all()


def test_grids_of_unequal_sides_keep_their_axes(small, tmp_path):
    """Read by two readers that share no code: OpenVDB, and this package's of the VTK file."""
    run = reamsim.run(small, tmp_path / "out", bone__phantom__size_mm=[10, 14, 30])
    remaining = run.remaining_density
    assert len(set(remaining.values.shape)) == 3, "a test of the order of axes needs three lengths"
    expected = run.density.values * run.fill.values
    assert remaining.values.shape == expected.shape
    assert abs(remaining.values - expected).max() < 1e-6
    assert remaining.origin_mm == pytest.approx(run.fill.origin_mm)


def test_remaining_density_without_the_vti(small_run, tmp_path):
    shutil.copytree(small_run.dir, tmp_path / "run")
    (tmp_path / "run/reamed.vti").unlink()
    assert abs(reamsim.load(tmp_path / "run").remaining_density.values - small_run.remaining_density.values).max() < 1e-6


def test_depth_map(small_run, glenoid_run):
    depth_map = small_run.depth_map
    assert depth_map.voxel_mm == 0.5 and depth_map.frame == "depth map"
    assert numpy.nanmax(depth_map.values) == pytest.approx(DEPTH_MM, abs=1e-3)
    assert depth_map.at([3.1, -3.1]) == pytest.approx(DEPTH_MM, abs=1e-3) and depth_map.at([0.1, 0.1]) == 0
    for run in (small_run, glenoid_run):
        depths = run.depth_map
        assert numpy.nansum(depths.values) * depths.voxel_mm**2 == pytest.approx(run.summary["removed_mm3"], rel=2e-3)
        both = ~numpy.isnan(depths.after_z_mm)
        assert (depths.before_z_mm - depths.after_z_mm)[both] == pytest.approx(depths.values[both], abs=2e-6)


def test_surface(glenoid_run, tmp_path):
    surface = glenoid_run.surface
    assert surface.volume_mm3 == pytest.approx(glenoid_run.summary["bone"]["bone_after_mm3"], rel=1e-4)
    assert surface.depth_mm.max() > 1 and len(surface.depth_mm) == len(surface.vertices)
    shutil.copytree(glenoid_run.dir, tmp_path / "run")
    (tmp_path / "run/reamed.glb").unlink()
    of_stl = reamsim.load(tmp_path / "run").surface
    assert of_stl.volume_mm3 == pytest.approx(surface.volume_mm3, rel=1e-9)
    assert len(of_stl.faces) == len(surface.faces) and of_stl.depth_mm is None
    assert of_stl.vertices.max(axis=0) == pytest.approx(surface.vertices.max(axis=0))


def test_results_of_an_older_version_are_read():
    old = reamsim.load(ROOT / "tests/cli/results_0_1_0/results")
    assert old.summary["program"] == "reamsim 0.1.0"
    assert old.force_array["removed_mm3"].sum() == pytest.approx(old.summary["removed_mm3"], rel=1e-9)
    assert (old.removed_frame.values > 0).any() and old.depth_map.values.size == 100


def test_the_scenario_runs_again(small_run, tmp_path):
    again = reamsim.run(small_run.scenario, tmp_path / "again")
    assert numpy.array_equal(again.force_array, small_run.force_array)


def test_every_shipped_scenario_is_read_as_yaml():
    """What PyYAML takes for a number, text or truth value, this package takes for one too, in what is shipped."""
    from reamsim.scenario_text import load_yaml

    for path in (ROOT / "trajectories").glob("*.yaml"):
        assert load_yaml(path.read_text()) == yaml.safe_load(path.read_text()), path
