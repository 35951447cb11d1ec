# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""reamsim.sweep() and the folder of a study: DIR/runs.csv and DIR/runs/ID/."""

import shutil
import sys

import numpy
import pytest
import reamsim
import yaml

TABLE = """run,id,status,message,bone.voxel_mm,tool.mesh,removed_mm3,forces.peak_force_n
1,0012,done,,0.5,a.stl,96.5,800
2,1e5,failed,"no OpenCL, sorry",0.4,b.stl,,
3,ab34,done,,0.3,a.stl,97.25,810.5
"""


@pytest.fixture
def study(small_run, tmp_path):
    folder = tmp_path / "study"
    for name in ("0012", "ab34"):
        shutil.copytree(small_run.dir, folder / "runs" / name)
    (folder / "runs.csv").write_text(TABLE)
    return folder


@pytest.mark.parametrize("with_pandas", [True, False])
def test_the_table(study, with_pandas, monkeypatch):
    if not with_pandas:
        monkeypatch.setitem(sys.modules, "pandas", None)
    sweep = reamsim.load_sweep(study)
    runs = sweep.runs
    assert list(runs["id"]) == ["0012", "1e5", "ab34"], "an id is a text"
    assert list(runs["run"]) == [1, 2, 3]
    assert list(runs["status"]) == ["done", "failed", "done"]
    assert list(runs["message"]) == ["", "no OpenCL, sorry", ""]
    assert list(runs["tool.mesh"]) == ["a.stl", "b.stl", "a.stl"]
    assert runs["bone.voxel_mm"].dtype == numpy.float64
    assert numpy.array_equal(runs["removed_mm3"], [96.5, numpy.nan, 97.25], equal_nan=True)
    names = runs.dtype.names if not with_pandas else list(runs.columns)
    assert list(names) == TABLE.splitlines()[0].split(",")


def test_runs_of_a_study(study, small_run):
    sweep = reamsim.load_sweep(study)
    assert len(sweep) == 3 and "3 runs" in repr(sweep)
    assert sweep.run("0012").summary == small_run.summary
    assert [run.dir.name for run in sweep] == ["0012", "ab34"], "a run that failed has no results"
    with pytest.raises(reamsim.ResultsError, match="failed: no OpenCL, sorry"):
        sweep.run("1e5")
    with pytest.raises(reamsim.ResultsError, match="has no run ../0012"):
        sweep.run("../0012")


def test_folders_that_are_no_study(study, tmp_path):
    with pytest.raises(reamsim.ResultsError, match="no such folder"):
        reamsim.load_sweep(tmp_path / "none")
    with pytest.raises(reamsim.ResultsError, match="has no runs.csv.*collect"):
        reamsim.load_sweep(study / "runs")
    for text, message in (("", "no header"), ("a,b\n1,2\n", "no column run"), (TABLE + "4,5\n", "row 5 has 2 cells"),
                          (TABLE.replace("\n3,", "\nthree,"), "column run")):
        (study / "runs.csv").write_text(text)
        with pytest.raises(reamsim.ResultsError, match=f"runs.csv: damaged.*{message}"):
            reamsim.load_sweep(study)


def test_an_empty_study(study):
    (study / "runs.csv").write_text(TABLE.splitlines()[0] + "\n")
    sweep = reamsim.load_sweep(study)
    assert len(sweep) == 0 and len(sweep.runs) == 0 and list(sweep) == []


def test_a_study_is_run_and_collected(study, fake_program, tmp_path, monkeypatch):
    fake_program(f'echo "$@" >>{tmp_path}/calls; exit 0')
    sweep = reamsim.sweep("my.yaml", study, jobs=2)
    assert (tmp_path / "calls").read_text().splitlines() == [f"sweep run my.yaml -o {study} --jobs 2",
                                                             f"sweep collect my.yaml -o {study}"]
    assert len(sweep.runs) == 3
    monkeypatch.chdir(tmp_path)
    (tmp_path / "out").mkdir()
    shutil.move(study, tmp_path / "out/my")
    assert len(reamsim.sweep("sub/my.yaml")) == 3
    assert (tmp_path / "calls").read_text().splitlines()[2] == "sweep run sub/my.yaml -o out/my"


def test_a_wrong_study(fake_program):
    fake_program('echo "reamsim: error: my.yaml:3:1: vary: wrong" >&2; exit 2')
    with pytest.raises(reamsim.InputError, match="^my.yaml:3:1: vary: wrong$"):
        reamsim.sweep("my.yaml")


def test_a_study_of_the_program(small, tmp_path):
    """With the real command: two runs, and one whose scenario is wrong."""
    (tmp_path / "base.yaml").write_text(yaml.safe_dump({"version": 2, **small}))
    (tmp_path / "my.yaml").write_text(yaml.safe_dump({
        "version": 1, "base": "base.yaml", "vary": [{"motion.plunge.depth_mm": [0.5, 1, -7]}], "keep": ["summary", "forces"]}))
    with pytest.warns(reamsim.ReamsimWarning, match="depth_mm"):
        sweep = reamsim.sweep(tmp_path / "my.yaml", tmp_path / "out", jobs=2)
    assert sweep.statuses == ["done", "done", "failed"]
    assert list(sweep.runs["motion.plunge.depth_mm"]) == [0.5, 1, -7]
    assert "depth_mm" in list(sweep.runs["message"])[2]
    removed = sweep.runs["removed_mm3"]
    assert removed[1] == pytest.approx(2 * removed[0], rel=1e-3), "a flat reamer in a block"
    runs = list(sweep)
    assert len(runs) == 2
    assert runs[0].force_array["removed_mm3"].sum() == pytest.approx(removed[0], rel=1e-9)
    assert runs[1].scenario["motion"]["plunge"]["depth_mm"] == 1
    depth_mm, force_n = reamsim.plots.bands(sweep)
    assert depth_mm[-1] == pytest.approx(0.5) and force_n.min() > 0


def test_a_study_that_fails_as_a_whole(study, fake_program):
    fake_program('[ "$2" = run ] && { echo "reamsim: error: No space left" >&2; exit 1; }; exit 0')
    (study / "runs.csv").write_text(TABLE.replace("3,ab34,done", "3,ab34,missing"))
    with pytest.raises(reamsim.RunError, match="No space left"):
        reamsim.sweep("my.yaml", study)
