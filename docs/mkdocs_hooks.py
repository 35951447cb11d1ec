# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""What mkdocs calls while it builds the site (`hooks` in mkdocs.yml)."""

import re


def on_page_content(html, **_):
    """A bar in a cell is written as `\\|`, which GitHub shows as a bar. Python's Markdown keeps the backslash within code."""
    return re.sub(r"<td.*?</td>", lambda cell: cell[0].replace("\\|", "|"), html, flags=re.S)
