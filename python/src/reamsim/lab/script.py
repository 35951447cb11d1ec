# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Figures come with the script that draws them, which needs matplotlib alone: a user edits and runs it."""

from __future__ import annotations

import inspect
import json
import pathlib
import re
from types import ModuleType
from typing import Any

from .tables import replace_file

_HEAD = '''# Written by reamsim. Draws {name}.png, {name}.svg and {name}.pdf beside it: python3 {name}.py

'''
_TAIL = '''

DATA = json.loads(r"""
{data}
""")

if __name__ == "__main__":
    draw(DATA, pathlib.Path(__file__).resolve().parent)
'''


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
