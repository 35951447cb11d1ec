"""check_results.py DIR: is the output folder complete, and do its files agree with each other?"""

import csv
import json
import pathlib
import subprocess
import sys

import grids

FILES = """scenario.yaml forces.csv forces.png forces.svg forces.gp reamed.vdb reamed.vti summary.json timings.csv
           reamed.png reamed_glenoid.png reamed_section.png frames/000000.png snapshots/000000.vdb snapshots/tool.stl"""


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
    gone = sum(v.count for v in vdb["removed_frame"].iterOnValues())
    assert abs(gone * voxel**3 - removed) < 1e-5 * removed, "removed_frame marks other voxels than were removed"

    listing = subprocess.run(["vdb_print", "-l", str(folder / "reamed.vdb")], capture_output=True, text=True, check=True)
    for name in grids.UNITS:
        assert name in listing.stdout, f"vdb_print does not list {name}"


main()
