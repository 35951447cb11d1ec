# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""The look of the figures: size in mm, 8 pt type, Okabe and Ito's colours, which any colour vision tells apart."""

import matplotlib
import matplotlib.figure
import matplotlib.ticker

BLUE, RED, GREY, LIGHT_GREY = "#0072b2", "#d55e00", "#606060", "#c4c9cf"
STYLE = {"font.family": "DejaVu Sans", "font.size": 8, "axes.labelsize": 8, "xtick.labelsize": 7.5, "ytick.labelsize": 7.5,
         "axes.spines.top": False, "axes.spines.right": False, "axes.edgecolor": "#404040", "axes.linewidth": 0.6,
         "axes.grid": True, "axes.axisbelow": True, "grid.color": "#dcdcdc", "grid.linewidth": 0.5,
         "xtick.major.width": 0.5, "ytick.major.width": 0.5, "xtick.major.size": 2.5, "ytick.major.size": 2.5,
         "text.parse_math": False,  # names of keys and levels are no formulas
         "svg.fonttype": "none", "svg.hashsalt": "reamsim", "pdf.fonttype": 42}


def style():
    """A context with this look, whatever the user's own settings are."""
    return matplotlib.rc_context({**matplotlib.rcParamsDefault, **STYLE})


def few_tics(axis, most=4):
    """At most so many intervals between tics, with plain numbers."""
    axis.set_major_locator(matplotlib.ticker.MaxNLocator(most, steps=[1, 2, 5, 10]))
    axis.set_major_formatter(matplotlib.ticker.StrMethodFormatter("{x:.6g}"))


def new_figure(width_mm, height_mm):
    return matplotlib.figure.Figure(figsize=(width_mm / 25.4, height_mm / 25.4), layout="constrained")


def save(figure, folder, name):
    """FOLDER/NAME .png (300 dpi), .svg and .pdf, without the time, so that the same data give the same bytes."""
    for ending, metadata in (("png", {"Software": None}), ("svg", {"Date": None}), ("pdf", {"CreationDate": None})):
        figure.savefig(f"{folder}/{name}.{ending}", dpi=300, metadata=metadata)
