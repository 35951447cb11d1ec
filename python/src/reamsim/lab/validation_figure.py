# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Published numbers with their intervals (black), and models in colours; a panel for each result."""

import re

from .figure_style import BLUE, RED, few_tics, new_figure, save, style

COLORS = (RED, "#009e73", BLUE, "#cc79a7", "#e69f00", "#56b4e9")


def draw(data, folder):
    """Draws FOLDER/NAME .png, .svg and .pdf.

    Args:
        data: ``name``; ``title``; ``panels``: each with ``title``, titles of the axes ``y`` and ``x_title``, ``x``, ``names``
            of x or None, ``value``, ``low`` and ``high`` (None: missing, or an open end), and ``models``: values by name.
            Models whose names are the same up to a comma have one colour, and markers alone behind the comma.
    """
    panels = data["panels"]
    wide = min(len(panels), 2)
    tall = -(-len(panels) // wide)
    legend = 5 * -(-(len(panels[0]["models"]) + 1) // (wide + 1))  # mm
    with style():
        figure = new_figure(90 * wide, 6 + 58 * tall + legend)
        grid = figure.subplots(tall + 1, wide, squeeze=False, height_ratios=[44] * tall + [legend]).ravel()
        for axes, panel in zip(grid, panels):
            draw_panel(axes, panel)
        for axes in grid[len(panels):]:
            axes.set_axis_off()
        figure.legend(*grid[0].get_legend_handles_labels(), loc="lower center", ncols=wide + 1, frameon=False, fontsize=7.5)
        figure.suptitle(data["title"], fontsize=8)
        save(figure, folder, data["name"])


def draw_panel(axes, panel):
    ends = [end for key in ("value", "low", "high") for end in panel[key] if end is not None]
    arrow = 0.1 * (max(ends) - min(ends) or 1)  # at an open end of an interval
    bases = list(dict.fromkeys(name.split(",")[0] for name in panel["models"]))
    step = 0.1 if panel["names"] else 0.015 * (max(panel["x"]) - min(panel["x"]))  # side by side
    for i, (name, values) in enumerate(panel["models"].items()):
        base, variant = name.split(",")[0], "," in name
        x = [x + step * (i + 1) for x in panel["x"]]
        axes.plot(x, [float("nan") if value is None else value for value in values], marker="o", markersize=3.5, linewidth=1.1,
                  linestyle="none" if panel["names"] or variant else "-", color=COLORS[bases.index(base) % len(COLORS)],
                  markerfacecolor="white" if variant else None, label=name)
    for i, (x, value, low, high) in enumerate(zip(*(panel[key] for key in ("x", "value", "low", "high")))):
        middle = (low + high) / 2 if value is None else value
        error = [[arrow if low is None else middle - low], [arrow if high is None else high - middle]]
        axes.errorbar([x], [middle], error, uplims=low is None, lolims=high is None, color="black", linewidth=1.1, capsize=2.5,
                      marker="none" if value is None else "s", markersize=3.5, zorder=5, label=None if i else "published, with interval")
    axes.set_title(panel["title"], fontsize=8)
    axes.set_ylabel(panel["y"])
    axes.set_xlabel(re.sub("_(rpm|mm|deg|n)$", r" (\1)", (panel["x_title"] or "").rsplit(".", 1)[-1]).replace("_", " "))
    axes.set_xticks(panel["x"], panel["names"] or [f"{x:g}" for x in panel["x"]])
    axes.margins(x=0.1)
    few_tics(axes.yaxis, 6)
