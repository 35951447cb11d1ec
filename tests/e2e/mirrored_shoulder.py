# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""mirrored_shoulder.py REAMSIM SCENARIO: the mirror image of a shoulder, as of the other side, gives the same numbers:
the cut humeral head, the glenoid found from a point, forces, and planning numbers. Exits with 77 (skipped) without the
data."""

import gzip
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy
import real_data
import yaml

NEAR_MM = [126.9, 175.9, -440.6]
CROP = [85, 135, -485], [170, 215, -404]  # the glenoid with its vault, and the head of the humerus
LANDMARKS = {"glenoid_center_mm": [126.9, 175.9, -440.6], "trigonum_spinae_mm": [66, 238.5, -459],
             "inferior_angle_mm": [108, 201, -567]}
IMPLANT = {"backside_radius_mm": 29, "width_mm": 23, "height_mm": 30, "footprint": "pear", "thickness_mm": 4,
           "pegs": [{"from_mm": [0, 0, 0], "to_mm": [0, 0, -12], "diameter_mm": 5}]}
# The peg on the axis and directions round it have no side. Positions are snapped to columns of half a voxel.
BARS = {"removed volume": ("removed_mm3", 0.02), "energy": ("energy_mj", 0.02),
        "peak thrust": ("forces/peak_axial_force_n", 0.02), "mean thrust": ("forces/mean_axial_force_n", 0.02),
        "peak torque": ("headline/peak_spin_torque_nmm", 0.02),
        "bone behind the implant": ("metrics/planning/vault/left_mm3", 0.01),
        "footprint": ("metrics/seating/footprint_mm2", 0.005), "bone in the scan": ("bone/bone_before_mm3", 1e-3)}
ANGLES_DEG = {"version": "metrics/planning/planned/version_deg", "inclination": "metrics/planning/planned/inclination_deg"}


def mirrored(v):
    return [-v[0], v[1], v[2]]


def mirror_scan(source, target):
    """Writes the scan with x negated: its first axis in the other order, its origin at the other end."""
    header, body = pathlib.Path(source).read_bytes().split(b"\n\n", 1)
    lines = header.decode().splitlines()
    field = {line.split(":")[0]: line.split(":", 1)[1].strip() for line in lines if ":" in line and line[0] != "#"}
    assert field["type"] in ("short", "int16") and field["encoding"] in ("gzip", "gz"), field
    sizes = [int(n) for n in field["sizes"].split()]
    origin = [float(n) for n in field["space origin"].strip("()").split(",")]
    step = [float(n) for n in field["space directions"].split()[0].strip("()").split(",")]
    assert step[1] == step[2] == 0, step
    image = numpy.frombuffer(gzip.decompress(body), "<i2").reshape(sizes[::-1])
    origin[0] = -(origin[0] + (sizes[0] - 1) * step[0])
    lines = [f"space origin: ({','.join(map(repr, origin))})" if line.startswith("space origin") else line for line in lines]
    pathlib.Path(target).write_bytes("\n".join(lines).encode() + b"\n\n" + gzip.compress(image[:, :, ::-1].tobytes(), 1))


def run(program, scenario, folder, mirror):
    """The summary of a run of the shoulder, or of its mirror image."""
    content = yaml.safe_load(pathlib.Path(scenario).read_text())
    at = mirrored if mirror else list
    ct = content["bone"]["ct"]
    ct["path"] = os.path.expandvars(ct["path"])
    ct.pop("cut_spheres")
    ct["separate"] = "humerus"
    ct["seed_mm"] = at(ct["seed_mm"])
    low, high = CROP
    if mirror:
        mirror_scan(ct["path"], folder / "mirror.nrrd")
        ct["path"] = "mirror.nrrd"
        low, high = [-high[0], *low[1:]], [-low[0], *high[1:]]
    ct["crop_min_mm"], ct["crop_max_mm"] = low, high
    content["bone"]["side"] = "right" if mirror else "left"
    content["bone"]["glenoid"] = {"near_mm": at(NEAR_MM), "landmarks": {k: at(v) for k, v in LANDMARKS.items()}}
    content["tool"]["mesh"] = str((pathlib.Path(scenario).parent / content["tool"]["mesh"]).resolve())
    del content["clearance"], content["tool"]["holder"]
    content["metrics"] = {"implant": IMPLANT}
    file = folder / f"{'mirror' if mirror else 'original'}.yaml"
    file.write_text(yaml.safe_dump(content))
    sets = ["motion.plunge.from=contact", "motion.plunge.depth_mm=2.5", "motion.frame_rate_hz=250", "bone.voxel_mm=0.5",
            f"motion.plunge.spin_rpm={-250 if mirror else 250}", "render.enabled=false", "output.plots=false", "output.meshes=false",
            "output.vti=false"]
    out = folder / file.stem
    subprocess.run([program, "run", file, "-o", out, "--quiet", *(f"--set={s}" for s in sets)], check=True)
    return json.loads((out / "summary.json").read_text())


def value(summary, path):
    for key in path.split("/"):
        summary = summary[key]
    return summary


def main():
    program, scenario = sys.argv[1:]
    real_data.require(scenario)
    with tempfile.TemporaryDirectory() as folder:
        original, mirror = (run(program, scenario, pathlib.Path(folder), m) for m in (False, True))
    for name, (path, bar) in BARS.items():
        a, b = value(original, path), value(mirror, path)
        print(f"{name}: {a:.3f}, mirrored {b:.3f}, {100 * (b / a - 1):+.2f} %")
        assert abs(b / a - 1) < bar, f"{name} depends on the side"
    for name, path in ANGLES_DEG.items():
        a, b = value(original, path), value(mirror, path)
        print(f"{name}: {a:.2f} deg, mirrored {b:.2f} deg")
        assert abs(b - a) < 0.5, f"{name} depends on the side"


main()
