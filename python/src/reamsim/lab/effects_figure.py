# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Main effects: a column of panels for each parameter, those that explain most first; a row for each result."""

from .figure_style import BLUE, GREY, LIGHT_GREY, few_tics, new_figure, save, style

WIDE, WIDEST_PANEL, TALL_PANEL = 154.0, 62.0, 34.0  # mm: all panels; a panel with what stands beside it
CHARACTER = 1.5  # mm
MOST_NAMED_LEVELS = 8  # names that fit the axis of a panel; with more it counts them
MOST_IN_NAME = 22


def draw(data, folder):
    """Draws FOLDER/effects .png, .svg and .pdf.

    Args:
        data: ``parameters``: each with ``title``, ``numeric``, ``levels`` (names; empty for intervals), ``x`` of the single
            runs, ``range`` of x of all runs, ``spread`` (least distance of levels), and by result ``groups`` (x, mean,
            standard deviation, level) and ``explained``. ``results``: each with ``title``, ``y`` of the single runs (null:
            missing) and ``range`` of all runs.
    """
    parameters, results = data["parameters"], data["results"]
    wide = min(WIDE / len(parameters), WIDEST_PANEL)
    with style():
        figure = new_figure(max(26 + wide * len(parameters), 110), 24 + TALL_PANEL * len(results))
        panels = figure.subplots(len(results), len(parameters), sharex="col", sharey="row", squeeze=False)
        figure.suptitle("Mean ± SD over all other parameters; grey: single runs\n%: fraction of the variance explained",
                        x=0.01, ha="left", fontsize=8, color=GREY)
        for r, (row, result) in enumerate(zip(panels, results)):
            row[0].set_ylabel(on_lines(result["title"], TALL_PANEL - 10))
            for axes, parameter in zip(row, parameters):
                draw_panel(axes, parameter, result, r)
        for axes, parameter in zip(panels[-1], parameters):
            name_levels(axes, parameter, wide - 5)
        figure.align_labels()
        save(figure, folder, "effects")


def draw_panel(axes, parameter, result, r):
    low, high = parameter["range"]
    air = 0.12 * (high - low) if parameter["numeric"] else 0.5
    spread = min(0.24 * parameter["spread"], 0.08 * (high - low + 2 * air)) if parameter["levels"] else 0
    runs = [(x, y) for x, y in zip(parameter["x"], result["y"]) if y is not None]
    aside = [(0.618034 * i) % 1 - 0.5 for i in range(len(runs))]  # runs of the same level are beside one another
    axes.plot([x + spread * at for (x, _), at in zip(runs, aside)], [y for _, y in runs], ".", color=LIGHT_GREY, markersize=2)
    x, mean, sd, _ = zip(*parameter["groups"][r])
    axes.errorbar(x, mean, sd, color=BLUE, marker="o", markersize=2.6, linewidth=1.1, elinewidth=0.9, capsize=1.5,
                  linestyle="-" if parameter["numeric"] else "none")
    explained = parameter["explained"][r]
    axes.text(0.97, 0.92, "< 1 %" if explained < 0.005 else f"{100 * explained:.0f} %", transform=axes.transAxes, ha="right",
              va="center", color=GREY)
    axes.set_xlim(low - air, high + air)
    least, most = result["range"]
    axes.set_ylim(least - 0.05 * (most - least), most + 0.26 * (most - least))  # the fraction stands above the dots
    few_tics(axes.yaxis, 5)


def name_levels(axes, parameter, wide):
    """Title and tics of a parameter below its panels, which are so many mm wide."""
    levels = parameter["levels"]
    named = 0 < len(levels) <= MOST_NAMED_LEVELS
    axes.set_xlabel(on_lines(parameter["title"] + ("" if parameter["numeric"] or named else ", by number"), wide))
    if not named:
        if parameter["numeric"]:
            few_tics(axes.xaxis, 3 if wide < 30 else 5)
        return
    places = {group[0]: cut(levels[group[3]]) for groups in parameter["groups"] for group in groups}
    slanted = CHARACTER * max(map(len, levels)) * len(levels) > 0.85 * wide  # names side by side would overlap
    (low, high), end = axes.get_xlim(), float("-inf")
    for x in sorted(places):  # levels of a number may be near to each other: a name that would overlap the one before goes
        middle, half = (x - low) / (high - low) * wide, 0 if slanted else 0.5 * CHARACTER * len(places[x])
        places[x], end = (places[x], middle + half + 0.5) if middle - half > end else ("", end)
    axes.set_xticks(list(places), places.values(), rotation=40 if slanted else 0, ha="right" if slanted else "center",
                    rotation_mode="anchor" if slanted else None)


def cut(name):
    return name if len(name) <= MOST_IN_NAME else name[:MOST_IN_NAME - 1] + "…"


def on_lines(title, wide):
    """On two lines, cut at the space nearest to the middle, where it is longer than so many mm."""
    spaces = [at for at, letter in enumerate(title) if letter == " "]
    if not spaces or CHARACTER * len(title) < wide:
        return title
    best = min(spaces, key=lambda at: abs(at - len(title) / 2))
    return f"{title[:best]}\n{title[best + 1:]}"
