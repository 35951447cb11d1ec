# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Text of tables and files, as the program writes it; figures come with the script that draws them, which needs matplotlib
alone: a user edits and runs it."""

from __future__ import annotations

import inspect
import json
import math
import os
import pathlib
import re
from collections.abc import Iterable, Sequence
from types import ModuleType
from typing import Any

_HEAD = '''# Written by reamsim. Draws {name}.png, {name}.svg and {name}.pdf beside it: python3 {name}.py

'''
_TAIL = '''

DATA = json.loads(r"""
{data}
""")

if __name__ == "__main__":
    draw(DATA, pathlib.Path(__file__).resolve().parent)
'''


def number_text(value: float) -> str:
    """The fewest digits that read back to the same value; an integer without exponent and fraction; "" of NaN."""
    if math.isnan(value):
        return ""
    return str(int(value)) if value == int(value) and abs(value) <= 2 ** 53 else repr(float(value))


def csv_text(text: str) -> str:
    """A text as a CSV cell (RFC 4180). A spreadsheet would take a text that begins with =, +, - or @ for a formula, so an
    apostrophe precedes it."""
    text = "'" + text if text[:1] in tuple("=+-@") else text
    return '"' + text.replace('"', '""') + '"' if "," in text or '"' in text else text


def write_csv(path: str | os.PathLike[str], header: Sequence[str], rows: Iterable[Sequence[float | str]]) -> None:
    """A CSV file of numbers and texts."""
    lines = [",".join(header)]
    lines += [",".join(csv_text(cell) if isinstance(cell, str) else number_text(cell) for cell in row) for row in rows]
    replace_file(path, "\n".join(lines) + "\n")


def json_text(value: Any) -> str:
    """JSON with two spaces of indentation; NaN is null."""
    finite = json.loads(json.dumps(value), parse_constant=lambda name: None if name == "NaN" else float(name))
    return json.dumps(finite, indent=2, ensure_ascii=False) + "\n"


def replace_file(path: str | os.PathLike[str], text: str) -> None:
    """Writes a file, which has either the old or the new content. Raises OSError, with the name of the file."""
    unfinished = pathlib.Path(f"{os.fspath(path)}.tmp")
    try:
        with open(unfinished, "w", encoding="utf-8", newline="\n") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        os.replace(unfinished, path)
    except OSError as error:
        unfinished.unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror, os.fspath(path)) from error


def aligned(rows: Sequence[Sequence[str]]) -> list[str]:
    """The lines of a table of text: the first column left-aligned, the others right-aligned. No row has more cells than
    the first."""
    widths = [max(len(row[i]) if i < len(row) else 0 for row in rows) for i in range(len(rows[0]))]
    return ["  ".join([row[0].ljust(widths[0])] + [cell.rjust(width) for cell, width in zip(row[1:], widths[1:])])
            for row in rows]


def draw_with_script(figure: ModuleType, data: dict[str, Any], folder: str, name: str) -> None:
    """Draws FOLDER/NAME .png, .svg and .pdf, and writes NAME.py, which does the same.

    Args:
        figure: has ``draw(data, folder)``.
    """
    from . import figure_style

    style, drawing = (re.sub(r"^(# SPDX.*\n)+|^from \.figure_style .*\n", "", inspect.getsource(module), flags=re.MULTILINE)
                      for module in (figure_style, figure))
    replace_file(f"{folder}/{name}.py", _HEAD.format(name=name) + "import json\nimport pathlib\n" + style + drawing +
                 _TAIL.format(data=json.dumps(data)))  # JSON never has three quotes in a row
    pathlib.Path(folder, f"{name}.gp").unlink(missing_ok=True)  # of an older version, with its data
    figure.draw(data, folder)
