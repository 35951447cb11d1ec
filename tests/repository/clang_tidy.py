# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""clang_tidy.py ROOT FOLDER...: clang-tidy 14 finds nothing in the files below these folders with the checks of .clang-tidy.

It reads the units of the preset `tidy`, each of which includes up to 12 files: headers of libraries cost most of its time. Those of
tests have fewer checks (tests/.clang-tidy). Skipped (77) without clang 14."""

import concurrent.futures
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

FINDING = re.compile(r"^\S+:\d+:\d+: (?:warning|error): .*\[\S+\]$", re.MULTILINE)
SKIPPED = 77
# What engines are measured against: vectors in GCC's own words, and memory that is not cleared before it is filled.
WITHOUT = "tests/bench/reference/"
# Debian's ITK says this to every compiler but GCC, and can be read all the same.
ITK_ON_CLANG = "itk_compiler_detection.h"


def configure(root):
    """Compile commands, and the sources and headers that the build generates: clang-tidy compiles nothing. Returns the build folder."""
    build = root / "build/tidy"
    subprocess.run(["cmake", "--preset", "tidy"], cwd=root, check=True, stdout=subprocess.DEVNULL)
    rules = subprocess.run(["ninja", "-C", build, "-t", "targets", "all"], check=True, capture_output=True, text=True).stdout
    generated = re.findall(r"^([^/\s]\S*\.(?:cpp|h)): CUSTOM_COMMAND$", rules, re.MULTILINE)
    assert generated, "no generated sources; has the output of `ninja -t targets` another form?"
    # Built by name, they would come after the libraries that their targets link.
    commands = subprocess.run(["ninja", "-C", build, "-t", "commands", "-s", *generated], check=True, capture_output=True, text=True).stdout
    subprocess.run(["sh", "-ec", commands], check=True, stdout=subprocess.DEVNULL)
    return build


def findings_of(config, build, folders, unit):
    """The texts of the findings that a unit shows in the folders, each with its notes."""
    headers = f"^({'|'.join(map(re.escape, folders))})/"
    done = subprocess.run(["clang-tidy-14", "-p", build, f"--config-file={config}", f"--header-filter={headers}", "--quiet",
                           "--warnings-as-errors=*", unit],
                          capture_output=True, text=True)
    starts = [found.start() for found in FINDING.finditer(done.stdout)]
    texts = [done.stdout[begin:end].rstrip() for begin, end in zip(starts, starts[1:] + [None])]
    if texts and ITK_ON_CLANG in texts[0] and "Unsupported compiler" in texts[0]:
        return texts[1:]
    if done.returncode != 0 and not texts:
        texts = [f"{unit}: clang-tidy ended with {done.returncode}\n{done.stdout}{done.stderr}"]
    return texts


def place_of(root, build, file):
    """A file's place in the sources; the units of sim/study are in build/tidy/sim/study/CMakeFiles."""
    return file.replace(str(build), str(root)).removeprefix(f"{root}/")


def config_of(root, place):
    return root / ("tests/.clang-tidy" if place.startswith("tests/") else ".clang-tidy")


def check_that_mistakes_are_found(root, folder):
    """In a source that a unit includes, and in a header."""
    (folder / "sim").mkdir()
    (folder / "sim/part.h").write_text("#pragma once\nstruct Part {\n  int number;\n  Part() {}\n};\n")
    (folder / "sim/part.cpp").write_text('#include <string>\n#include <utility>\n#include "part.h"\n'
                                         "std::size_t length(std::string text) {\n  const std::string all = std::move(text);\n"
                                         "  return text.size() + all.size();\n}\n")
    unit = folder / "unit.cxx"
    unit.write_text('#include "sim/part.cpp"\n')
    (folder / "compile_commands.json").write_text(json.dumps(
        [{"directory": str(folder), "file": str(unit), "command": f"clang++-14 -std=c++20 -c {unit}"}]))
    text = "\n".join(findings_of(root / ".clang-tidy", folder, [str(folder / "sim")], unit))
    assert "part.cpp:6:10: error:" in text and "bugprone-use-after-move" in text, text
    assert "part.h:4:3: error:" in text and "pro-type-member-init" in text, text


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    folders = [str(root / folder) for folder in sys.argv[2:]]
    assert folders and all(map(os.path.isdir, folders)), f"no such folders: {sys.argv[2:]}"
    for tool in ("clang-tidy-14", "clang++-14"):
        if shutil.which(tool) is None:
            print(f"skipped: {tool} is missing (packages clang-tidy-14 and clang-14)")
            sys.exit(SKIPPED)
    with tempfile.TemporaryDirectory() as folder:
        check_that_mistakes_are_found(root, pathlib.Path(folder))
    build = configure(root)
    commands = json.loads((build / "compile_commands.json").read_text())
    files = {command["file"] for command in commands}
    places = {file: place_of(root, build, file) for file in files}
    units = sorted(file for file, place in places.items() if place.startswith(tuple(f"{folder}/" for folder in sys.argv[2:]))
                   and not place.startswith(WITHOUT))
    assert units, f"no file below {folders} is compiled"
    known = set()  # a header belongs to many units
    with concurrent.futures.ThreadPoolExecutor(os.cpu_count()) as pool:
        for unit, texts in zip(units, pool.map(lambda unit: findings_of(config_of(root, places[unit]), build, folders, unit), units)):
            print(f"{pathlib.Path(unit).relative_to(root)}: {len(texts)} findings", flush=True)
            for text in texts:
                if text not in known:
                    print(text, flush=True)
            known.update(texts)
    sys.exit(f"{len(known)} findings" if known else 0)


main()
