# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""The commands in README and docs, as they are written."""

import re

PAGES = ["README.md", "SECURITY.md", "CONTRIBUTING.md", *(f"docs/{name}.md" for name in (
    *(f"guide/{name}" for name in ("first-run", "ct", "mesh", "resolution", "forces", "push", "uncertainty", "pictures", "how-it-works")),
    "architecture", "cluster", "commands", "engines", "formats", "gallery", "glossary", "install", "library", "physics", "preview", "release", "reliability", "stability", "studies", "validation", "verification"))]
# What a line of a shell begins with; else it is data or a figure.
PROGRAM = r"(?:[A-Z_]+=\S+ )?(?:time )?(?:reamsim(?!/|::|\.)|build/release/\S+|\./\w+\.sh|gnuplot|ctest|cmake|git|sbatch)\b"


def parts(text):
    """The fenced blocks of a page as (language, text without their indent), and the page without them."""
    fenced, plain, block = [], [], None
    for line in text.splitlines():
        fence = re.match(r"( *)```(.*)$", line)
        if fence and block is None:
            block = (fence[2].strip(), len(fence[1]), [])
        elif fence:
            fenced.append((block[0], "".join(f"{inner[block[1]:]}\n" for inner in block[2])))
            block = None
        else:
            (plain if block is None else block[2]).append(line)
    return fenced, "\n".join(plain)


def blocks(text, language):
    return [block for name, block in parts(text)[0] if name == language]


def commands(text):
    """Shell commands of a page: lines of blocks without a language, indented lines, and code within sentences."""
    lines = [line for block in blocks(text, "") for line in block.splitlines()]
    plain = parts(text)[1].replace("\\\n", "")
    lines += [line[4:] for line in plain.splitlines() if re.match(r"    \S", line)]
    spans = re.findall(r"`([^`\n]+)`", plain)
    found = [re.sub(r"\s+# .*", "", line).strip() for line in lines + [span.replace("\\|", "|") for span in spans]]
    return list(dict.fromkeys(command for command in found if re.match(PROGRAM, command)))


# What differs from machine to machine and from run to run.
OF_THE_MACHINE = re.compile(r"simulated in|^(results|look first|time|memory|disk)\b")


def printed(text):
    """What a page says that a command prints, by command: the lines of a `text` block that follows the block of the command."""
    fenced, out = parts(text)[0], {}
    for (language, block), (next_language, output) in zip(fenced, fenced[1:]):
        command = block.strip()
        if language in ("", "sh") and next_language == "text" and re.match(r"reamsim [^\n]*$", command):
            out[command] = [line for line in output.splitlines() if line and not OF_THE_MACHINE.search(line)]
    return out


def all_commands(root):
    return {page: commands((root / page).read_text()) for page in PAGES}
