# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Bands of force and torque over time (left), and what the inputs change of their peaks (right)."""

from .figure_style import BLUE, GREY, RED, few_tics, new_figure, save, style

MOST_INPUTS = 10


def draw(data, folder):
    """Draws FOLDER/uq .png, .svg and .pdf.

    Args:
        data: ``time_s`` and, for ``axial_force`` and ``spin_torque``: ``p05``, ``p50``, ``p95`` over time, the ``mean`` of
            the peaks over all samples, and ``inputs``: name, mean peak in the lowest fifth of the input, in the highest.
    """
    with style():
        figure = new_figure(180, 110)
        rows = (("axial_force", "Axial force (N)", "Peak axial force (N)", BLUE),
                ("spin_torque", "Spin torque (N·mm)", "Peak spin torque (N·mm)", RED))
        panels = figure.subplots(2, 2, width_ratios=(4, 3))
        for row, (name, title, peak, color) in enumerate(rows):
            draw_bands(panels[row][0], data["time_s"], data[name], title, color, row == 1)
            draw_tornado(panels[row][1], data[name], peak, color)
        save(figure, folder, "uq")


def draw_bands(axes, time_s, data, title, color, last):
    axes.fill_between(time_s, data["p05"], data["p95"], color=color, alpha=0.3, linewidth=0, label="5–95 %")
    axes.plot(time_s, data["p50"], color=color, linewidth=1.2, label="median")
    axes.set_xlim(0, time_s[-1])
    axes.set_ylabel(title)
    few_tics(axes.yaxis, 6)
    few_tics(axes.xaxis, 8)
    if last:
        axes.set_xlabel("Time (s)")
    else:
        axes.legend(frameon=False, loc="upper left", fontsize=7.5)


def draw_tornado(axes, data, title, color):
    """Bars by decreasing effect; the dashed line is the mean of all samples."""
    rows = sorted(data["inputs"], key=lambda row: -abs(row[2] - row[1]))[:MOST_INPUTS]
    for place, (_, low, high) in enumerate(rows):
        axes.barh(place, high - low, 0.66, low, color=color, alpha=0.45)
    axes.axvline(data["mean"], color=GREY, linewidth=0.8, linestyle=(0, (4, 3)))
    axes.set_ylim(max(len(rows), 1) - 0.5, -0.5)
    # Lines of at most 34 characters, cut at the dots of the key.
    axes.set_yticks(range(len(rows)), [on_lines(name, 34) for name, _, _ in rows], linespacing=1.0)
    axes.tick_params(axis="y", length=0, labelsize=min(7.5, 7.5 * 5 / max(len(rows), 1)))
    axes.set_xlabel(title)
    axes.use_sticky_edges = False  # air beside the bars
    axes.margins(x=0.06)
    few_tics(axes.xaxis, 5)


def on_lines(name, most):
    lines = [""]
    for part in name.replace(".", ".\n").split("\n"):
        if len(lines[-1]) + len(part) > most and lines[-1]:
            lines.append("")
        lines[-1] += part
    return "\n".join(lines)
