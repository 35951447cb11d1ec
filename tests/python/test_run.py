# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""reamsim.run(): scenarios, overrides and errors."""

import os
import pathlib
import signal
import subprocess
import sys
import time
import warnings

import numpy
import pytest
import reamsim
import yaml
from conftest import ROOT, SMALL
from reamsim.scenario_text import flow_text, load_yaml, scenario_text


def test_a_scenario_may_be_a_path_or_a_dict(small, small_run, tmp_path):
    path = tmp_path / "from file.yaml"
    path.write_text(yaml.safe_dump({"version": 2, **small}))
    run = reamsim.run(path, tmp_path / "out")
    assert numpy.array_equal(run.force_array, small_run.force_array)
    assert run.summary["scenario"] == "from file"
    assert small_run.summary["scenario"] == "scenario"


def test_overrides_change_keys(small, tmp_path):
    run = reamsim.run(small, tmp_path / "out", {"cutting.specific_energy_j_mm3": numpy.float64(1e-1)},
                      bone__voxel_mm=1, motion__plunge__entry_mm=numpy.array([0, 0, 0.25]), bone__side=None,
                      name="no: 7")
    assert run.scenario["cutting"]["specific_energy_j_mm3"] == 0.1
    assert run.scenario["bone"]["voxel_mm"] == 1
    assert run.scenario["motion"]["plunge"]["entry_mm"] == [0, 0, 0.25]
    assert run.scenario["name"] == "no: 7"


def test_paths_of_a_dict_are_relative_to_the_current_folder(small, tmp_path, monkeypatch):
    (tmp_path / "reamer.stl").symlink_to(ROOT / "assets/reamer_flat.stl")
    monkeypatch.chdir(tmp_path)
    small["tool"]["mesh"] = "reamer.stl"
    small["output"] = {"dir": "made here"}
    run = reamsim.run(small)
    assert run.dir.resolve() == tmp_path / "made here"
    assert sorted(os.listdir(tmp_path)) == ["made here", "reamer.stl"], "nothing else is left behind"


def test_every_path_key_of_a_dict_is_known(tmp_path):
    """The keys of the scenario that take a file or folder are `path`, `mesh` and `output.dir`."""
    table = (ROOT / "docs/keys.md").read_text()
    keys = [line.split("|")[1].strip().strip("`") for line in table.splitlines()
            if line.startswith("| `") and line.count("|") >= 6 and line.split("|")[2].strip() in ("path", "folder")]
    assert len(keys) >= 7, keys
    assert all(key.endswith((".path", ".mesh", ".profile")) or key == "output.dir" for key in keys), keys
    text = scenario_text({"bone": {"ct": {"path": "a"}, "mesh": {"path": pathlib.Path("b")}}, "output": {"dir": "c"},
                          "motion": {"passes": [{"tool": {"mesh": "d"}}]}, "tool": {"mesh": "${HOME}/e"}}, tmp_path)
    scenario = load_yaml(text)
    assert scenario["bone"] == {"ct": {"path": f"{tmp_path}/a"}, "mesh": {"path": f"{tmp_path}/b"}}
    assert scenario["output"]["dir"] == f"{tmp_path}/c"
    assert scenario["motion"]["passes"][0]["tool"]["mesh"] == f"{tmp_path}/d"
    assert scenario["tool"]["mesh"] == "${HOME}/e"


@pytest.mark.parametrize("value, text", [
    (1e-05, "1.0e-05"), ([1, 2.5], "[1, 2.5]"), ("true", "'true'"), (True, "true"), (None, "null"), ("0.1", "'0.1'"),
    ("1e5", "1e5"), (numpy.arange(2), "[0, 1]"), ({"a": (1, 2)}, "{a: [1, 2]}"), ("x" * 300, "x" * 300)])
def test_values_as_yaml(value, text):
    assert flow_text(value) == text


def test_yaml_is_read_as_the_program_reads_it():
    text = "{a: 1e-05, b: no, c: 012, d: 2026-01-01, e: .5, f: -3, g: null, h: TRUE, i: 1:30, j: 1.}"
    assert load_yaml(text) == {"a": 1e-05, "b": "no", "c": 12, "d": "2026-01-01", "e": 0.5, "f": -3, "g": None,
                               "h": True, "i": "1:30", "j": 1.0}


def test_mistakes_have_a_line_each(small, tmp_path):
    path = tmp_path / "wrong.yaml"
    path.write_text("version: 2\nbone: {voxl_mm: 1, source: phantom, phantom: {shape: cube}}\ntool: {}\nmotion: {}\n")
    with pytest.raises(reamsim.InputError) as caught:
        reamsim.run(path, tmp_path / "out")
    lines = caught.value.lines
    assert len(lines) >= 3 and caught.value.status == 2
    assert any("wrong.yaml:2:8: bone.voxl_mm: unknown key" in line for line in lines), lines
    assert not (tmp_path / "out").exists()


def test_mistakes_of_a_dict_name_no_temporary_file(small, tmp_path):
    del small["motion"]
    small["bone"]["voxel_mm"] = "coarse"
    with pytest.raises(reamsim.InputError) as caught:
        reamsim.run(small, tmp_path / "out")
    assert all(line.startswith("scenario: ") for line in caught.value.lines), caught.value.lines
    assert any("bone.voxel_mm" in line for line in caught.value.lines)


def test_an_old_folder_stays_without_overwrite(small, tmp_path):
    first = reamsim.run(small, tmp_path / "out")
    with pytest.raises(reamsim.InputError, match="--overwrite"):
        reamsim.run(small, tmp_path / "out")
    again = reamsim.run(small, tmp_path / "out", overwrite=True, motion__plunge__depth_mm=0.5)
    assert again.summary["removed_mm3"] < first.summary["removed_mm3"]


