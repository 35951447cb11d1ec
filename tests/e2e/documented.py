# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""The commands in README and docs, as they are written."""

import re

WORDS = ("reamsim|gnuplot|ctest|cmake|ninja|git|sbatch|scontrol|snakemake|parallel|sudo|apt-get|podman|docker|mmdebstrap|cd|export|ls|ulimit|"
         r"python3|pip|doxygen|mkdocs|npm|reuse|clang-format-14|TotalSegmentator|fuzz_readers|\w+_(?:test|bench)")
# What code within a sentence begins with if it is a command; else it is data, a key or a file.
PROGRAM = re.compile(rf"(?:[A-Z_]+=\S+ )+\S|(?:time )?(?:{WORDS})(?: |$)|(?:\./\w+\.sh|\.ci/run|build/release/cli/reamsim)\b"
                     r"|(?:[~.\w-]+/)*[\w-]+\.(?:py|sh) |(?:~|venv|build)/\S+ ")


def pages(root):
    """README and others, the guide, then the rest of docs."""
    guide = sorted(root.glob("docs/guide/*.md"))
    paths = [*(root / f"{name}.md" for name in ("README", "SECURITY", "CONTRIBUTING")), *guide, *sorted({*root.glob("docs/**/*.md")} - {*guide})]
    return [str(path.relative_to(root)) for path in paths]


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


def lines_of_shell(text):
    """The lines of blocks without a language and of `sh`. A block that begins with `cd` is one command; a whole script is none."""
    out = []
    for language, block in parts(text)[0]:
        lines = [without_comment(line) for line in block.splitlines() if line.strip()]
        if language in ("", "sh") and not block.startswith("#!"):
            out += ["; ".join(lines)] if re.match(r"cd \S+\n", block) else lines
    return out


def without_comment(line):
    return re.sub(r"\s+# .*", "", line).strip()


def commands(text):
    """Shell commands of a page: every line of its shell blocks, and of indented lines and code within sentences those that begin with a
    program."""
    text = re.sub(r"\\\n *", "", text)
    plain = parts(text)[1]
    found = [without_comment(line) for line in plain.splitlines() if re.match(r"    \S", line)]
    found += [span.replace("\\|", "|") for span in re.findall(r"`([^`\n]+)`", plain)]
    return list(dict.fromkeys(lines_of_shell(text) + [command for command in found if PROGRAM.match(command)]))


# What differs from machine to machine and from run to run.
OF_THE_MACHINE = re.compile(r"simulated in|^(results|look first|time|memory|disk|table|main effects|page)\b")


def printed(text):
    """What a page says that a command prints, by command: the lines of a `text` block that follows the block of the command."""
    fenced, out = parts(text)[0], {}
    for (language, block), (next_language, output) in zip(fenced, fenced[1:]):
        command = block.strip()
        if language in ("", "sh") and next_language == "text" and re.match(r"reamsim [^\n]*$", command):
            out[command] = [line for line in output.splitlines() if line and not OF_THE_MACHINE.search(line)]
    return out


def all_commands(root):
    return {page: commands((root / page).read_text()) for page in pages(root)}
