# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""reamsim validate: made-up published numbers against closed forms (docs/physics.md, section 6), and mistakes of their CSV."""

import csv
import math
import os
import pathlib
import subprocess

import pytest
import reamsim
from reamsim.errors import InputError
from reamsim.lab.validation import AGREES, CONTRADICTS, UNKNOWN, Published, compare, read_published

ROOT = pathlib.Path(__file__).resolve().parents[2]
BASE = f"""version: 2
bone: {{source: phantom, voxel_mm: 0.5, phantom: {{shape: half_space, density_g_cm3: 1.8, size_mm: [30, 30, 4]}}}}
tool: {{mesh: {ROOT}/assets/reamer_flat.stl}}
motion:
  frame_rate_hz: 50
  plunge: {{entry_mm: [0, 0, 0], axis: [0, 0, -1], approach_mm: 0.1, feed_mm_s: 1, depth_mm: 1.6, retract_mm: 3, retract_mm_s: 50, spin_rpm: 100}}
cutting: {{speed_floor_mm_s: 0.001}}
render: {{enabled: false}}
output: {{vti: false, meshes: false, plots: false}}
"""
STUDY = """version: 1
base: base.yaml
vary:
  - motion.plunge.spin_rpm: [100, 200]
  - cutting.normal_ratio: [0.5, 0.515, 1]
keep: [summary, forces]
"""
SPINS, OUTER_MM, INNER_MM, ENERGY_N_MM2 = (100, 200), 13.5, 1.25, 150.0


def closed_forms(spin_rpm):
    """Torque (N mm) and axial force (N) of a flat face in full contact at 1 mm/s, k_n 0.5."""
    advance = 1 / (2 * math.pi * spin_rpm / 60)  # mm/rad
    force = 2 * math.pi * 0.5 * ENERGY_N_MM2 * advance * (OUTER_MM - INNER_MM)
    force += 2 * math.pi * ENERGY_N_MM2 * advance ** 2 * math.log(OUTER_MM / INNER_MM)
    return math.pi * ENERGY_N_MM2 * (OUTER_MM ** 2 - INNER_MM ** 2) * advance, force


def published(most=1.02):
    """Closed forms and their intervals: ± 2 %."""
    rows = ["# Closed forms", "", "motion.plunge.spin_rpm,label,result,value,low,high,unit"]
    for spin in SPINS:
        for name, value, unit in zip(("spin_torque_nmm", "axial_force_n"), closed_forms(spin), ("N mm", "N")):
            rows.append(f"{spin}.0,{name},mean({name}; 0.5..1.5 mm),{value},{0.98 * value},{most * value},{unit}")
    return "\n".join(rows) + "\n"


@pytest.fixture
def study(tmp_path):
    (tmp_path / "base.yaml").write_text(BASE)
    (tmp_path / "flat.yaml").write_text(STUDY)
    (tmp_path / "flat.csv").write_text(published())
    return tmp_path


def call(folder, *arguments):
    return subprocess.run([reamsim.find_program(), *arguments], cwd=folder, capture_output=True, text=True, env=dict(os.environ))


def test_closed_forms_agree_contradict_and_leave_open(study):
    done = call(study, "validate", "flat.yaml")
    assert done.returncode == 0, done.stderr
    assert "Closed forms\n" in done.stdout
    for line in ("(1) normal_ratio 0.5: agrees (4 of 4 values in their interval)", "(2) normal_ratio 0.515: cannot tell (2 of 4",
                 "(3) normal_ratio 1: contradicts (2 of 4"):
        assert line in done.stdout, done.stdout
    folder = study / "out/validation/flat"
    rows = list(csv.DictReader((folder / "comparison.csv").read_text().splitlines()))
    assert len(rows) == 12
    for row in rows[:4]:
        assert math.isclose(float(row["simulated"]), float(row["value"]), rel_tol=0.01), row
        assert row["verdict"] == row["verdict_of_model"] == "agrees"
    assert [row["verdict"] for row in rows[8:]] == ["agrees", "contradicts"] * 2
    for ending in ("png", "svg", "pdf", "py"):
        assert (folder / f"comparison.{ending}").stat().st_size > 1000
    # Again, with other published numbers: nothing is simulated. A result of summary.json; an end of the interval is open.
    (study / "flat.csv").write_text("label,result,value,low,high,unit\nvolume,removed_mm3,800,700,,mm3\n")
    done = call(study, "validate", "flat.yaml")
    assert done.returncode == 0 and "0 to simulate" in done.stdout, done.stderr
    assert "(6) spin_rpm 200, normal_ratio 1: agrees (1 of 1" in done.stdout


def mistake(call, *arguments):
    with pytest.raises(InputError) as found:
        call(*arguments)
    assert found.value.status == 2
    return "\n".join(found.value.lines)


