# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""check_results.py DIR: is the output folder complete, and do its files agree with each other?"""

import csv
import json
import pathlib
import subprocess
import sys

import grids

FILES = """scenario.yaml forces.csv forces.png forces.svg forces.pdf forces.gp plots/forces_depth.pdf plots/energy.svg plots/removed_density.csv plots/removed_density.gp reamed.glb reamed.stl reamed.vdb reamed.vti report.html summary.json timings.csv
           depth_map.csv depth_map.png reamed.png reamed_glenoid.png reamed_section.png frames/000000.png snapshots/000000.vdb snapshots/tool.stl"""


def check_metrics(summary, columns):
    metrics, removed = summary["metrics"], summary["removed_mm3"]
    assert abs(metrics["removed"]["total_mm3"] - removed) < 1e-9 * removed
    parts = metrics["removed"]["trabecular_mm3"] + metrics["removed"]["dense_mm3"]
    assert abs(parts - removed) < 1e-9 * removed
    # Columns of less than a tenth of a voxel are left out of the map.
    raster = sorted({float(c["x_mm"]) for c in columns})
    pitch = min(b - a for a, b in zip(raster, raster[1:]))
    mapped = sum(float(c["depth_mm"]) for c in columns) * pitch**2
    assert abs(mapped - removed) < 2e-3 * removed, f"the depth map holds {mapped} of {removed} mm3"
    for c in columns:
        if c["after_z_mm"]:
            assert abs(float(c["before_z_mm"]) - float(c["after_z_mm"]) - float(c["depth_mm"])) < 2e-6
    depth = metrics["depth"]
    assert 0 < depth["mean_mm"] <= depth["p95_mm"] <= depth["max_mm"]
    assert metrics["face"]["shape"] in ("sphere", "plane")
    assert 0 < summary["reaming_s"] <= summary["simulated_s"]
    forces = summary["forces"]
    assert 0 < forces["mean_force_n"] <= forces["rms_force_n"] <= forces["peak_force_n"]
    work = summary["work_mj"] + summary["floor_energy_mj"]
    assert abs(work - summary["energy_mj"]) < 1e-4 * summary["energy_mj"]


def main():
    folder = pathlib.Path(sys.argv[1])
    for name in FILES.split():
        assert (folder / name).stat().st_size > 0, f"{name} is missing or empty"

    summary = json.loads((folder / "summary.json").read_text())
    rows = list(csv.DictReader((folder / "forces.csv").open()))
    assert len(rows) == summary["frames"], "a row per frame"
    removed = sum(float(row["removed_mm3"]) for row in rows)
    assert removed > 100, f"only {removed} mm3 removed"
    assert abs(removed - summary["removed_mm3"]) < 1e-6 * removed
    assert abs(float(rows[-1]["balance"])) < 1e-4, "the energy account does not close"
    assert summary["memory_mb"]["peak_process"] > 1

    check_metrics(summary, list(csv.DictReader((folder / "depth_map.csv").open())))

    first = summary["first_contact_frame"]
    for row in rows[:first]:
        assert float(row["axial_force_n"]) == 0 and row["contacts"] == "0", "force before contact"
    assert max(float(row["axial_force_n"]) for row in rows[first:]) > 1, "no force in contact"
    assert float(rows[-1]["axial_force_n"]) == 0, "force after retraction"

    vdb = grids.read(str(folder / "reamed.vdb"))
    voxel = vdb["density"].transform.voxelSize()[0]
    for name, unit in grids.UNITS.items():
        assert vdb[name].metadata["unit"] == unit, f"{name}: unit {vdb[name].metadata['unit']}"
    # Voxels at the bone's surface need not have been whole before.
    after = grids.total(vdb["fill"], only=vdb["density"])
    from_grids = summary["bone"]["bone_before_mm3"] - after * voxel**3
    assert abs(from_grids - summary["removed_mm3"]) < 1e-5 * removed, f"{from_grids} against {summary['removed_mm3']}"
    fill = vdb["fill"].getConstAccessor()
    gone = [v for v in vdb["removed_frame"].iterOnValues()]
    assert all(fill.getValue(v.min) == 0 for v in gone), "removed_frame marks voxels in which something is left"
    # What is partly cut is a layer of a voxel at most.
    volume = sum(v.count for v in gone) * voxel**3
    assert 0.5 * removed < volume <= removed * (1 + 1e-5), f"{volume} of {removed} mm3 marked in removed_frame"

    listing = subprocess.run(["vdb_print", "-l", str(folder / "reamed.vdb")], capture_output=True, text=True, check=True)
    for name in grids.UNITS:
        assert name in listing.stdout, f"vdb_print does not list {name}"


main()
