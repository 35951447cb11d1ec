# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Runs every numeric key of the schema at both ends of its range, each component of a vector by itself.

    key_ranges.py REAMSIM SCHEMA SECTIONS [--full] [--no-limits] [--only TEXT] [--verbose]

SECTIONS: top-level sections, separated by commas; "rest": all that no other group of GROUPS has. Each end is a run
of its own, in a child process with 4 GB of address space, 60 s of processor time and 120 s on the clock. It must end
with status 0 and finite numbers in forces.csv and summary.json. Fails as well where a key has no finite range, or lies
in a section that range_scenes.py does not list.

Without --full each key is taken at one end of its range only, in turn the minimum of one and the maximum of the next; a
vector's minimum by its first component, its maximum by its last one; the ends in LONG of range_scenes.py are left out; and the
sections of HOST, but the keys OF_KERNELS, run on the serial engine, which compiles no kernel.
"""

import copy
import json
import math
import os
import resource
import subprocess
import sys
import tempfile

from range_scenes import BASE, DIRECTED, FILES, KEYS, LONG, SECTIONS, merged

ADDRESS_SPACE = 4 << 30
PROCESSOR_S = 60
CLOCK_S = 120
HOST = ("bone", "clearance", "metrics", "output", "render")  # no kernel reads their keys
OF_KERNELS = ("bone.voxel_mm", "bone.phantom.size_mm")  # but these


class Key:
    """A numeric key: path with [] for items of lists, its range, and the components of a vector."""

    def __init__(self, path, schema, is_list, components):
        self.path, self.schema, self.is_list, self.components = path, schema, is_list, components
        self.turn = "min"  # the end that is taken without --full

    def ends(self):
        low, high = self.schema.get("minimum"), self.schema.get("maximum")
        return {"min": low, "max": high}

    def section(self):
        return self.path.rpartition(".")[0].removesuffix("[]")


def numeric_keys(schema, path=""):
    for name, key in schema["properties"].items():
        here = path + ("." if path else "") + name
        key = as_numbers(key)
        if "properties" in key:
            yield from numeric_keys(key, here)
        elif key.get("type") in ("number", "integer"):
            if "const" not in key:
                yield Key(here, key, False, [None])
        elif key.get("type") == "array":
            yield from keys_of_list(key, here)


def as_numbers(key):
    """A point may be given by markups too; its numbers come first."""
    return key["anyOf"][0] if key.get("anyOf") and key["anyOf"][0].get("type") == "array" else key


def keys_of_list(key, here):
    items = as_numbers(key["items"])
    if "properties" in items:
        yield from numeric_keys(items, here + "[]")
    elif items.get("type") == "number":
        yield Key(here, items, False, range(key["minItems"]))
    elif items.get("type") == "array":
        yield Key(here, items["items"], True, range(items["minItems"]))


PASS = "motion.passes[]."


def outside_passes(path):
    """The key of a scenario without passes that a key of a pass is like."""
    if not path.startswith(PASS):
        return path
    path = path.removeprefix(PASS)
    return path if path.startswith("tool") else "motion." + path


def scenario_of(key, end, value, component):
    """The scenario in which the key has the value; its entry "files" holds input files."""
    plain = Key(outside_passes(key.path), key.schema, key.is_list, key.components)
    if plain.path == key.path:
        return plain_scenario_of(key, end, value, component)
    scenario = plain_scenario_of(plain, end, value, component)
    scenario["motion"]["passes"] = [{"tool": copy.deepcopy(scenario["tool"]), "plunge": scenario["motion"].pop("plunge")}]
    return scenario


def plain_scenario_of(key, end, value, component):
    """The same for a key that is of no pass."""
    scenario = merged(copy.deepcopy(BASE), SECTIONS[key.section()])
    for name in (key.path, f"{key.path}@{end}"):
        scenario = merged(scenario, KEYS.get(name, {}))
    if key.path in DIRECTED:
        scenario = merged(scenario, DIRECTED[key.path](component, value))
    scenario = copy.deepcopy(scenario)
    *sections, last = key.path.split(".")
    place = scenario
    for name in sections:
        place = place.setdefault(name.removesuffix("[]"), {})
        if name.endswith("[]"):  # the first item at the minimum: values of a list may have to ascend
            place = place[0 if end == "min" else -1]
    if component is None:
        place[last] = value
    elif key.is_list:
        place[last][0][component] = value
    else:
        place.setdefault(last, [0.0] * len(key.components))[component] = value
    return scenario


def limit():
    resource.setrlimit(resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
    resource.setrlimit(resource.RLIMIT_CPU, (PROCESSOR_S, PROCESSOR_S + 5))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


def no_constant(text):
    raise ValueError(f"{text} in JSON")


def unfinished(folder):
    """What is wrong with the numbers of a run, or ""."""
    with open(f"{folder}/forces.csv", encoding="utf-8") as file:
        rows = file.read().splitlines()[1:]
    if not rows:
        return "forces.csv has no rows"
    for number, row in enumerate(rows):
        if not all(cell == "" or math.isfinite(float(cell)) for cell in row.split(",")):
            return f"row {number} of forces.csv is not finite: {row}"
    try:
        with open(f"{folder}/summary.json", encoding="utf-8") as file:
            json.load(file, parse_constant=no_constant)
    except ValueError as error:
        return f"summary.json: {error}"
    return ""


def write_inputs(folder, scenario):
    files = FILES | scenario.pop("files", {}) | {"s.yaml": json.dumps(scenario)}
    for name, content in files.items():
        with open(f"{folder}/{name}", "wb") as file:
            file.write(content if isinstance(content, bytes) else content.encode())


def complaint(reamsim, scenario, options, on_host):
    """Why the run is not as it must be, or ""."""
    limited = "--no-limits" not in options
    with tempfile.TemporaryDirectory() as folder:
        write_inputs(folder, scenario)
        command = [reamsim, "run", "s.yaml", "-o", "out", "--quiet", *(["--device", "serial"] if on_host else [])]
        try:
            done = subprocess.run(
                command, cwd=folder, capture_output=True, text=True, timeout=CLOCK_S if limited else None,
                preexec_fn=limit if limited else None, check=False,
            )
        except subprocess.TimeoutExpired:
            return f"not done after {CLOCK_S} s"
        if done.returncode != 0:
            return f"status {done.returncode}: {done.stderr.strip()[-600:]}"
        return unfinished(f"{folder}/out")


def components_of(key, end, options):
    if "--full" in options:
        return key.components
    if end != key.turn or f"{outside_passes(key.path)}@{end}" in LONG:
        return []
    return key.components[:1] if end == "min" else key.components[-1:]


def complaints_of(reamsim, key, options):
    for end, value in key.ends().items():
        for component in components_of(key, end, options):
            name = key.path + ("" if component is None else f"[{component}]") + f" = {value!r} ({end})"
            begun = os.times().elapsed
            wrong = complaint(reamsim, scenario_of(key, end, value, component), options, "--full" not in options and is_of_host(key))
            if "--verbose" in options:
                print(f"{os.times().elapsed - begun:6.2f} s  {name}", flush=True)
            if wrong:
                yield f"{name}: {wrong}"


def failures_of(reamsim, key, options):
    if None in key.ends().values():
        yield f"{key.path}: no finite range"
    elif Key(outside_passes(key.path), {}, False, [None]).section() not in SECTIONS:
        yield f"{key.path}: its section is not in SECTIONS of range_scenes.py"
    else:
        yield from complaints_of(reamsim, key, options)


GROUPS = ("bone", "motion", "cutting", "render")


def in_group(key, groups):
    top = key.path.split(".")[0].removesuffix("[]")
    return top in groups or ("rest" in groups and top not in GROUPS)


def is_of_host(key):
    return in_group(key, HOST) and key.path not in OF_KERNELS


def main():
    reamsim, schema_file, groups, *options = sys.argv[1:]
    reamsim = os.path.abspath(reamsim)
    only = options[options.index("--only") + 1] if "--only" in options else ""
    with open(schema_file, encoding="utf-8") as file:
        keys = list(numeric_keys(json.load(file)))
    for number, key in enumerate(keys):
        key.turn = ("min", "max")[number % 2]
    keys = [key for key in keys if in_group(key, groups.split(",")) and only in key.path]
    failures = 0
    for key in keys:
        for failure in failures_of(reamsim, key, options):
            failures += 1
            print("FAILED", failure, flush=True)
    print(f"{len(keys)} keys, {failures} failures")
    return 1 if failures > 0 or not keys else 0


sys.exit(main())