def test_mistakes_stop_before_the_runs(study):
    (study / "flat.csv").write_text(published() + "100,x,y\n" + "100,x,y,1,0,oh,N\n")
    done = call(study, "validate", "flat.yaml")
    assert done.returncode == 2 and not (study / "out").exists()
    path = study / "flat.csv"
    assert done.stderr == ("reamsim: error: flat.csv:8: found 3 cells; expected 7, one for each column\n"
                           "reamsim: error: flat.csv:9: high: found oh; expected a number, or an empty cell\n")
    for text, expected in (("", "flat.csv: found nothing; expected a header with parameters and result, value, low, high, unit, and"),
                           (published().replace("spin_rpm,", "spin,"), "flat.csv:3: motion.plunge.spin: found no such parameter; exp"),
                           (published(0.97), "flat.csv:4: value: found "),
                           (published() + "100,x,y,1,,,N\n", "flat.csv:8: low: found an open interval; expected low and high")):
        path.write_text(text)
        assert expected in mistake(read_published, str(path), ["motion.plunge.spin_rpm"])
    assert "found no published numbers" in mistake(read_published, str(study / "nix.csv"), [])


def test_mistakes_of_results_and_parameters(study):
    keys = ["motion.plunge.spin_rpm", "cutting.normal_ratio"]
    (study / "flat.yaml").write_text(STUDY.replace("[0.5, 0.515, 1]", "[0.5]"))
    assert call(study, "sweep", "run", "flat.yaml", "-o", "out").returncode == 0
    head, row = "motion.plunge.spin_rpm,result,value,low,high,unit\n", "100,{},1,0,2,N\n"
    path, out = study / "flat.csv", study / "out"
    for text, expected in ((head + row.format("nix"), "flat.csv:2: result: found nix; expected a column of numbers in runs.csv"),
                           (head + row.format("mean(nix; 0..1 mm)"), "expected a column of forces.csv"),
                           (head + row.format("mean(axial_force_n; 0..1.2.3 mm)"), "expected a column of numbers in runs.csv"),
                           (head + row.format("mean(axial_force_n; 0..9 mm)"), "depths up to 1.6 mm"),
                           (head + "300,volume,1,0,2,N\n", "flat.csv:2: found 0 runs for this row"),
                           ("cutting.normal_ratio,label" + head[22:] + "0.5,volume,removed_mm3,1,0,2,N\n", "")):
        path.write_text(text)
        if expected:
            assert expected in mistake(compare, str(path), str(out), keys)
        else:
            assert compare(str(path), str(out), keys).models == ["spin_rpm 100", "spin_rpm 200"]
    # A label of the study that the rows do not name is the model, whatever else its runs differ in.
    table = list(csv.reader((out / "runs.csv").read_text().splitlines()))
    for cells, label in zip(table, ("label", "same", "same")):
        cells[:] = cells[:3] + ["message", label] + cells[4:]
    (out / "runs.csv").write_text("\n".join(map(",".join, table)) + "\n")
    path.write_text("result,value,low,high,unit\nremoved_mm3,1,0,2,mm3\n")
    assert "found 2 runs for this row; expected one run of each model" in mistake(compare, str(path), str(out), ["label", *keys])
    # In a table runs.csv escapes names that a spreadsheet would take for formulas.
    for cells, label in zip(table, ("label", "'+3 mm", "'+5 mm")):
        cells[4] = label
    (out / "runs.csv").write_text("\n".join(map(",".join, table)) + "\n")
    path.write_text("label,result,value,low,high,unit\n+3 mm,removed_mm3,1,0,2,mm3\n")
    assert compare(str(path), str(out), ["label"]).simulated.shape == (1, 1)
    for forces in out.glob("runs/*/forces.csv"):
        forces.unlink()
    path.write_text(head + row.format("mean(axial_force_n; 0..1 mm)"))
    assert "keep: [summary, forces] in the study" in mistake(compare, str(path), str(out), keys)


def test_verdicts():
    closed, least = (Published(1, {}, "", "", 10, low, high) for low, high in ((8, 12), (8, math.inf)))
    for value, verdict in ((8, AGREES), (12, AGREES), (12.1, UNKNOWN), (14, UNKNOWN), (14.1, CONTRADICTS), (5.9, CONTRADICTS),
                           (math.nan, UNKNOWN)):
        assert closed.verdict(value) == verdict, value
    assert [least.verdict(value) for value in (8, 1e9, 7.99)] == [AGREES, AGREES, CONTRADICTS]


def test_shipped_numbers_are_read():
    for path in sorted((ROOT / "trajectories/validation").glob("*.csv")):
        if not path.with_suffix(".yaml").exists():
            continue
        header = next(line for line in path.read_text().splitlines() if not line.startswith("#")).split(",")
        title, rows = read_published(str(path), header)
        assert title and rows, path
    with pytest.raises(InputError):
        read_published(str(ROOT / "trajectories/validation/nix.csv"), [])
