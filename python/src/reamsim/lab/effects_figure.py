# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Main effects: a column of panels for each parameter, those that explain most first; a row for each result."""

from .figure_style import BLUE, GREY, LIGHT_GREY, few_tics, new_figure, panel, save, style

WIDE, WIDEST_PANEL = 154.0, 62.0  # mm: all panels, a panel with its gap
LEFT, GAP = 23.0, 3.5
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
    with style():
        Figure(data).draw(folder)


class Figure:
    def __init__(self, data):
        self.parameters, self.results = data["parameters"], data["results"]
        self.step = min(WIDE / len(self.parameters), WIDEST_PANEL)
        self.wide = max(LEFT + len(self.parameters) * self.step + 3, 110)
        self.top = 9 if self.wide >= 165 else 13
        self.height = 27 if len(self.results) > 6 else 31
        below = 9 + max([4] + [3 + 0.6 * CHARACTER * max(len(cut(level)) for level in parameter["levels"])
                               for parameter in self.parameters if self.is_slanted(parameter)])
        self.tall = self.top + len(self.results) * (self.height + GAP) - GAP + below
        self.figure = new_figure(self.wide, self.tall)

    def draw(self, folder):
        heading = ["Mean ± SD over all other parameters; grey: single runs", "%: fraction of the variance explained"]
        self.figure.text(LEFT / self.wide, 1 - 2 / self.tall, ("; " if self.wide >= 165 else "\n").join(heading), color=GREY,
                         va="top")
        for r, result in enumerate(self.results):
            for p, parameter in enumerate(self.parameters):
                axes = panel(self.figure, LEFT + p * self.step, self.top + r * (self.height + GAP), self.step - 2.5,
                             self.height)
                draw_panel(axes, parameter, result, r)
                self.label(axes, parameter, p, r)
            middle = 1 - (self.top + r * (self.height + GAP) + self.height / 2) / self.tall
            self.figure.text(5 / self.wide, middle, on_two_lines(result["title"]), rotation=90, ha="center", va="center")
        save(self.figure, folder, "effects")

    def label(self, axes, parameter, p, r):
        last = r == len(self.results) - 1
        if parameter["numeric"] and not is_named(parameter):
            few_tics(axes.xaxis, 3 if self.step < 35 else 5)
        elif is_named(parameter):
            slanted = self.is_slanted(parameter)
            places = {group[3]: group[0] for groups in parameter["groups"] for group in groups}
            names = [cut(parameter["levels"][level]) for level in places]
            axes.set_xticks(list(places.values()), names if slanted else self.legible(axes, list(places.values()), names),
                            rotation=40 if slanted else 0, ha="right" if slanted else "center",
                            rotation_mode="anchor" if slanted else None)
        if not last:
            axes.tick_params(axis="x", labelbottom=False)
        if p > 0:
            axes.tick_params(axis="y", labelleft=False)
        if last:
            middle = LEFT + (p + 0.5) * self.step - 1.2
            self.figure.text(middle / self.wide, 6 / self.tall, self.title(parameter), ha="center", va="center")

    def legible(self, axes, places, names):
        """Without names that would overlap the one before: levels of a number may be near to each other."""
        low, high = axes.get_xlim()
        out, end = [], float("-inf")
        for x, name in sorted(zip(places, names)):
            middle, half = (x - low) / (high - low) * (self.step - 2.5), 0.5 * CHARACTER * len(name)
            out.append(name if middle - half > end else "")
            end = middle + half + 0.5 if out[-1] else end
        return [dict(zip(sorted(places), out))[x] for x in places]

    def title(self, parameter):
        title = parameter["title"] + ("" if parameter["numeric"] or is_named(parameter) else ", by number")
        return title if CHARACTER * len(title) < self.step - 2.5 else on_two_lines(title)

    def is_slanted(self, parameter):
        """Whether names side by side would overlap."""
        longest = max(map(len, parameter["levels"]), default=0)
        return is_named(parameter) and CHARACTER * longest * len(parameter["levels"]) > 0.85 * (self.step - 2.5)


def draw_panel(axes, parameter, result, r):
    low, high = parameter["range"]
    air = 0.12 * (high - low) if parameter["numeric"] else 0.5
    spread = min(0.24 * parameter["spread"], 0.08 * (high - low + 2 * air)) if parameter["levels"] else 0
    runs = [(x, y) for x, y in zip(parameter["x"], result["y"]) if y is not None]
    aside = [(0.618034 * i) % 1 - 0.5 for i in range(len(runs))]  # runs of the same level are beside one another
    axes.plot([x + spread * at for (x, _), at in zip(runs, aside)], [y for _, y in runs], ".", color=LIGHT_GREY, markersize=2)
    groups = parameter["groups"][r]
    x, mean, sd = ([group[i] for group in groups] for i in range(3))
    axes.errorbar(x, mean, sd, color=BLUE, marker="o", markersize=2.6, linewidth=1.1, elinewidth=0.9, capsize=1.5,
                  linestyle="-" if parameter["numeric"] else "none")
    explained = parameter["explained"][r]
    axes.text(0.97, 0.92, "< 1 %" if explained < 0.005 else f"{100 * explained:.0f} %", transform=axes.transAxes, ha="right",
              va="center", color=GREY)
    axes.set_xlim(low - air, high + air)
    least, most = result["range"]
    axes.set_ylim(least - 0.05 * (most - least), most + 0.26 * (most - least))  # the fraction stands above the dots
    few_tics(axes.yaxis, 5)


def is_named(parameter):
    return 0 < len(parameter["levels"]) <= MOST_NAMED_LEVELS


def cut(name):
    return name if len(name) <= MOST_IN_NAME else name[:MOST_IN_NAME - 1] + "…"


def on_two_lines(title):
    """Cut at the space nearest to the middle."""
    spaces = [at for at, letter in enumerate(title) if letter == " "]
    if not spaces:
        return title
    best = min(spaces, key=lambda at: abs(at - len(title) / 2))
    return f"{title[:best]}\n{title[best + 1:]}"
