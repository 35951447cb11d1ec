# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""described_path.py SOURCE: docs/architecture.md describes the code as it is.

Of the calls from `main` to the removed voxel, each function is defined in the file that its line names, and its body has the code
that the line quotes. Every source file that any page of the documentation names exists."""

import pathlib
import re
import sys

STEP = re.compile(r"^(\d+)\. `(\w+)` \(`([\w/.]+)`\)[^`\n]*`([^`\n]+)`", re.M)
# Files of results, of users and of the build are named as well.
SOURCE_FILE = re.compile(r"`((?:cli|cmake|kernels|python|render|sim|tests)/[\w/.]+\.\w+)`")


def body_of(function, text):
    """The bodies of the definitions of a function, one after the other."""
    found = ""
    for start in re.finditer(rf"^(?:[^\n/#]*[\s:*&])?{function}\(", text, re.M):
        depth = 0
        for at in range(start.end() - 1, len(text)):
            depth += (text[at] == "(") - (text[at] == ")")
            if depth == 0:
                break
        head = re.match(r"\)?\s*(?:const|override|noexcept|\s)*\{", text[at:])
        if not head:
            continue  # a call or a declaration
        begin = at + head.end()
        depth = 1
        for end in range(begin, len(text)):
            depth += (text[end] == "{") - (text[end] == "}")
            if depth == 0:
                break
        found += text[begin:end]
    return found


def main():
    root = pathlib.Path(sys.argv[1])
    page = (root / "docs/architecture.md").read_text()
    section = page.split("## From `main` to the removed voxel")[1].split("\n## ")[0]
    steps = STEP.findall(section)
    wrong = []
    for number, function, path, quoted in steps:
        body = " ".join(body_of(function, (root / path).read_text()).split())
        if not body:
            wrong.append(f"step {number}: {path} defines no {function}()")
        elif quoted not in body:
            wrong.append(f"step {number}: {function}() in {path} has no `{quoted}`")
    if [int(number) for number, *_ in steps] != list(range(1, len(steps) + 1)) or len(steps) < 8:
        wrong.append(f"the steps of the path are {[number for number, *_ in steps]}")
    for name in [*root.glob("*.md"), *root.glob("docs/**/*.md")]:
        if name.name != "CHANGELOG.md":
            named = sorted(set(SOURCE_FILE.findall(name.read_text())))
            wrong += [f"{name.relative_to(root)}: {path} does not exist" for path in named if not (root / path).exists()]
    print(*wrong, sep="\n")
    print(f"{len(steps) - 1} calls from main to the removed voxel, {len(wrong)} mistakes")
    sys.exit(1 if wrong else 0)


main()
