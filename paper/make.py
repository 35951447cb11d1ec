# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""make.py [REAMSIM [--only RUN...]]: makes the numbers of the paper, marked in its text as <!--RUN.NAME-->, and the figures.

REAMSIM_DATA names the folder of the public scan. Numbers of the benchmark come from bench.json beside this file: the run `bench` makes it in eleven to seventeen
minutes of an idle machine. `reamsim bench --json paper/bench.json --overwrite`, and then make.py without a program, does the same.

make.py --check compares the numbers in paper.md with numbers.json, and those of the benchmark with bench.json.
make.py REAMSIM --check [--only RUN...] runs again, and compares every number of these runs with the one in numbers.json. Times are not compared:
they belong to the machine that the number names. Counts of the benchmark (contacts, points, memory) are deterministic: `bench`
runs the short suite, and compares its counts with those of bench.json."""

import argparse
import csv
import json
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent
BENCH = HERE / "bench.json"
PAPER = HERE / "paper.md"
PLAIN = ["--set", "render.enabled=false", "--set", "output.meshes=false", "--set", "output.vti=false", "--set", "output.plots=false"]
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


# PoCL names a processor pthread-TARGET-MODEL, where the target is the compiler's name of what the processor can do.
TARGETS = {"haswell": "AVX2", "skylake-avx512": "AVX-512"}
CORES = {1: "one", 2: "two", 4: "four", 8: "eight", 16: "sixteen"}


def device_text(device):
    """pthread-haswell-AMD EPYC as 'AMD EPYC, AVX2'."""
    for target, instructions in TARGETS.items():
        if device.startswith(f"pthread-{target}-"):
            return f"{device.removeprefix(f'pthread-{target}-')}, {instructions}"
    return device.removeprefix("pthread-")


def points_text(report):
    """Points of the shell in contact, in thousands: 102959.75 as '103,000'."""
    direct = next(r for r in report["results"] if (r["engine"], r["case"], r["voxmap"], r["shell"]) == ("direct", "severe", 1024, 1024))
    return f"{direct['contacts'] / 1000:.0f},000"


def bench_counts(report):
    """What every run of the benchmark finds alike: contacts of the deterministic programs, points of poses and shells, memory; by name."""
    def name(row, *keys):
        return " ".join(str(row[key]) for key in keys)
    return {
        **{"contacts of " + name(r, "engine", "voxmap", "shell", "case"): r["contacts"]
           for r in report["results"] if r["variant"] == "deterministic"},
        **{"points of pose " + name(r, "case", "pose"): r["points"] for r in report["poses"]},
        **{"points of shell " + name(r, "shell"): r["points"] for r in report["shells"]},
        **{f"{key} of " + name(r, "engine", "voxmap", "shell"): r[key] for r in report["memory"] for key in ("voxmap_mb", "shell_mb")},
    }


def check_counts(now, committed):
    """Counts of the short suite against those of bench.json, which has all of them and more."""
    found, wanted = bench_counts(now), bench_counts(committed)
    wrong = [f"bench: {name}: {wanted.get(name, 'missing')} in bench.json, {count} now"
             for name, count in found.items() if wanted.get(name) != count]
    if wrong:
        sys.exit("\n".join(wrong))


def bench_numbers(file):
    report = json.loads(file.read_text())
    if not report["spheres"] or not report["voi"]:
        sys.exit(f"{file} is not of the whole benchmark: make it again without --quick and --exact")
    exact = {s["voxel_mm"]: s for s in report["spheres"] if s["erosion"] == "exact"}
    frames = {(r["engine"], r["case"]): r for r in report["results"]
              if (r["voxmap"], r["shell"], r["variant"]) == (1024, 1024, "deterministic")}
    direct, = [r for r in report["results"]
               if (r["engine"], r["variant"], r["case"], r["voxmap"], r["shell"]) == ("direct", "published", "severe", 1024, 1024)]
    return {
        "times_025": f"{exact[0.25]['times_real_time']:.0f}",
        "times_010": f"{exact[0.1]['times_real_time']:.1f}",
        "device": device_text(report["device"]),
        "cores": CORES.get(report["compute_units"], str(report["compute_units"])),
        "direct_ms": f"{direct['median_ms']:.0f}",
        "points": points_text(report),
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
        out = folder / name
        if name == "bench":
            out = folder / "bench.json"
            run(program, *RUNS[name], out, "-o", folder / "bench")
            shutil.copy(out, BENCH)
        else:
            run(program, *RUNS[name], out)
        found[name] = numbers_of(name, out)
    return found


def run(program, *arguments):
    subprocess.run([program, *map(str, arguments)], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)


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


def fill(text, numbers):
    """Every <!--RUN.NAME-->TEXT<!----> with the text of this number."""
    def marked(match):
        run, name = match[1].split(".")
        return f"<!--{match[1]}-->{numbers[run][name]}<!---->"
    return re.sub(r"<!--([\w.]+)-->.*?<!---->", marked, text)


def check_text(numbers):
    text = PAPER.read_text()
    if fill(text, numbers) != text:
        sys.exit("a number in paper.md is not that of numbers.json: run paper/make.py")
    used = set(re.findall(r"@(\w+)", text))
    known = set(re.findall(r"^@\w+\{(\w+),", (HERE / "paper.bib").read_text(), re.M))
    if used != known:
        sys.exit(f"cited but not in paper.bib, or the reverse: {sorted(used ^ known)}")


def check_bench(numbers):
    """The numbers of the benchmark against the file that they come from."""
    check_numbers(numbers, {"bench": numbers_of("bench", BENCH)})


def check_bench_again(program, folder, numbers):
    """The short suite on this machine: its counts, not its times."""
    out = folder / "bench.json"
    run(program, "bench", "--quick", "--json", out, "-o", folder / "bench")
    now = json.loads(out.read_text())
    check_numbers(numbers, {"bench": {"points": points_text(now)}})
    check_counts(now, json.loads(BENCH.read_text()))


def check_numbers(numbers, again):
    wrong = [f"{run}.{name}: {numbers[run].get(name, 'missing')} in numbers.json, {text} now"
             for run, values in again.items() for name, text in values.items() if numbers[run].get(name) != text]
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


def require_scan():
    """Exits with 77 (skipped, to a test) where the scan of the run `ct` is missing."""
    scan = pathlib.Path(os.environ.get("REAMSIM_DATA", "")) / "shoulder_ct/shoulder_left.nrrd"
    if not scan.exists():
        print(f"skipped: no {scan}; set REAMSIM_DATA to the folder that holds the public data, or name other runs with --only")
        sys.exit(77)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program", nargs="?", type=pathlib.Path)
    parser.add_argument("--check", action="store_true")
    parser.add_argument("--only", nargs="+", choices=RUNS)
    options = parser.parse_args()
    file = HERE / "numbers.json"
    numbers = json.loads(file.read_text()) if file.exists() else {}
    names = list(options.only or RUNS) if options.program else []
    if "ct" in names:
        require_scan()
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        if options.check:
            check_text(numbers)
            check_bench(numbers)
            if "bench" in names:
                names.remove("bench")
                check_bench_again(options.program.resolve(), folder, numbers)
        again = make_runs(options.program.resolve(), names, folder) if names else {}
        if options.check:
            check_numbers(numbers, again)
            return
        draw(folder, names)
    numbers.update(again)
    if BENCH.exists():
        numbers["bench"] = numbers_of("bench", BENCH)
    file.write_text(json.dumps(numbers, indent=1, ensure_ascii=False) + "\n")
    PAPER.write_text(fill(PAPER.read_text(), numbers))


if __name__ == "__main__":
    main()
