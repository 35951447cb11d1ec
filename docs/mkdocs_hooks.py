# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""What mkdocs calls while it builds the site (`hooks` in mkdocs.yml)."""

import json
import pathlib
import re


def on_page_markdown(markdown, page, **_):
    """The page of a notebook has its cells; a browser cannot show the file itself."""
    notebook = pathlib.Path(page.file.abs_src_path).with_suffix(".ipynb")
    if not notebook.exists():
        return markdown
    cells = [(cell["cell_type"], "".join(cell["source"])) for cell in json.loads(notebook.read_text())["cells"]]
    shown = [text if kind == "markdown" else f"```python\n{text}\n```" for kind, text in cells]
    return "\n\n".join([shown[0], markdown, *shown[1:]])


def on_page_content(html, **_):
    """A bar in a cell is written as `\\|`, which GitHub shows as a bar. Python's Markdown keeps the backslash within code."""
    return re.sub(r"<td.*?</td>", lambda cell: cell[0].replace("\\|", "|"), html, flags=re.S)
