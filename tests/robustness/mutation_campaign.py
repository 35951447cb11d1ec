# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""mutation_campaign.py BUILD [--seed N] [--mutants N] [--again RESULTS]: mutation testing with the tests of ./test.sh.

Draws mutants of the sources in FOLDERS by a seed (mutants.py: one operator, number, truth value, min or max each) and builds
all of them at once in BUILD/tree, a worktree of HEAD at the first start, in place of one build per mutant. Three steps follow:
1. every test without a mutant: it must pass, and tells which mutants it executes (of kernels: whether it uses a device);
2. each mutant by itself: quick ones among the tests that execute it, until one fails or exceeds its time;
3. the other tests with all remaining mutants at once, and where one fails, with halves of them.
Results are appended to BUILD/results.jsonl as they come; an interrupted campaign continues from them. --again: only the survivors of an
earlier campaign, whose sources must not have changed. Needs python3-clang and libclang; on two cores about an hour and a half."""

import argparse
import collections
import concurrent.futures
import glob
import hashlib
import json
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile
import threading
import time

import clang.cindex
import mutants

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ["kernels", "sim/engine", "sim/bone", "sim/anatomy", "sim/record"]
ALONE_S = 20  # of tests with a mutant by itself; the others run with all remaining mutants at once
DEVICE = 0  # number of the mark that a program has compiled kernels
WORKERS = os.cpu_count() or 1
CONFIGURE = ["-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release", "-DCMAKE_UNITY_BUILD=ON", "-DCMAKE_UNITY_BUILD_BATCH_SIZE=0",
             "-DREAMSIM_TESTS=ON", "-DREAMSIM_BROWSER_TESTS=OFF", "-DCMAKE_EXPORT_COMPILE_COMMANDS=ON"]


def shell(*command, check=True, **options):
    done = subprocess.run([str(part) for part in command], capture_output=True, text=True, check=False, **options)
    assert not check or done.returncode == 0, f"{command}\n{done.stdout[-3000:]}{done.stderr[-3000:]}"
    return done


class Source:
    """The worktree, with all mutants of a draw compiled in."""

    def __init__(self, build, seed, count):
        self.build, self.tree, self.ninja = build, build / "tree", build / "tree/build/release"
        build.mkdir(parents=True, exist_ok=True)
        self.record = build / "mutants.json"
        if not self.record.exists():
            shutil.rmtree(self.tree, ignore_errors=True)
            shell("git", "-C", ROOT, "worktree", "prune")
            shell("git", "-C", ROOT, "worktree", "add", "--detach", self.tree, "HEAD")
            shell("cmake", "-S", self.tree, "-B", self.ninja, *CONFIGURE)
            self.compile_in(self.drawn(seed, count), count)
        self.mutants = {int(number): change for number, change in json.loads(self.record.read_text()).items()}

    def drawn(self, seed, count):
        """More than asked for, because some do not compile. {number: (file, begin, end, operands, operator, replacement)}"""
        changes = mutants.find(self.tree, self.ninja, FOLDERS)
        random.Random(seed).shuffle(changes)
        print(f"{len(changes)} possible mutants", flush=True)
        return dict(enumerate(changes[:count + count // 2], 1))

    def compile_in(self, chosen, count):
        switch = self.build / "mutant_switch.h"
        switch.write_text(mutants.SWITCH)
        opencl = self.tree / "sim/device/opencl.cpp"
        originals = {name: (self.tree / name).read_bytes() for name in {change[0] for change in chosen.values()}}
        marked = opencl.read_text().replace("  cl_int status = CL_SUCCESS;\n  Program program(", f"  (void)MUT({DEVICE});\n"
                                            "  cl_int status = CL_SUCCESS;\n  Program program(", 1)
        assert "MUT(" in marked, "where kernels are compiled has changed"
        opencl.write_text(mutants.first_lines(switch) + marked)
        while True:
            for name, text in originals.items():
                changes = [(number, *change[1:]) for number, change in chosen.items() if change[0] == name]
                (self.tree / name).write_bytes(mutants.first_lines(switch).encode() + mutants.mutated(text, changes) if changes else text)
            built = shell("ninja", "-C", self.ninja, "-k", "0", check=False)
            broken = {int(number) for line in re.findall(r"error:.*\n(?:\s*\d* \|.*\n)+", built.stdout) for number in re.findall(r"MUT\((\d+)\)", line)}
            broken |= mutants.broken_kernels(self.tree / "kernels")
            print(f"{len(chosen)} mutants, of which {len(broken & set(chosen))} do not compile", flush=True)
            if not broken & set(chosen):
                assert built.returncode == 0, built.stdout[-5000:]
                break
            chosen = {number: change for number, change in chosen.items() if number not in broken}
        self.record.write_text(json.dumps(dict(list(chosen.items())[:count])))

    def line(self, number):
        """FILE:LINE: the line without and the change."""
        name, begin, _, _, what, other = self.mutants[number]
        text = shell("git", "-C", self.tree, "show", f"HEAD:{name}").stdout.encode()
        line = text[:begin].count(b"\n")
        return f"{name}:{line + 1}: '{what}' → '{other.strip()}' in: {text.splitlines()[line].decode().strip()}"


class Tests:
    """The tests of ./test.sh, each run by itself and by one worker at a time, because some write in a folder of their own."""

    def __init__(self, source):
        self.source, self.locks = source, collections.defaultdict(threading.Lock)
        known = json.loads(shell("ctest", "--test-dir", source.ninja, "--show-only=json-v1", "--label-exclude",
                                 "^(long|cluster|container|developer|browser)$").stdout)["tests"]
        self.known = {test["name"]: {entry["name"]: entry["value"] for entry in test["properties"]} | {"COMMAND": test["command"]}
                      for test in known if "command" in test}
        self.first = {fixture: test["COMMAND"] for test in self.known.values() for fixture in test.get("FIXTURES_SETUP", [])}

    def passes(self, name, switched=(), reached=None, limit_s=None):
        test = self.known[name]
        with self.locks[name], tempfile.TemporaryDirectory(prefix="mutants-") as folder:
            environment = os.environ | dict(entry.split("=", 1) for entry in test.get("ENVIRONMENT", []))
            environment |= {"XDG_CACHE_HOME": folder, "REAMSIM_MUTANTS": " ".join(map(str, switched)), "GTEST_FAIL_FAST": "1"}
            environment.pop("REAMSIM_MUTANTS_REACHED", None)
            environment["POCL_CACHE_DIR"] = str(self.source.build / "pocl")
            if reached:
                reached.write_bytes(bytes(4096))
                environment["REAMSIM_MUTANTS_REACHED"] = str(reached)
            if kernels := self.kernels(switched, folder):
                environment["REAMSIM_KERNEL_DIR"] = kernels
            commands = [self.first[fixture] for fixture in test.get("FIXTURES_REQUIRED", [])] + [test["COMMAND"]]
            expected = test.get("WILL_FAIL", False)
            statuses = [self.run(command, environment, test["WORKING_DIRECTORY"], limit_s or test.get("TIMEOUT", 1500)) for command in commands]
            return all(status in (0, test.get("SKIP_RETURN_CODE")) for status in statuses) != expected

    @staticmethod
    def run(command, environment, folder, limit_s):
        """Its exit status, None after limit_s. With the processes that it started, it is ended."""
        program = subprocess.Popen(command, env=environment, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                   stderr=subprocess.DEVNULL, start_new_session=True,
                                   preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CORE, (0, 0)))
        try:
            return program.wait(limit_s)
        except subprocess.TimeoutExpired:
            return None
        finally:
            try:
                os.killpg(program.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
            program.wait()

    def kernels(self, switched, folder):
        """A folder of kernels with these mutants, by which PoCL caches them; None where none of them is in a kernel."""
        chosen = [number for number in switched if self.source.mutants[number][0].startswith("kernels/")]
        if not chosen:
            return None
        out = self.source.build / "kernels" / hashlib.sha256(repr(chosen).encode()).hexdigest()[:16]
        with self.locks[str(out)]:
            if not out.exists():
                made = pathlib.Path(folder) / "kernels"
                shutil.copytree(self.source.tree / "kernels", made)
                switch = f"#define MUT(number) ({' || '.join(f'(number) == {number}' for number in chosen)})\n"
                for kernel in made.glob("*.cl"):  # in each, because a cache may know the kernel without what it includes
                    kernel.write_text(switch + kernel.read_text())
                out.parent.mkdir(exist_ok=True)
                shutil.move(made, out)
        return str(out)


class Campaign:
    def __init__(self, source, tests, again):
        self.source, self.tests, self.again = source, tests, again
        self.reached, self.seconds, self.lock = {}, {}, threading.Lock()
        self.log = source.build / "results.jsonl"
        entries = [json.loads(line) for line in self.log.read_text().splitlines()] if self.log.exists() else []
        self.found = {entry["number"]: entry["found_by"] for entry in entries if entry["found_by"]}
        self.passed_alone = {entry["number"] for entry in entries if not entry["found_by"]}

    def baseline(self):
        """Which mutants a test executes, and how long it takes."""
        record, folder, lock = self.source.build / "baseline.jsonl", self.source.build / "reached", threading.Lock()
        folder.mkdir(exist_ok=True)
        record.touch()

        def measure(name):
            begin, marks = time.monotonic(), folder / re.sub(r"\W", "_", name)
            passed = self.tests.passes(name, reached=marks)
            out = [name, passed, time.monotonic() - begin, [number for number, mark in enumerate(marks.read_bytes()) if mark]]
            with lock, record.open("a") as file:
                file.write(json.dumps(out) + "\n")

        done = {json.loads(line)[0] for line in record.read_text().splitlines()}
        parallel(measure, [name for name in self.tests.known if name not in done])
        for name, passed, seconds, marks in map(json.loads, record.read_text().splitlines()):
            if passed:
                self.seconds[name], self.reached[name] = seconds, set(marks)
            else:
                print(f"left out, because it fails without a mutant, as those do that read the sources: {name}", flush=True)

    def executes(self, test, number):
        marks = self.reached[test]
        return number in marks or DEVICE in marks and self.source.mutants[number][0].startswith("kernels/")

    def passes(self, test, numbers):
        return self.tests.passes(test, numbers, limit_s=5 * self.seconds[test] + 15)

    def note(self, number, found_by):
        """found_by: a test, or "" after step 2."""
        if found_by:
            self.found[number] = found_by
        with self.lock, self.log.open("a") as log:
            log.write(json.dumps({"number": number, "found_by": found_by, "line": self.source.line(number)}) + "\n")
        print(f"{number}: {found_by}: {self.source.line(number)}", flush=True)

    def alone(self, number):
        """The tests of step 2 for a mutant: of those that execute it, the quickest, first those of its folder."""
        folder = self.source.mutants[number][0].split("/")
        room = "/tests/engine/" if folder[0] == "kernels" else f"/tests/{folder[1]}/"
        left_s = ALONE_S
        for test in sorted(self.reached, key=lambda test: (room not in self.tests.known[test]["COMMAND"][0], self.seconds[test])):
            if self.executes(test, number) and self.seconds[test] < left_s:
                left_s -= self.seconds[test]
                yield test

    def quick(self, number):
        """Step 2 for a mutant."""
        for test in self.alone(number):
            if not self.passes(test, [number]):
                return self.note(number, test)
        self.note(number, "")

    def together(self, test, numbers):
        """Step 3: those of the mutants that a test finds."""
        numbers = [number for number in numbers if number not in self.found]  # meanwhile, by another test
        if not numbers or self.passes(test, numbers):
            return []
        if len(numbers) == 1:
            self.note(numbers[0], test)
            return numbers
        half = len(numbers) // 2
        return self.together(test, numbers[:half]) + self.together(test, numbers[half:])

    def run(self, count):
        self.baseline()
        wanted = [number for number in self.source.mutants if self.again is None or self.source.line(number) in self.again][:count]
        parallel(self.quick, [number for number in wanted if number not in self.found and number not in self.passed_alone])
        tried = {number: set(self.alone(number)) for number in wanted}
        parallel(lambda test: self.together(test, [number for number in wanted if number not in self.found and test not in tried[number]
                                                   and self.executes(test, number)]), sorted(self.reached, key=self.seconds.get))
        survivors = [number for number in wanted if number not in self.found]
        print(f"\n{len(wanted) - len(survivors)} of {len(wanted)} found; survivors:")
        executed = set().union(*self.reached.values())
        for number in survivors:
            known = number in executed or self.source.mutants[number][0].startswith("kernels/")
            print(f"  {self.source.line(number)}{'' if known else '   (executed by no test)'}")
        by_folder = collections.Counter(next(folder for folder in FOLDERS if self.source.mutants[number][0].startswith(folder)) for number in wanted)
        lost = collections.Counter(next(folder for folder in FOLDERS if self.source.mutants[number][0].startswith(folder)) for number in survivors)
        for folder in FOLDERS:
            print(f"{folder}: {by_folder[folder] - lost[folder]} of {by_folder[folder]}")


def parallel(function, work):
    with concurrent.futures.ThreadPoolExecutor(WORKERS) as workers:
        return list(workers.map(function, work))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("build", type=lambda text: pathlib.Path(text).resolve())
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--mutants", type=int, default=300)
    parser.add_argument("--again", type=pathlib.Path)
    options = parser.parse_args()
    libraries = sorted(glob.glob("/usr/lib/llvm-*/lib/libclang.so.1") + glob.glob("/usr/lib/llvm-*/lib/libclang-*.so.1"))
    if libraries:
        clang.cindex.Config.set_library_file(libraries[-1])
    print(f"seed {options.seed}, {options.mutants} mutants of {', '.join(FOLDERS)}", flush=True)
    source = Source(options.build, options.seed, options.mutants)
    again = None
    if options.again:
        found = {entry["line"] for entry in map(json.loads, options.again.read_text().splitlines()) if entry["found_by"]}
        again = {source.line(number) for number in source.mutants} - found
    Campaign(source, Tests(source), again).run(options.mutants)


main()
