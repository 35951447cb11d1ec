# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""layers.py SOURCE LINKS: dependencies point one way, in links and in includes.

LINKS has what each library links, as CMake knows it; includes are read from the sources. Every
library and every folder stands in LAYERS, and may use only what stands before it.
"""

import collections
import pathlib
import re
import sys

# Folder, and the libraries made in it; from the bottom to the top.
LAYERS = [
    ("kernels", ["kernels"]),
    ("sim/base", ["sim_base"]),
    ("sim/isolation", ["sim_isolation"]),
    ("sim/scenario", ["sim_scenario"]),
    ("sim/device", ["sim_device"]),
    ("sim/mesh", ["sim_mesh"]),
    ("sim/bone/voxmap", ["sim_voxmap"]),
    ("sim/bone/vdb", ["sim_bone_vdb"]),
    ("sim/scan", ["sim_scan"]),
    ("sim/bone", ["sim_bone"]),
    ("sim/anatomy", ["sim_anatomy"]),
    ("sim/tool", ["sim_tool"]),
    ("assets", ["reamer_shapes"]),
    ("sim/engine/common", []),
    ("sim/engine/dense", []),
    ("sim/engine/bricked", []),
    ("sim/engine/exact", []),
    ("sim/engine/serial", []),
    ("sim/engine/basis", []),
    ("sim/engine", ["sim_engine"]),
    ("sim/scene", ["sim_scene"]),
    ("sim/record", ["sim_record"]),
    ("sim/run", ["sim_run"]),
    ("sim/api", ["sim_api"]),
    ("sim/study", ["sim_study", "sim_study_forces"]),
    ("sim/bench", ["sim_bench"]),
    ("sim/verify", ["sim_verify"]),
    ("render/surface", ["render_surface"]),
    ("render/gl", ["render_gl"]),
    ("render/pictures", ["render_pictures"]),
    ("render/plots", ["render_plots"]),
    ("render", ["render"]),
    ("render/viewer", ["render_viewer"]),
    ("cli", ["reamsim"]),
    ("python/native", []),
]
RANK = {name: rank for rank, (folder, libraries) in enumerate(LAYERS) for name in [folder, *libraries]}

# Standing before is not enough for these: a picture needs no engine, an engine no file format, nothing but the
# command line needs the benchmark or the verification, and Python has the library of docs/library.md alone.
ENGINES = re.compile(r"sim[_/](engine|run|bench|verify)")
FORBIDDEN = [
    (re.compile(r"render"), ENGINES),
    (re.compile(r"sim[_/]engine"), re.compile(r"sim[_/](record|scene|anatomy|scan)|sim/bone/vdb")),  # the tool links VDB for distances
    (re.compile(r"(sim|render)(?![_/](bench|verify))"), re.compile(r"sim[_/](bench|verify)")),
    (re.compile(r"sim"), re.compile(r"render|cli")),
    (re.compile(r"python"), re.compile(r"(?!sim/api|python)")),
]


def link_graph(path):
    """Library -> all that it links, through other libraries too."""
    direct = {}
    for line in path.read_text().splitlines():
        library, links = line.split(":", 1)
        direct[library] = {name for name in links.split() if name in RANK}
    graph = {}
    for library in direct:
        graph[library], waiting = set(), [library]
        while waiting:
            for used in direct.get(waiting.pop(), set()) - graph[library]:
                graph[library].add(used)
                waiting.append(used)
    return graph


def include_graph(source):
    """Folder -> folders whose headers it includes, each with a place where it does."""
    graph = collections.defaultdict(dict)
    for top in ("sim", "render", "kernels", "assets", "cli", "python"):
        for path in sorted((source / top).rglob("*")):
            if path.suffix not in (".h", ".cpp"):
                continue
            folder = path.parent.relative_to(source).as_posix()
            for line in path.read_text().splitlines():
                found = re.match(r'#include "([^"]+)/[^/"]+"', line)
                if found and found[1] != folder:
                    graph[folder].setdefault(found[1], f"{path.relative_to(source)}: {line}")
    return graph


def mistakes(graph, kind):
    for user, used_by in graph.items():
        for used in used_by:
            if used not in RANK:
                continue
            where = used_by[used] if isinstance(used_by, dict) else ""
            if RANK[used] > RANK[user]:  # libraries of one folder may use one another
                yield f"{kind}: {user} uses {used}, which stands above it. {where}"
            for who, what in FORBIDDEN:
                if who.match(user) and what.match(used):
                    yield f"{kind}: {user} must not use {used}. {where}"


def main():
    source, links_file = map(pathlib.Path, sys.argv[1:3])
    links, includes = link_graph(links_file), include_graph(source)
    found = [*mistakes(links, "link"), *mistakes(includes, "include")]
    found += [f"{folder} stands in no layer" for folder in includes if folder not in RANK]
    found += [f"{library} stands in no layer" for library in links if library not in RANK]
    found += [f"{library} is no target" for _, libraries in LAYERS for library in libraries if library not in links]
    arrows = sum(len(used) for used in includes.values())
    linked = sum(len([name for name in used if name in RANK]) for used in links.values())
    print(f"{len(includes)} folders with {arrows} dependencies, {len(links)} targets with {linked}: {len(found)} mistakes")
    print("\n".join(found))
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
