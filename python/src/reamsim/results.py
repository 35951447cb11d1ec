# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""The results folder of a run."""

from __future__ import annotations

import functools
import json
import os
import pathlib
from typing import TYPE_CHECKING, Any

import numpy
import yaml

from .errors import ResultsError
from .grid import DepthMap, Grid, read_depth_map, read_vdb, read_vti
from .scenario_text import load_yaml
from .surface import Surface, read_surface
from .tables import as_table, number_array

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def load(folder: str | os.PathLike[str]) -> Run:
    """Opens the results folder of a run. Files are read when they are asked for. Raises ResultsError where the
    folder is missing or is no results folder of a run, or summary.json is damaged."""
    return Run(pathlib.Path(folder))


class Run:
    """Results of one run. Each attribute reads its file once; `ResultsError` says which file is missing or damaged.

    Units are those of the files (docs/columns.md): mm, s, N, N·mm, mJ, g/cm³. The name of a key or column has its unit.

    Attributes:
        dir: the results folder.
        summary: summary.json.
    """

    dir: pathlib.Path
    summary: dict[str, Any]

    def __init__(self, folder: pathlib.Path) -> None:
        self.dir = folder
        if not folder.is_dir():
            raise ResultsError(f"{folder}: no such folder; expected the results folder of a run")
        path = folder / "summary.json"
        if not path.is_file():
            raise ResultsError(f"{folder}: has no summary.json; expected the results folder of a run")
        try:
            summary = json.loads(path.read_text(encoding="utf-8"))
        except (ValueError, RecursionError) as error:
            raise ResultsError(f"{path}: damaged: {error}") from error
        if not isinstance(summary, dict) or "removed_mm3" not in summary or "forces" not in summary:
            raise ResultsError(f"{path}: damaged, or not the summary of a run; expected a file written by `reamsim run`")
        self.summary = summary

    def __repr__(self) -> str:
        return f"<reamsim.Run {str(self.dir)!r}>"

    @property
    def warnings(self) -> list[str]:
        """All warnings of the run."""
        return list(self.summary.get("warnings", []))

    @functools.cached_property
    def scenario(self) -> dict[str, Any]:
        """The resolved scenario: every default filled in."""
        path = self.dir / "scenario.yaml"
        if not path.is_file():
            raise ResultsError(f"{path}: no such file; the run did not write or keep it")
        try:
            scenario = load_yaml(path.read_text(encoding="utf-8"))
        except (yaml.YAMLError, UnicodeDecodeError) as error:
            raise ResultsError(f"{path}: damaged: {error}") from error
        if not isinstance(scenario, dict):
            raise ResultsError(f"{path}: damaged: not a scenario")
        return scenario

    @functools.cached_property
    def force_array(self) -> numpy.ndarray:
        """forces.csv as a structured array: a row per frame, fields named as the columns
        (``time_s``, ``depth_mm``, ``axial_force_n``, ``spin_torque_nmm``, ``removed_mm3`` ...). Force and torque are
        exerted by the bone on the tool, in the bone frame."""
        return number_array(self.dir / "forces.csv")

    @functools.cached_property
    def forces(self) -> Any:
        """`force_array` as a pandas DataFrame; without pandas a numpy record array. ``forces["axial_force_n"]`` works
        with both."""
        return as_table({name: self.force_array[name] for name in self.force_array.dtype.names or ()})

    @functools.cached_property
    def depth_map(self) -> DepthMap:
        """Depth of the removed bone by column, mm (depth_map.csv)."""
        return read_depth_map(self.dir / "depth_map.csv")

    @functools.cached_property
    def density(self) -> Grid:
        """Density of the bone before reaming, g/cm³; 0 without bone. Needs pyopenvdb."""
        return read_vdb(self.dir / "reamed.vdb", "density", "g/cm³")

    @functools.cached_property
    def fill(self) -> Grid:
        """Remaining fraction of each voxel: 1 whole, 0 removed or without bone. Needs pyopenvdb."""
        return read_vdb(self.dir / "reamed.vdb", "fill", "")

    @functools.cached_property
    def removed_frame(self) -> Grid:
        """Frame in which each voxel was removed; −1 never. Needs pyopenvdb."""
        return read_vdb(self.dir / "reamed.vdb", "removed_frame", "")

    @functools.cached_property
    def remaining_density(self) -> Grid:
        """Density × fill, g/cm³: from reamed.vti, which needs no other package, otherwise from reamed.vdb."""
        if (self.dir / "reamed.vti").is_file():
            return read_vti(self.dir / "reamed.vti")
        density = self.density
        return Grid(density.values * self.fill.values, density.origin_mm, density.voxel_mm, unit=density.unit)

    @functools.cached_property
    def surface(self) -> Surface:
        """Closed surface of the reamed bone in the bone frame, mm: from reamed.glb, otherwise from reamed.stl."""
        return read_surface(self.dir)

    def plot_forces(self, over: str = "time") -> Figure:
        """Axial force, spin torque and removed volume over time or depth; see `reamsim.plots.plot_forces`."""
        from .plots import plot_forces

        return plot_forces(self, over)

    def plot_depth_map(self) -> Figure:
        """The depth map with contour lines; see `reamsim.plots.plot_depth_map`."""
        from .plots import plot_depth_map

        return plot_depth_map(self)
