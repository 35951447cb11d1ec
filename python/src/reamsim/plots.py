# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Figures with matplotlib. Each function returns a Figure: save it with ``figure.savefig("name.png")``."""

from __future__ import annotations

import functools
import io
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy

from .errors import MissingPackage

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .results import Run

# Okabe and Ito's colours, which any colour vision tells apart; the same as in the program's plots.
_BLUE, _RED, _GREEN, _GREY = "#0072b2", "#d55e00", "#009e73", "#606060"
_STYLE = {"font.size": 9, "axes.spines.top": False, "axes.spines.right": False, "axes.grid": True,
          "grid.color": "#dcdcdc", "grid.linewidth": 0.6, "axes.axisbelow": True, "figure.dpi": 200,
          "lines.linewidth": 1.3}
_SAME_DEPTH_MM = 1e-6  # the depth of a tool at rest differs by rounding from frame to frame
_LABELS = {"axial_force_n": "Axial force (N)", "spin_torque_nmm": "Spin torque (N·mm)",
           "removed_mm3": "Removed volume (mm³)", "energy_mj": "Cutting energy (mJ)",
           "depth_mm": "Tool depth (mm)", "time_s": "Time since first contact (s)"}
_SUMS = ("removed_mm3", "energy_mj", "floor_energy_mj")  # columns that hold the amount of one frame
_AXES = {"time": "time_s", "depth": "depth_mm"}


def _matplotlib() -> Any:
    try:
        import matplotlib
        import matplotlib.figure
        import matplotlib.colors
        import matplotlib.ticker
    except ImportError:
        raise MissingPackage("matplotlib", "a plot", "python3-matplotlib") from None
    return matplotlib


def _figure(matplotlib: Any, width_in: float, height_in: float) -> Figure:
    """A figure that notebooks show, without pyplot, which would keep every figure in memory."""
    figure = matplotlib.figure.Figure(figsize=(width_in, height_in), layout="constrained")
    figure._repr_png_ = functools.partial(_png, figure)
    return figure


def _png(figure: Figure) -> bytes:
    data = io.BytesIO()
    figure.savefig(data, format="png", dpi=110)
    return data.getvalue()


def curve(run: Run, column: str, over: str = "depth") -> tuple[numpy.ndarray, numpy.ndarray]:
    """A column of forces.csv in contact: (x, y).

    Args:
        column: name of a column; of ``removed_mm3`` and the energies, the sum since the start.
        over: ``depth``: x is the tool depth since first contact (mm), up to the first frame of the greatest depth;
            ``time``: x is the time since first contact (s), up to the last frame with contact.

    Raises:
        ValueError: an unknown column or axis.
    """
    rows = run.force_array
    if over not in _AXES:
        raise ValueError(f"over={over!r}: expected 'time' or 'depth'")
    if column not in (rows.dtype.names or ()):
        raise ValueError(f"column={column!r}: forces.csv has no such column")
    y = numpy.cumsum(rows[column]) if column in _SUMS else rows[column]
    # Edges that rub exert a force without removing bone.
    touching = numpy.flatnonzero((rows["contacts"] > 0) | (rows["axial_force_n"] != 0))
    if touching.size == 0:
        return numpy.empty(0), numpy.empty(0)
    first, last = int(touching[0]), int(touching[-1])
    if over == "time":
        begin = max(first - 1, 0)  # row k holds what happens between frames k - 1 and k
        return rows["time_s"][begin:last + 2] - rows["time_s"][begin], y[begin:last + 2]
    depth = rows["depth_mm"]
    deepest = int((depth >= depth.max() - _SAME_DEPTH_MM).argmax())
    rising = numpy.arange(first, deepest + 1)
    rising = rising[depth[rising] >= numpy.maximum.accumulate(depth[rising])]
    return depth[rising], y[rising]


def plot_forces(run: Run, over: str = "time") -> Figure:
    """Axial force (N), spin torque (N·mm) and removed volume (mm³) from first contact on.

    Args:
        over: ``time`` (s since first contact) or ``depth`` (tool depth, mm).

    Raises:
        MissingPackage: matplotlib is not installed.
    """
    matplotlib = _matplotlib()
    with matplotlib.rc_context(_STYLE):
        figure = _figure(matplotlib, 6.4, 6.0)
        panels = figure.subplots(3, 1, sharex=True)
        for axes, column, color in zip(panels, ("axial_force_n", "spin_torque_nmm", "removed_mm3"),
                                       (_BLUE, _RED, _GREEN)):
            x, y = curve(run, column, over)
            axes.plot(x, y, color=color)
            axes.set_ylabel(_LABELS[column])
            axes.set_ylim(bottom=min(0.0, float(y.min(initial=0))))
        panels[-1].set_xlabel(_LABELS[_AXES[over]])
        panels[-1].set_xlim(left=0)
        panels[0].set_title(str(run.summary.get("scenario", "")), loc="left")
    return figure


