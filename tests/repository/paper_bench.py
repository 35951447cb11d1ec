# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""paper_bench.py ROOT: paper/make.py finds numbers and counts that differ from those of bench.json, and no difference where only times differ."""

import copy
import json
import pathlib
import sys
import tempfile


def row(engine, variant, case, contacts, median_ms, direct_ms):
    return {"engine": engine, "variant": variant, "voxmap": 1024, "shell": 1024, "case": case, "contacts": contacts, "median_ms": median_ms,
            "ratio_to_direct": direct_ms / median_ms}


def benchmark():
    """A small report of the whole benchmark."""
    return {
        "device": "pthread-haswell-AMD EPYC", "compute_units": 2,
        "results": [row("direct", "published", "severe", 102959.75, 42, 42), row("direct", "published", "light", 11892.5, 21, 21),
                    row("bricked", "deterministic", "severe", 102959.75, 2, 42), row("bricked", "deterministic", "light", 11892.5, 0.5, 21),
                    row("exact", "deterministic", "severe", 88164.25, 0.8, 42), row("exact", "deterministic", "light", 9000.5, 0.05, 21)],
        "memory": [{"engine": "bricked", "voxmap": 1024, "shell": 1024, "voxmap_mb": 300.5, "shell_mb": 2.5}],
        "voi": [{"fraction": 0.1}],
        "spheres": [{"erosion": "exact", "voxel_mm": 0.25, "times_real_time": 40.2}, {"erosion": "exact", "voxel_mm": 0.1, "times_real_time": 6.42}],
        "poses": [{"case": "severe", "pose": 0, "points": 102961}],
        "shells": [{"shell": 1024, "points": 1189233}],
    }


def stopped_by(call, *arguments):
    """The message with which make.py ends, or "" where it succeeds."""
    try:
        call(*arguments)
    except SystemExit as end:
        return str(end)
    return ""


def check_numbers(make, folder):
    make.BENCH = folder / "bench.json"
    make.BENCH.write_text(json.dumps(benchmark()))
    numbers = {"bench": make.numbers_of("bench", make.BENCH)}
    wanted = {"times_025": "40", "times_010": "6.4", "device": "AMD EPYC, AVX2", "cores": "two", "direct_ms": "42", "points": "103,000",
              "bricked_severe": "21", "bricked_light": "42", "exact_severe": "52", "exact_light": "420"}
    assert {name: numbers["bench"][name] for name in wanted} == wanted, numbers
    assert stopped_by(make.check_bench, numbers) == ""
    numbers["bench"]["direct_ms"] = "43"
    assert "bench.direct_ms: 43 in numbers.json, 42 now" in stopped_by(make.check_bench, numbers)
    make.BENCH.write_text(json.dumps({**benchmark(), "spheres": [], "voi": []}))
    assert "not of the whole benchmark" in stopped_by(make.check_bench, numbers)


def check_counts(make):
    committed, short = benchmark(), benchmark()
    short["results"] = [{**r, "median_ms": 9 * r["median_ms"]} for r in short["results"] if r["case"] == "severe"]
    assert stopped_by(make.check_counts, short, committed) == "", "times are not compared, nor what the short suite lacks"
    planted = (("results", 2, "contacts", "contacts of exact 1024 1024 severe"), ("poses", 0, "points", "points of pose severe 0"),
               ("shells", 0, "points", "points of shell 1024"), ("memory", 0, "voxmap_mb", "voxmap_mb of bricked 1024 1024"))
    for section, index, key, name in planted:
        other = copy.deepcopy(short)
        other[section][index][key] += 1
        assert name in stopped_by(make.check_counts, other, committed), name
    committed["shells"] = []
    assert "points of shell 1024: missing in bench.json" in stopped_by(make.check_counts, short, committed)


def main():
    sys.path.insert(0, str(pathlib.Path(sys.argv[1]) / "paper"))
    sys.dont_write_bytecode = True
    import make
    with tempfile.TemporaryDirectory() as folder:
        check_numbers(make, pathlib.Path(folder))
    check_counts(make)


main()
