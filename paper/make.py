# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""make.py REAMSIM [--only RUN...]: makes the numbers, the figures and the text of the paper, from the root of the checkout.

REAMSIM_DATA names the folder of the public scan. make.py --check compares paper.md with the template and the numbers;
make.py REAMSIM --check [--only RUN...] runs again, and compares every number of these runs with the one in numbers.json.
Times are not compared: they belong to the machine that the number names."""

import argparse
import csv
import json
import pathlib
import re
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent
PLAIN = ["--set", "render.enabled=false", "--set", "output.meshes=false", "--set", "output.vti=false"]
HALF_SPACE = ["run", "trajectories/half_space.yaml", *PLAIN]
# What makes the numbers: a command of reamsim, without the folder or file that it writes.
RUNS = {
    "verify": ["verify", "--quick", "-o"],
    "bench": ["bench", "--exact", "--json"],
    "exact": [*HALF_SPACE, "-o"],
    "remove": [*HALF_SPACE, "--set", "cutting.erosion=remove", "-o"],
    "ct": ["run", "trajectories/ct_shoulder.yaml", "-o"],
}


def percent(value, digits=1):
    """0.00012 as '0.012 %'; a power of ten below 0.001 %."""
    value = abs(100 * value)
    if value >= 100:
        return f"{value:.0f} %"
    if value >= 1e-3:
        return f"{value:.{digits + 1}g} %"
    mantissa, exponent = f"{value:.{digits}e}".split("e")
    return f"{mantissa}·10^{int(exponent)}^ %"


def power(value):
    mantissa, exponent = f"{abs(value):.1e}".split("e")
    return f"{mantissa}·10^{int(exponent)}^"


def verify_numbers(folder):
    report = json.loads((folder / "verification.json").read_text())
    cases = {case["id"]: case for case in report["cases"]}

    def check(case, quantity):
        return next(c for c in cases[case]["checks"] if c["quantity"].startswith(quantity))

    if not report["passed"]:
        sys.exit("reamsim verify found figures out of their tolerance")
    return {
        "cases": str(len(cases)),
        "figures": str(sum(len(case["checks"]) for case in cases.values())),
        "cap_volume": percent(check("half_space", "removed volume")["error"]),
        "tilted_volume": percent(check("tilted_cap", "RMS volume error at 0.25 mm, exact")["found"]),
        "tilted_remove": percent(check("tilted_cap", "RMS volume error at 0.25 mm, remove")["found"]),
        "torque": percent(check("steady", "torque, R 29, a 15 mm, 250 rpm, 0.2 mm/s")["error"]),
        "axial_force": percent(check("steady", "thrust, R 29, a 15 mm, 250 rpm, 0.2 mm/s")["error"]),
        "ripple": percent(check("ripple", "convex along the lattice, exact")["found"]),
        "ripple_remove": percent(check("ripple", "convex along the lattice, remove")["found"]),
        "energy": power(check("energy", "left side against right side")["error"]),
    }


def bench_numbers(file):
    report = json.loads(file.read_text())
    exact = {s["voxel_mm"]: s for s in report["spheres"] if s["erosion"] == "exact"}
    return {
        "times_025": f"{exact[0.25]['times_real_time']:.0f}",
        "times_010": f"{exact[0.1]['times_real_time']:.1f}",
        "device": report["device"].removeprefix("pthread-"),
    }


def rows(folder):
    with open(folder / "forces.csv", newline="") as file:
        return list(csv.DictReader(file))


def steady_torque(folder):
    """Time and torque of the last second before the reamer retracts."""
    all_rows = rows(folder)
    end = max(i for i, row in enumerate(all_rows) if float(row["contacts"]) > 0)
    last = all_rows[end - 1000:end]
    return [float(r["time_s"]) for r in last], [float(r["spin_torque_nmm"]) for r in last]


def torque_numbers(folder):
    time_s, torque_nmm = steady_torque(folder)
    mean = sum(torque_nmm) / len(torque_nmm)
    spread = (sum((t - mean) ** 2 for t in torque_nmm) / len(torque_nmm)) ** 0.5
    summary = json.loads((folder / "summary.json").read_text())
    return {"mean_nmm": f"{mean:.0f}", "spread": percent(spread / mean), "frames": str(summary["frames"])}


def ct_numbers(folder):
    summary = json.loads((folder / "summary.json").read_text())
    return {
        "depth_mm": f"{summary['headline']['depth_mm']:.1f}",
        "removed_mm3": f"{summary['removed_mm3']:.0f}",
        "peak_axial_n": f"{summary['forces']['peak_axial_force_n']:.1f}",
        "peak_torque_nmm": f"{summary['forces']['peak_spin_torque_nmm']:.0f}",
        "balance": power(summary["balance"]),
    }


NUMBERS = {"verify": verify_numbers, "bench": bench_numbers, "exact": torque_numbers, "remove": torque_numbers,
           "ct": ct_numbers}


def make_runs(program, names, folder):
    """The numbers of some runs, as {run: {name: text}}."""
    found = {}
    for name in names:
        out = folder / (name + ".json" if name == "bench" else name)
        subprocess.run([program, *RUNS[name], str(out)], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
        found[name] = {"command": " ".join(["reamsim", *RUNS[name][:-1]]), **NUMBERS[name](out)}
    return found


def draw_torque(folder, path):
    import matplotlib
    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    figure, axes = plt.subplots(figsize=(6.4, 2.8), layout="constrained")
    for name, label in (("remove", "whole voxels removed"), ("exact", "exact erosion")):
        time_s, torque_nmm = steady_torque(folder / name)
        start = time_s[0]
        axes.plot([t - start for t in time_s], torque_nmm, label=label, linewidth=0.6 if name == "remove" else 1.4)
    axes.set(xlabel="time, s", ylabel="torque, N·mm", xlim=(0, 1), ylim=(0, None))
    axes.legend(frameon=False)
    figure.savefig(path, dpi=200, metadata={"Software": None})


def shrink(picture, path):
    from PIL import Image
    with Image.open(picture) as image:
        image.convert("RGB").resize((960, image.height * 960 // image.width), Image.LANCZOS).save(path, optimize=True)


def fill(template, numbers):
    def text(match):
        run, name = match[1].split(".")
        return numbers[run][name]
    return re.sub(r"\{\{([\w.]+)\}\}", text, template)


def check_text(numbers):
    if fill((HERE / "paper.in.md").read_text(), numbers) != (HERE / "paper.md").read_text():
        sys.exit("paper.md is not paper.in.md with the numbers of numbers.json: run paper/make.py")
    used = set(re.findall(r"@(\w+)", (HERE / "paper.in.md").read_text()))
    known = set(re.findall(r"^@\w+\{(\w+),", (HERE / "paper.bib").read_text(), re.M))
    if used != known:
        sys.exit(f"cited but not in paper.bib, or the reverse: {sorted(used ^ known)}")


def check_numbers(numbers, again):
    wrong = [f"{run}.{name}: {numbers[run][name]} in numbers.json, {text} now"
             for run, values in again.items() for name, text in values.items() if numbers[run][name] != text]
    if wrong:
        sys.exit("\n".join(wrong))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?")
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--only", nargs="+", choices=RUNS)
    options = parser.parse_args()
    file = HERE / "numbers.json"
    numbers = json.loads(file.read_text()) if file.exists() else {}
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if options.check:
            check_text(numbers)
            if options.program:
                names = [run for run in options.only or RUNS if run != "bench"]
                check_numbers(numbers, make_runs(str(pathlib.Path(options.program).resolve()), names, folder))
            return
        names = options.only or list(RUNS)
        numbers.update(make_runs(str(pathlib.Path(options.program).resolve()), names, folder))
        (HERE / "figures").mkdir(exist_ok=True)
        if {"exact", "remove"} <= set(names):
            draw_torque(folder, HERE / "figures/torque.png")
        if "ct" in names:
            shrink(folder / "ct/reamed.png", HERE / "figures/ct_glenoid.png")
    file.write_text(json.dumps(numbers, indent=1, ensure_ascii=False) + "\n")
    (HERE / "paper.md").write_text(fill((HERE / "paper.in.md").read_text(), numbers))


main()
