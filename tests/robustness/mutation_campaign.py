# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""mutation_campaign.py BUILD [--seed N] [--mutants N] [--quick]: do the tests find small faults?

Draws mutants from the sources of FOLDERS by a seed: each changes one operator or number of one line. In BUILD/tree, a worktree of the
HEAD at the first start, each mutant is built and tested until a test fails: with the tests of its room, then with those of
tests/quick.txt, then with all (--quick: without these). A mutant that does not compile, or that compiles to the same programs, is
replaced by the next of its draw. Results are appended to BUILD/mutants.jsonl as they come, and a mutant that is there is not tested
again, so that a campaign may be interrupted. Prints the mutants, what found them, and the survivors. A mutant takes a minute to half
an hour on two cores."""

import argparse
import hashlib
import json
import os
import pathlib
import random
import re
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ["kernels", "sim/engine", "sim/bone", "sim/anatomy", "sim/record"]
# What is replaced by what, each where it stands between spaces, as clang-format writes binary operators.
SWAPS = {" < ": [" <= ", " > "], " <= ": [" < "], " > ": [" >= ", " < "], " >= ": [" > "], " == ": [" != "], " != ": [" == "],
         " + ": [" - "], " - ": [" + "], " * ": [" / "], " / ": [" * "], " && ": [" || "], " || ": [" && "], " += ": [" -= "],
         " -= ": [" += "], "true": ["false"], "false": ["true"], "min(": ["max("], "max(": ["min("], "++": ["--"]}
NUMBER = re.compile(r"(?<![\w.\"'])(\d+(?:\.\d+)?(?:e-?\d+)?)(?![\w.\"'])")
# Lines that are no statement of the program, or whose change only alters a text.
SKIPPED = re.compile(r"^\s*(//|/\*|\*|#|static_assert|template|using |typedef|namespace |case .*:$)|\"")


def sites(text):
    """(line, column, what stands there, what replaces it) of every mutant of a file."""
    for number, line in enumerate(text.splitlines()):
        code = line.split("//")[0].split("/*")[0]
        if SKIPPED.search(code):
            continue
        for what, others in SWAPS.items():
            for found in re.finditer(re.escape(what), code):
                yield from ((number, found.start(), what, other) for other in others)
        for found in NUMBER.finditer(code):
            value = found[1]
            other = str(int(value) + 1) if value.isdigit() else f"{value.split('e')[0]}1" + ("e" + value.split("e")[1] if "e" in value else "")
            yield number, found.start(), value, other


def draw(seed, tree):
    """All mutants in a random order, a file as often as it has places for them."""
    files = subprocess.run(["git", "-C", tree, "ls-files", *FOLDERS], capture_output=True, text=True, check=True).stdout.split()
    mutants = [(name, *site) for name in files if name.endswith((".h", ".cpp", ".cl")) for site in sites((tree / name).read_text())]
    random.Random(seed).shuffle(mutants)
    return mutants


def mutated(text, line, column, what, other):
    lines = text.splitlines(keepends=True)
    assert lines[line][column:].startswith(what), (lines[line], column, what)
    lines[line] = lines[line][:column] + other + lines[line][column + len(what):]
    return "".join(lines)


def test_room(source):
    """The folder of tests whose subject a source is."""
    return "tests/engine" if source.startswith("kernels/") else "tests/" + source.split("/")[1]


class Campaign:
    def __init__(self, build, quick):
        self.build, self.tree, self.ninja, self.quick = build, build / "tree", build / "ninja", quick
        self.log = build / "mutants.jsonl"
        build.mkdir(parents=True, exist_ok=True)
        if not self.tree.exists():
            self.run("git", "-C", ROOT, "worktree", "add", "--detach", self.tree, "HEAD", check=True)
            self.run("cmake", "-G", "Ninja", "-S", self.tree, "-B", self.ninja, "-DCMAKE_BUILD_TYPE=Release", check=True)
        self.run("ninja", "-C", self.ninja, check=True)
        self.unchanged = self.programs()
        self.done = [json.loads(line) for line in self.log.read_text().splitlines()] if self.log.exists() else []
        self.quick_tests = self.run(sys.executable, self.tree / "tests/repository/quick_tests.py", self.tree, check=True).stdout.strip()

    @staticmethod
    def run(*command, check=False):
        done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False)
        assert not check or done.returncode == 0, f"{command}\n{done.stdout[-3000:]}{done.stderr[-3000:]}"
        return done

    def programs(self):
        """Checksum of every program and of the kernels, which are read when a program runs."""
        files = [path for folder in ("cli", "tests") for path in (self.ninja / folder).rglob("*") if path.is_file()
                 and os.access(path, os.X_OK)] + list((self.tree / "kernels").iterdir())
        return {path: hashlib.sha256(path.read_bytes()).digest() for path in sorted(files)}

    def failing(self, folder, *selection):
        """The first tests of a folder that fail."""
        tested = self.run("ctest", "--test-dir", self.ninja / folder, "--stop-on-failure", "--parallel", os.cpu_count() or 1, *selection)
        return [] if tested.returncode == 0 else re.findall(r"^\s*\d+ - (.+) \(\w", tested.stdout, re.M)[:3] or ["?"]

    def found_by(self, source):
        """The first tests that fail, none for a survivor; None where there is nothing to find."""
        room = test_room(source)
        if self.run("ninja", "-C", self.ninja, f"{room}/all").returncode != 0:
            return None
        if found := self.failing(room, "--label-exclude", "long"):
            return found
        if self.run("ninja", "-C", self.ninja).returncode != 0 or self.programs() == self.unchanged:
            return None
        found = self.failing(".", "--tests-regex", self.quick_tests)
        return found or ([] if self.quick else self.failing(".", "--label-exclude", "^(long|cluster|container|developer)$"))

    def judge(self, mutant):
        """The result of a mutant."""
        source, *site = mutant
        begin, path = time.monotonic(), self.tree / source
        original = path.read_text()
        path.write_text(mutated(original, *site))
        try:
            return {"mutant": list(mutant), "line": mutated(original, *site).splitlines()[site[0]].strip(),
                    "found_by": self.found_by(source), "seconds": round(time.monotonic() - begin)}
        finally:
            path.write_text(original)

    def result(self, mutant):
        known = [entry for entry in self.done if entry["mutant"] == list(mutant)]
        if known:
            return known[0]
        out = self.judge(mutant)
        with self.log.open("a") as log:
            log.write(json.dumps(out) + "\n")
        return out


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--mutants", type=int, default=300)
    parser.add_argument("--quick", action="store_true")
    options = parser.parse_args()
    print(f"seed {options.seed}, {options.mutants} mutants of {', '.join(FOLDERS)}", flush=True)
    campaign, results = Campaign(options.build, options.quick), []
    for mutant in draw(options.seed, campaign.tree):
        if len(results) == options.mutants:
            break
        result = campaign.result(mutant)
        if result["found_by"] is None:
            continue
        results.append(result)
        name, line, _, what, other = mutant
        print(f"{len(results)} {name}:{line + 1}: '{what.strip()}' → '{other.strip()}': {', '.join(result['found_by']) or 'SURVIVES'}", flush=True)
    survivors = [result for result in results if not result["found_by"]]
    print(f"\n{len(results) - len(survivors)} of {len(results)} found; survivors:")
    for result in survivors:
        print(f"  {result['mutant'][0]}:{result['mutant'][1] + 1}: {result['line']}")


main()
