# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Folders that are no run, and files that are missing or damaged."""

import json
import shutil
import sys

import pytest
import reamsim


@pytest.fixture
def copied(small_run, tmp_path):
    shutil.copytree(small_run.dir, tmp_path / "run")
    return tmp_path / "run"


def test_folders_that_are_no_run(tmp_path):
    (tmp_path / "file").write_text("")
    (tmp_path / "empty").mkdir()
    with pytest.raises(reamsim.ResultsError, match="none: no such folder"):
        reamsim.load(tmp_path / "none")
    with pytest.raises(reamsim.ResultsError, match="file: no such folder"):
        reamsim.load(tmp_path / "file")
    with pytest.raises(reamsim.ResultsError, match="empty: has no summary.json"):
        reamsim.load(tmp_path / "empty")


@pytest.mark.parametrize("text", ["", "{", "[]", "{}", '{"removed_mm3": 1}', "[" * 100000, '{"removed_mm3": 1, "forces"', "\0"])
def test_a_damaged_summary(copied, text):
    (copied / "summary.json").write_text(text)
    with pytest.raises(reamsim.ResultsError, match="summary.json: damaged"):
        reamsim.load(copied)


def test_a_summary_that_is_no_text(copied):
    (copied / "summary.json").write_bytes(b'{"removed_mm3": "\xff"}')
    with pytest.raises(reamsim.ResultsError, match="summary.json: damaged"):
        reamsim.load(copied)


FILES = {"forces": "forces.csv", "depth_map": "depth_map.csv", "fill": "reamed.vdb", "density": "reamed.vdb",
         "remaining_density": "reamed.vti", "surface": "reamed.glb", "scenario": "scenario.yaml"}


@pytest.mark.parametrize("attribute, name", FILES.items())
def test_missing_files(copied, attribute, name):
    for file in {name, "reamed.vdb" if name == "reamed.vti" else name, "reamed.stl" if name == "reamed.glb" else name}:
        (copied / file).unlink()
    run = reamsim.load(copied)
    with pytest.raises(reamsim.ResultsError, match="reamed|" + name):
        getattr(run, attribute)


@pytest.mark.parametrize("attribute, name", FILES.items())
@pytest.mark.parametrize("kept", [0, 3, 0.3, 0.999])
def test_files_cut_off(copied, attribute, name, kept):
    whole = (copied / name).read_bytes()
    (copied / name).write_bytes(whole[:kept if isinstance(kept, int) else int(kept * len(whole))])
    run = reamsim.load(copied)
    if name == "scenario.yaml" or (name == "forces.csv" and kept == 0.999) or (name == "depth_map.csv" and kept == 0.999):
        return  # YAML cut off may still be YAML, and a cut digit a number
    with pytest.raises(reamsim.ResultsError, match=name):
        getattr(run, attribute)


@pytest.mark.parametrize("attribute, name", FILES.items())
def test_files_of_other_bytes(copied, attribute, name):
    (copied / name).write_bytes(bytes(range(256)) * 40)
    run = reamsim.load(copied)
    with pytest.raises(reamsim.ResultsError, match=name):
        getattr(run, attribute)


@pytest.mark.parametrize("name", ["reamed.vti", "reamed.glb"])
def test_flipped_bytes_give_values_or_a_clear_error(copied, name):
    """One byte in 200 places: no other exception, no endless allocation."""
    attribute = {"reamed.vti": "remaining_density", "reamed.glb": "surface"}[name]
    whole = (copied / name).read_bytes()
    for place in range(200):
        data = bytearray(whole)
        data[place * 7 % min(len(data), 1400)] ^= 0x41
        (copied / name).write_bytes(data)
        try:
            getattr(reamsim.load(copied), attribute)
        except reamsim.ResultsError as error:
            assert name in str(error)


def test_a_forces_csv_of_other_columns(copied):
    (copied / "forces.csv").write_text("frame,time_s\n0,zero\n")
    with pytest.raises(reamsim.ResultsError, match="forces.csv: damaged.*zero"):
        reamsim.load(copied).forces
    (copied / "forces.csv").write_text("frame,time_s\n")
    with pytest.raises(reamsim.ResultsError, match="has no row"):
        reamsim.load(copied).forces


def test_a_depth_map_off_its_lattice(copied):
    (copied / "depth_map.csv").write_text("x_mm,y_mm,before_z_mm,after_z_mm,depth_mm\n0,0,0,0,0\n1,0,0,0,0\n2.3,0,0,0,0\n")
    with pytest.raises(reamsim.ResultsError, match="depth_map.csv: damaged.*regular grid"):
        reamsim.load(copied).depth_map


def test_optional_packages(copied, monkeypatch):
    run = reamsim.load(copied)
    for package in ("pyopenvdb", "openvdb", "matplotlib"):
        monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(reamsim.MissingPackage, match="pyopenvdb.*python3-openvdb"):
        run.fill
    assert run.remaining_density.values.max() == pytest.approx(1.8)
    with pytest.raises(reamsim.MissingPackage, match="matplotlib.*python3-matplotlib"):
        run.plot_forces()
    assert issubclass(reamsim.MissingPackage, ImportError)


def test_a_run_without_results_of_the_end(copied):
    """As a checkpoint leaves them: a summary that says so, and no grids."""
    summary = json.loads((copied / "summary.json").read_text())
    summary["finished"] = False
    (copied / "summary.json").write_text(json.dumps(summary))
    (copied / "reamed.vdb").unlink()
    run = reamsim.load(copied)
    assert len(run.forces) > 0
    with pytest.raises(reamsim.ResultsError, match="reamed.vdb: no such file"):
        run.fill
