# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""make.py REAMSIM [--only RUN...]: makes the numbers, the figures and the text of the paper, from the root of the checkout.

REAMSIM_DATA names the folder of the public scan. make.py --check compares paper.md with the template and the numbers;
make.py REAMSIM --check [--only RUN...] runs again, and compares every number of these runs with the one in numbers.json.
Times are not compared: they belong to the machine that the number names. The benchmark takes eleven to seventeen minutes of an idle machine;
--bench FILE takes its numbers from a file that `reamsim bench --json FILE` wrote before."""

import argparse
import csv
import json
import math
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
    "bench": ["bench", "--json"],
    "exact": [*HALF_SPACE, "-o"],
    "remove": [*HALF_SPACE, "--set", "cutting.erosion=remove", "-o"],
    "ct": ["run", "trajectories/ct_shoulder.yaml", "-o"],
}

# Refinements in the figure of convergence: name of the number, case, quantity, label.
LADDERS = (
    ("volume", "tilted_cap", "removed volume", "volume of a cap, tilted"),
    ("torque", "voxel", "torque", "torque, steady plunge, tilted"),
    ("axial", "voxel", "axial force", "axial force, likewise"),
)


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


def cases_of(folder):
    return {case["id"]: case for case in json.loads((folder / "verification.json").read_text())["cases"]}


def ladder(cases, case, quantity):
    """A quantity at several voxel sizes, and the order of its error."""
    return next(entry for entry in cases[case]["ladders"] if entry["quantity"] == quantity)


def verify_numbers(folder):
    cases = cases_of(folder)

    def check(case, quantity):
        return next(c for c in cases[case]["checks"] if c["quantity"].startswith(quantity))

    if not all(case["passed"] for case in cases.values()):
        sys.exit("reamsim verify found figures out of their tolerance")
    return {
        "cases": str(len(cases)),
        "figures": str(sum(len(case["checks"]) for case in cases.values())),
        "cap_volume": percent(check("half_space", "removed volume")["error"]),
        "tilted_volume": percent(check("tilted_cap", "RMS volume error at 0.25 mm, exact")["found"]),
        "tilted_remove": percent(check("tilted_cap", "RMS volume error at 0.25 mm, remove")["found"]),
        "torque": percent(check("steady", "torque, R 29, a 15 mm, 250 rpm, 0.2 mm/s")["error"]),
        "axial_force": percent(check("steady", "axial force, R 29, a 15 mm, 250 rpm, 0.2 mm/s")["error"]),
        "ripple": percent(check("ripple", "convex along the lattice, exact")["found"]),
        "ripple_remove": percent(check("ripple", "convex along the lattice, remove")["found"]),
        "energy": power(check("energy", "left side against right side")["error"]),
        **{f"order_{name}": f"{ladder(cases, case, quantity)['order']:.1f}" for name, case, quantity, _ in LADDERS},
    }


def bench_numbers(file):
    report = json.loads(file.read_text())
    exact = {s["voxel_mm"]: s for s in report["spheres"] if s["erosion"] == "exact"}
    frames = {(r["engine"], r["case"]): r for r in report["results"]
              if (r["voxmap"], r["shell"], r["variant"]) == (1024, 1024, "deterministic")}
    direct, = [r for r in report["results"]
               if (r["engine"], r["variant"], r["case"], r["voxmap"], r["shell"]) == ("direct", "published", "severe", 1024, 1024)]
    return {
        "times_025": f"{exact[0.25]['times_real_time']:.0f}",
        "times_010": f"{exact[0.1]['times_real_time']:.1f}",
        "device": report["device"].removeprefix("pthread-"),
        "direct_ms": f"{direct['median_ms']:.0f}",
        "points": f"{direct['contacts'] / 1000:.0f},000",
        **{f"{engine}_{case}": f"{frames[engine, case]['ratio_to_direct']:.0f}"
           for engine in ("bricked", "exact") for case in ("severe", "light")},
    }


def rows(folder):
    with open(folder / "forces.csv", newline="") as file:
        return list(csv.DictReader(file))


# Torque of the plunge of half_space.yaml in full contact, π·u·(a² − r₀²)·v_f/ω: docs/physics.md, section 6.
CLOSED_FORM_NMM = math.pi * 150 * (15**2 - 1.25**2) * 0.2 / (250 * 2 * math.pi / 60)


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
        found[name] = numbers_of(name, out)
    return found


def numbers_of(name, out):
    return {"command": " ".join(["reamsim", *RUNS[name][:-1]]), **NUMBERS[name](out)}


def save(figure, path):
    figure.savefig(path, dpi=200, metadata={"Software": None})


def draw_torque(folder, path):
    """One second of both ways of erosion, each on its own scale, in N·m."""
    from matplotlib import pyplot
    figure, panels = pyplot.subplots(1, 2, figsize=(6.4, 2.6), layout="constrained")
    for axes, name, title in zip(panels, ("remove", "exact"), ("whole voxels removed", "exact erosion")):
        time_s, torque_nmm = steady_torque(folder / name)
        axes.plot([t - time_s[0] for t in time_s], [t / 1000 for t in torque_nmm], linewidth=0.9, color="C0")
        axes.axhline(CLOSED_FORM_NMM / 1000, color="C1", linewidth=0.9, linestyle="--", label="closed form")
        axes.set(title=title, xlabel="time, s", ylabel="torque, N·m", xlim=(0, 1), ylim=(0, None))
    panels[1].set_ylim(0, 1)
    panels[1].legend(frameon=False, loc="lower right")
    save(figure, path)


def draw_convergence(folder, path):
    """Relative errors over the voxel size, with the slope of second order."""
    from matplotlib import pyplot
    figure, axes = pyplot.subplots(figsize=(4.6, 3.2), layout="constrained")
    cases = cases_of(folder)
    for marker, (_, case, quantity, label) in zip("osD", LADDERS):
        levels = ladder(cases, case, quantity)["levels"]
        axes.loglog([level["step"] for level in levels], [abs(level["error"]) for level in levels], marker=marker, label=label)
    axes.loglog([0.125, 2], [2e-4 * 0.125**2, 2e-4 * 2**2], color="0.5", linestyle=":", label="second order")
    sizes = (0.125, 0.25, 0.5, 1, 2)
    axes.set_xticks(sizes, [f"{size:g}" for size in sizes])
    axes.minorticks_off()
    axes.set(xlabel="voxel size, mm", ylabel="relative error")
    axes.set_ylim(2e-8, 1e-1)
    axes.legend(frameon=False, fontsize=8, loc="upper left")
    save(figure, path)


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


def draw(folder, names):
    import matplotlib
    matplotlib.use("Agg")
    figures = HERE / "figures"
    figures.mkdir(exist_ok=True)
    if {"exact", "remove"} <= set(names):
        draw_torque(folder, figures / "torque.png")
    if "verify" in names:
        draw_convergence(folder / "verify", figures / "convergence.png")
    if "ct" in names:
        shrink(folder / "ct/reamed.png", figures / "ct_glenoid.png")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", type=pathlib.Path)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--only", nargs="+", choices=RUNS)
    parser.add_argument("--bench", type=pathlib.Path)
    options = parser.parse_args()
    file = HERE / "numbers.json"
    numbers = json.loads(file.read_text()) if file.exists() else {}
    names = list(options.only or RUNS) if options.program else []
    if options.check:
        check_text(numbers)
    if "bench" in names and (options.check or options.bench):
        names.remove("bench")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        again = make_runs(options.program.resolve(), names, folder) if names else {}
        if options.check:
            check_numbers(numbers, again)
            return
        draw(folder, names)
    numbers.update(again)
    if options.bench:
        numbers["bench"] = numbers_of("bench", options.bench)
    file.write_text(json.dumps(numbers, indent=1, ensure_ascii=False) + "\n")
    (HERE / "paper.md").write_text(fill((HERE / "paper.in.md").read_text(), numbers))


main()