def plot_depth_map(run: Run) -> Figure:
    """Depth of the removed bone by column (mm), with contour lines; grey: bone that was not reamed. Raises
    MissingPackage where matplotlib is not installed."""
    matplotlib = _matplotlib()
    depth_map = run.depth_map
    depth = depth_map.values
    reamed = numpy.ma.masked_where(~(depth > 0), depth)
    bone = numpy.ma.masked_where(~(depth == 0), numpy.zeros_like(depth))
    with matplotlib.rc_context({**_STYLE, "axes.grid": False}):
        figure = _figure(matplotlib, 5.6, 5.2)
        axes = figure.subplots()
        extent = depth_map.extent_mm
        axes.imshow(bone.T, origin="lower", extent=extent, cmap=matplotlib.colors.ListedColormap(["#d9d4c8"]))
        if reamed.count():
            image = axes.imshow(reamed.T, origin="lower", extent=extent, cmap="viridis", vmin=0)
            figure.colorbar(image, ax=axes, label="Depth of removed bone (mm)", shrink=0.9)
            levels = matplotlib.ticker.MaxNLocator(8, steps=[1, 2, 5, 10]).tick_values(0, float(reamed.max()))
            levels = levels[(levels > 0) & (levels <= reamed.max())]
            if (_inner(depth) > levels[:1]).any():
                lines = axes.contour(depth_map.centers_mm(0), depth_map.centers_mm(1), _inner(depth).T,
                                     levels=levels, colors="#202020", linewidths=0.6)
                axes.clabel(lines, fmt="%g", fontsize=7)
        axes.set_aspect("equal")
        axes.set_xlabel("x (mm)")
        axes.set_ylabel("y (mm)")
        axes.set_title(str(run.summary.get("scenario", "")), loc="left")
    return figure


def _inner(depth: numpy.ndarray, cells: int = 2) -> numpy.ndarray:
    """`depth` without its edge, where contour lines would lie on each other: NaN within some cells of one not reamed."""
    reamed = numpy.pad(depth > 0, cells)
    sides = range(2 * cells + 1)
    whole = numpy.logical_and.reduce([reamed[i:i + depth.shape[0], j:j + depth.shape[1]] for i in sides for j in sides])
    return numpy.where(whole, depth, numpy.nan)


def bands(runs: Iterable[Run], column: str = "axial_force_n", over: str = "depth",
          percentiles: Sequence[float] = (5, 50, 95), points: int = 400) -> tuple[numpy.ndarray, numpy.ndarray]:
    """Percentiles of a column over many runs: (x, y with a row per percentile).

    The curves are interpolated linearly on common `points` from first contact to the least depth or time that all
    runs reach. Each run has the same weight. Raises ValueError where there is no run with contact, and for an
    unknown column or axis."""
    curves = [one for one in (curve(run, column, over) for run in runs) if one[0].size > 1]
    if not curves:
        raise ValueError("no run with contact: bands need at least one")
    x = numpy.linspace(0, min(float(one[0][-1]) for one in curves), points)
    values = numpy.stack([numpy.interp(x, *one) for one in curves])
    return x, numpy.percentile(values, percentiles, axis=0)


def plot_bands(runs: Iterable[Run], columns: Sequence[str] = ("axial_force_n", "spin_torque_nmm"), over: str = "depth",
               percentiles: tuple[float, float, float] = (5, 50, 95)) -> Figure:
    """Bands of many runs: the median and the range between a low and a high percentile.

    Args:
        runs: for example a `Sweep`.
        columns: of forces.csv, a panel each.
        over: ``depth`` or ``time``, both since first contact.
        percentiles: low, middle and high.

    Raises:
        MissingPackage: matplotlib is not installed.
        ValueError: no run with contact.
    """
    matplotlib = _matplotlib()
    runs = list(runs)
    low, middle, high = percentiles
    with matplotlib.rc_context(_STYLE):
        figure = _figure(matplotlib, 6.4, 0.8 + 2.3 * len(columns))
        panels = figure.subplots(len(columns), 1, sharex=True, squeeze=False)[:, 0]
        for axes, column, color in zip(panels, columns, (_BLUE, _RED, _GREEN, _GREY) * len(columns)):
            x, (least, median, most) = bands(runs, column, over, percentiles)
            axes.fill_between(x, least, most, color=color, alpha=0.25, linewidth=0, label=f"{low:g} to {high:g} %")
            axes.plot(x, median, color=color, label=f"{middle:g} %")
            axes.set_ylabel(_LABELS.get(column, column))
            axes.legend(frameon=False, loc="upper left")
        panels[-1].set_xlabel(_LABELS[_AXES[over]])
        panels[-1].set_xlim(left=0)
        panels[0].set_title(f"{len(runs)} runs", loc="left")
    return figure