def test_warnings_of_the_program_are_warnings(small, tmp_path):
    with pytest.warns(reamsim.ReamsimWarning, match="never"):
        run = reamsim.run(small, tmp_path / "out", motion__plunge__entry_mm=[50, 0, 0])
    assert any("never" in warning for warning in run.warnings)


def test_warnings_before_an_error_are_warnings_too(small, fake_program):
    fake_program('echo "reamsim: warning: a hole" >&2; echo "reamsim: error: no such device" >&2; exit 2')
    with pytest.raises(reamsim.InputError, match="^no such device$"), \
            pytest.warns(reamsim.ReamsimWarning, match="^a hole$") as caught:
        reamsim.run(small)
    assert caught[0].filename == __file__, "it names the caller"
    # Where warnings are errors, the error of the program is not lost.
    with warnings.catch_warnings(), pytest.raises(reamsim.InputError, match="^no such device$") as raised:
        warnings.simplefilter("error", reamsim.ReamsimWarning)
        reamsim.run(small)
    assert isinstance(raised.value.__cause__, reamsim.ReamsimWarning)


def test_each_run_shows_its_warnings(small, fake_program):
    fake_program('echo "reamsim: warning: a hole" >&2; echo "reamsim: error: no such device" >&2; exit 2')
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("default", reamsim.ReamsimWarning)
        with pytest.raises(reamsim.InputError):
            reamsim.run(small)
        with pytest.raises(reamsim.InputError):
            reamsim.run(small)
    assert len(caught) == 2


def test_progress_is_shown_on_request(small, tmp_path, capfd):
    reamsim.run(small, tmp_path / "one")
    assert capfd.readouterr().out == ""
    reamsim.run(small, tmp_path / "two", show_output=True)
    assert "results: " in capfd.readouterr().out


def test_other_ends_of_the_program(small, fake_program):
    fake_program('echo "reamsim: error: No space left" >&2; exit 1')
    with pytest.raises(reamsim.RunError, match="^No space left$"):
        reamsim.run(small)
    fake_program("kill -KILL $$")
    with pytest.raises(reamsim.RunError, match="SIGKILL"):
        reamsim.run(small)
    fake_program("exit 3")
    with pytest.raises(reamsim.RunError, match="status 3"):
        reamsim.run(small)
    fake_program('echo "reamsim: error: interrupted" >&2; exit 130')
    with pytest.raises(reamsim.Interrupted) as caught:
        reamsim.run(small)
    assert not caught.value.resumable
    fake_program("exit 0")
    with pytest.raises(reamsim.RunError, match="did not say"):
        reamsim.run(small)


def test_no_temporary_folder_is_needed(fake_program, monkeypatch, tmp_path):
    fake_program('echo "reamsim: error: of the scenario" >&2; exit 2')
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "none"))
    with pytest.raises(reamsim.InputError, match="of the scenario"):
        reamsim.run("default")


def test_a_program_that_fills_both_pipes_ends(small, fake_program):
    fake_program("i=0; while [ $i -lt 3000 ]; do echo 'a line of some length on the standard output'; "
                 "echo 'reamsim: error: a line of some length on standard error' >&2; i=$((i + 1)); done; exit 1")
    for show_output in (False, True):
        with pytest.raises(reamsim.RunError) as caught:
            reamsim.run(small, show_output=show_output)
        assert len(caught.value.lines) == 3000


def test_a_missing_program(small, monkeypatch, tmp_path):
    monkeypatch.setenv("REAMSIM_PROGRAM", str(tmp_path / "none"))
    with pytest.raises(reamsim.ProgramNotFound, match="REAMSIM_PROGRAM=.*none"):
        reamsim.run(small)
    monkeypatch.delenv("REAMSIM_PROGRAM")
    monkeypatch.setattr("reamsim.program.__file__", str(tmp_path / "lib/python3/reamsim/program.py"))
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(reamsim.ProgramNotFound, match="REAMSIM_PROGRAM"):
        reamsim.run(small)
    # On PATH, and before that beside the package.
    for folder in (tmp_path, tmp_path / "bin"):
        folder.mkdir(exist_ok=True)
        (folder / "reamsim").write_text("#!/bin/sh\n")
        (folder / "reamsim").chmod(0o755)
        assert reamsim.find_program() == str(folder / "reamsim")


INTERRUPTED = """
import sys, reamsim
try:
    reamsim.run(sys.argv[1], sys.argv[2])
except reamsim.Interrupted as error:
    print(error.status, error.resumable)
"""


def test_ctrl_c_interrupts_the_program_which_can_continue(small, tmp_path):
    small["motion"]["frame_rate_hz"] = 1000
    small["motion"]["plunge"].update(feed_mm_s=0.05)
    path, out = tmp_path / "slow.yaml", tmp_path / "out"
    path.write_text(yaml.safe_dump({"version": 2, **small}))
    process = subprocess.Popen([sys.executable, "-c", INTERRUPTED, str(path), str(out)], stdout=subprocess.PIPE, text=True,
                               start_new_session=True)
    log, until = tmp_path / "out.partial/forces.csv", time.monotonic() + 60
    while process.poll() is None and time.monotonic() < until and not (log.exists() and log.stat().st_size > 10000):
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)  # to Python alone, as from a notebook
    said, _ = process.communicate(timeout=60)
    assert said.split() == ["75", "True"]
    with pytest.warns(reamsim.ReamsimWarning, match="peaks of single frames"):  # of so slow a feed
        run, whole = reamsim.run(path, out, resume=True), reamsim.run(path, tmp_path / "whole")
    assert numpy.array_equal(run.force_array, whole.force_array)


def test_the_scenario_of_the_tests_needs_no_device():
    assert SMALL["engine"]["device"] == "serial"
