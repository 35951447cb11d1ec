# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""docs/python.md and the notebooks: every block and cell runs, from top to bottom."""

import json
import os
import re
import shutil
import subprocess
import sys

import numpy
import pytest
from conftest import ROOT

sys.path.insert(0, str(ROOT / "tests/e2e"))
import documented  # noqa: E402

NOTEBOOKS = sorted((ROOT / "docs/notebooks").glob("*.ipynb"))


GNUPLOT = '#!/bin/sh\nfor kind in png svg pdf; do echo plot > "${2%.gp}.$kind"; done\n'


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A folder like the project's, in which results may be written. The pages draw by matplotlib: a stand-in for gnuplot takes no time."""
    (tmp_path / "bin").mkdir()
    (tmp_path / "bin/gnuplot").write_text(GNUPLOT)
    (tmp_path / "bin/gnuplot").chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}/bin:{os.environ['PATH']}")
    for name in ("assets", "trajectories"):
        (tmp_path / name).symlink_to(ROOT / name)
    shutil.copytree(ROOT / "docs/notebooks", tmp_path / "docs/notebooks", ignore=shutil.ignore_patterns("out", ".*"))
    return tmp_path


def has_content(picture):
    """Whether a picture is not of one colour."""
    from PIL import Image

    return len(numpy.unique(numpy.asarray(Image.open(picture).convert("L")))) > 20


def test_every_block_of_the_page_runs(checkout):
    blocks = documented.blocks((ROOT / "docs/python.md").read_text(), "python")
    assert len(blocks) >= 6
    for block in blocks:
        done = subprocess.run([sys.executable, "-c", block], cwd=checkout, capture_output=True, text=True)
        assert done.returncode == 0, f"{block}\n{done.stdout}{done.stderr}"
        assert "Warning" not in done.stderr, f"{block}\n{done.stderr}"
    assert "voxel_mm" in done.stdout, "the last block prints the mistake"
    for picture in ("forces.png", "depth_map.png", "bands.png", "study.png"):
        assert has_content(checkout / picture), picture


def test_the_first_figure_takes_ten_lines():
    block = documented.blocks((ROOT / "docs/python.md").read_text(), "python")[0]
    assert len(block.strip().splitlines()) <= 10 and "savefig" in block


def test_notebooks_have_no_outputs():
    assert NOTEBOOKS
    for path in NOTEBOOKS:
        for cell in json.loads(path.read_text())["cells"]:
            assert not cell.get("outputs") and cell.get("execution_count") is None, f"{path}: {cell['id']} has outputs"


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_run_from_top_to_bottom(path, checkout):
    caches = os.environ.get("XDG_CACHE_HOME", os.path.expanduser("~/.cache"))  # of compiled kernels and fonts
    environment = {**os.environ, "XDG_CACHE_HOME": caches, "HOME": str(checkout), "JUPYTER_PATH": "/usr/share/jupyter", "IPYTHONDIR": str(checkout)}
    done = subprocess.run(["/usr/bin/jupyter-nbconvert", "--to", "notebook", "--execute", "--output", "executed",
                           "--ExecutePreprocessor.timeout=600", str(checkout / "docs/notebooks" / path.name)],
                          env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    cells = json.loads((checkout / "docs/notebooks/executed.ipynb").read_text())["cells"]
    outputs = [output for cell in cells for output in cell.get("outputs", [])]
    assert not [output for output in outputs if output["output_type"] == "error" or output.get("name") == "stderr"]
    assert sum("image/png" in output.get("data", {}) for output in outputs) == 4, "figures that a reader sees"
    said = "".join("".join(output.get("text", [])) for output in outputs)
    error = re.search(r"([-+.0-9]+) % from the closed form", said)
    assert error is not None and abs(float(error[1])) < 1, said
    keep = os.environ.get("REAMSIM_KEEP_NOTEBOOK")
    if keep:
        shutil.copy(checkout / "docs/notebooks/executed.ipynb", keep)
