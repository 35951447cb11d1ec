# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""The program and its statistics: missing packages, failures, interruptions, threads."""

import json
import os
import pathlib
import signal
import subprocess
import sys
import time

import pytest
import reamsim
from reamsim.lab.tables import csv_text, json_text, number_text, replace_file

ROOT = pathlib.Path(__file__).resolve().parents[2]
MAIN = ROOT / "python/src/reamsim/lab/__main__.py"
STUDY = f"""version: 1
base: {ROOT}/tests/e2e/tiny.yaml
sample: {{n: 4, of: {{cutting.specific_energy_j_mm3: {{uniform: [0.1, 0.2]}}, cutting.normal_ratio: {{uniform: [0.4, 0.6]}}}}}}
"""


def call(folder, *arguments, **environment):
    return subprocess.run([reamsim.find_program(), *arguments], cwd=folder, capture_output=True, text=True,
                          env={**os.environ, **environment})


def script(path, lines):
    path.write_text("#!/bin/sh\n" + lines)
    path.chmod(0o755)
    return str(path)


@pytest.fixture
def study(tmp_path):
    (tmp_path / "uq.yaml").write_text(STUDY)
    return tmp_path


def test_missing_packages_are_said_before_runs_are_simulated(study):
    bare = script(study / "python", f'exec {sys.executable} -S "$@"\n')
    for command in (["uq", "uq.yaml"], ["sweep", "run", "uq.yaml"]):
        done = call(study, *command, "-o", "out", REAMSIM_PYTHON=bare)
        assert done.returncode == 1, done.stderr
        assert "apt install python3-numpy python3-scipy python3-matplotlib python3-yaml" in done.stderr.splitlines()[-1]
        assert not list((study / "out").glob("runs/*")), "nothing is simulated"
    done = call(study, "uq", "uq.yaml", "-o", "out", REAMSIM_PYTHON="/nowhere/python3")
    assert done.returncode == 1 and "/nowhere/python3 cannot be started: No such file or directory" in done.stderr


def test_a_failure_is_one_line(study):
    broken = script(study / "python", f'case "$*" in *check) exec {sys.executable} "$@";; esac\necho oh >&2; exit 3\n')
    done = call(study, "uq", "uq.yaml", "-o", "out", REAMSIM_PYTHON=broken)
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == f"reamsim: error: the statistics failed: {broken}: oh"


def test_an_interruption_ends_the_statistics(study):
    waits = script(study / "python", f'case "$*" in *check) exec {sys.executable} "$@";; esac\necho $$ > pid; exec sleep 60\n')
    pid = study / "pid"
    with subprocess.Popen([reamsim.find_program(), "uq", "uq.yaml", "-o", "out"], cwd=study, stderr=subprocess.PIPE,
                          stdout=subprocess.DEVNULL, env={**os.environ, "REAMSIM_PYTHON": waits}) as program:
        while not (pid.exists() and pid.read_text()):
            assert program.poll() is None, program.stderr.read()
            time.sleep(0.05)
        program.send_signal(signal.SIGTERM)
        assert program.wait(20) == 130
    with pytest.raises(ProcessLookupError):
        os.kill(int(pid.read_text()), 0)


def test_the_number_of_threads_changes_no_byte(study):
    for threads in ("1", "4"):
        done = call(study, "uq", "uq.yaml", "-o", f"out{threads}", OMP_NUM_THREADS=threads, OPENBLAS_NUM_THREADS=threads,
                    LC_ALL="C", MATPLOTLIBRC=str(study))
        assert done.returncode == 0, done.stderr
        (study / "matplotlibrc").write_text("lines.linewidth: 9\nfigure.facecolor: red\n")  # that of a user
    for name in ("uq.csv", "uq.json", "uq.png", "uq.svg", "uq.pdf", "uq.py"):
        assert (study / "out1" / name).read_bytes() == (study / "out4" / name).read_bytes(), name


def answer(arguments, job):
    done = subprocess.run([sys.executable, "-I", "-B", MAIN, *arguments], input=json.dumps(job), capture_output=True, text=True)
    return done.returncode, json.loads(done.stdout)


def test_errors_have_a_status_and_a_message(tmp_path):
    assert answer(["check"], None) == (0, {})
    job = {"law": {}, "time_s": [], "measured": {}, "model": "law", "class_edges_g_cm3": [], "fit_normal_ratio": True,
           "limits": None, "program": ""}
    status, said = answer(["fit", str(tmp_path), "", "", ""], job)
    assert status == 2 and f"{tmp_path}/force_basis.npy: cannot be read" in said["error"]
    table = {"all": 2, "width": 100, "numbers": [1, 2], "states": ["done"] * 2, "parameters": [
        {"key": "a", "title": "A", "cells": ["1", "2"], "shown": ["1", "2"], "numbers": [1, 2]}], "results": [
            {"key": "b", "title": "B", "unit": "", "numbers": [1, 2]}]}
    status, said = answer(["effects", str(tmp_path / "none")], table)
    assert status == 1 and said["error"] == f"{tmp_path}/none/effects.csv: cannot be written; is the disk full or the folder read-only?"


def test_texts_of_files(tmp_path):
    assert [number_text(value) for value in (0.1, 1e20, -3.0, 2.0 ** 53, float("nan"))] == ["0.1", "1e+20", "-3",
                                                                                            "9007199254740992", ""]
    assert [csv_text(text) for text in ("a", "=1", 'b,"c"')] == ["a", "'=1", '"b,""c"""']
    assert json.loads(json_text({"a": [float("nan"), 1.5]})) == {"a": [None, 1.5]}
    replace_file(tmp_path / "a", "new")
    assert [path.name for path in tmp_path.iterdir()] == ["a"] and (tmp_path / "a").read_text() == "new"
