# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""The results folders of runs and studies."""

from __future__ import annotations

import dataclasses
import functools
import json
import os
import pathlib
import struct
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy
import yaml

from . import plots
from .errors import ResultsError
from .grid import DepthMap, Grid, read_depth_map, read_vdb, read_vti
from .scenario_text import load_yaml
from .tables import as_table, mixed_columns, number_array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

# Columns of runs.csv that are texts, whatever they look like: an id of digits alone would lose its zeros.
_TEXTS = frozenset({"id", "status", "message"})


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
        self.summary: dict[str, Any] = summary

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
        for name, read in (("reamed.glb", _read_glb), ("reamed.stl", _read_stl)):
            path = self.dir / name
            if not path.is_file():
                continue
            try:
                surface = read(path.read_bytes())
                if surface.faces.size and int(surface.faces.max()) >= len(surface.vertices):
                    raise ValueError("a triangle names a vertex that is missing")
                return surface
            except (ValueError, KeyError, IndexError, TypeError, struct.error) as error:
                raise ResultsError(f"{path}: damaged: {error}") from error
        raise ResultsError(f"{self.dir}: has neither reamed.glb nor reamed.stl; the run did not write them (output.meshes)")

    def plot_forces(self, over: str = "time") -> Figure:
        """Axial force, spin torque and removed volume over time or depth; see `reamsim.plots.plot_forces`."""
        return plots.plot_forces(self, over)

    def plot_depth_map(self) -> Figure:
        """The depth map with contour lines; see `reamsim.plots.plot_depth_map`."""
        return plots.plot_depth_map(self)


@dataclasses.dataclass(frozen=True)
class Surface:
    """A closed triangle mesh in the bone frame.

    Attributes:
        vertices: positions, mm, shape (n, 3).
        faces: indices of the three vertices of each triangle, shape (m, 3); they face outwards.
        depth_mm: reamed depth at each vertex, 0 where nothing was reamed; None where it was read from reamed.stl.
    """

    vertices: numpy.ndarray
    faces: numpy.ndarray
    depth_mm: numpy.ndarray | None = None

    @property
    def volume_mm3(self) -> float:
        """Volume that the mesh encloses, mm³."""
        a, b, c = (self.vertices[self.faces[:, corner]] for corner in range(3))
        return float(numpy.einsum("ij,ij->i", a, numpy.cross(b, c)).sum() / 6)


def _read_glb(data: bytes) -> Surface:
    if data[:4] != b"glTF" or struct.unpack_from("<I", data, 8)[0] != len(data):
        raise ValueError("not a GLB file, or cut off")
    length = struct.unpack_from("<I", data, 12)[0]
    tree = json.loads(data[20:20 + length])
    begin = 20 + length + 8
    primitive = tree["meshes"][0]["primitives"][0]
    named = primitive["attributes"]
    return Surface(_accessor(tree, data, begin, named["POSITION"]).astype(float),
                   _accessor(tree, data, begin, primitive["indices"]).reshape(-1, 3).astype(numpy.int64),
                   _accessor(tree, data, begin, named["_DEPTH_MM"]).astype(float) if "_DEPTH_MM" in named else None)


def _accessor(tree: dict[str, Any], data: bytes, begin: int, number: int) -> numpy.ndarray:
    accessor = tree["accessors"][number]
    view = tree["bufferViews"][accessor["bufferView"]]
    width = {"SCALAR": 1, "VEC3": 3}[accessor["type"]]
    values = numpy.frombuffer(data, {5125: "<u4", 5126: "<f4"}[accessor["componentType"]], accessor["count"] * width,
                              begin + view["byteOffset"] + accessor.get("byteOffset", 0))
    return values if width == 1 else values.reshape(-1, width)


def _read_stl(data: bytes) -> Surface:
    count = struct.unpack_from("<I", data, 80)[0]
    if len(data) != 84 + 50 * count:
        raise ValueError(f"{len(data)} bytes; expected {84 + 50 * count} for {count} triangles")
    triangle = numpy.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    corners = numpy.frombuffer(data, triangle, count, 84)["corners"].reshape(-1, 3)
    vertices, faces = numpy.unique(corners, axis=0, return_inverse=True)
    return Surface(vertices.astype(float), faces.reshape(-1, 3))


def load_sweep(folder: str | os.PathLike[str]) -> Sweep:
    """Opens the folder of a study that `reamsim sweep collect` has collected. Raises ResultsError where the folder
    or its runs.csv is missing or damaged."""
    return Sweep(pathlib.Path(folder))


class Sweep:
    """Results of a study.

    Attributes:
        dir: folder of the study, with ``runs.csv`` and ``runs/ID/``.
    """

    def __init__(self, folder: pathlib.Path) -> None:
        self.dir = folder
        if not folder.is_dir():
            raise ResultsError(f"{folder}: no such folder; expected the folder of a study")
        if not (folder / "runs.csv").is_file():
            raise ResultsError(f"{folder}: has no runs.csv; expected the folder of a study: call `reamsim sweep collect`")
        self._columns = mixed_columns(folder / "runs.csv", _TEXTS)
        missing = [name for name in ("run", "id", "status") if name not in self._columns]
        if missing:
            raise ResultsError(f"{folder / 'runs.csv'}: damaged, or not of a study: has no column {missing[0]}")
        try:
            self._columns["run"] = self._columns["run"].astype(numpy.int64)
        except ValueError as error:
            raise ResultsError(f"{folder / 'runs.csv'}: damaged: column run: {error}") from error

    def __repr__(self) -> str:
        return f"<reamsim.Sweep {str(self.dir)!r}, {len(self)} runs>"

    def __len__(self) -> int:
        return len(self._columns["run"])

    def __iter__(self) -> Iterator[Run]:
        """The runs that have results, in the order of the table."""
        return (Run(self._folder(name)) for name in self.ids if (self._folder(name) / "summary.json").is_file())

    @property
    def ids(self) -> list[str]:
        """Identifiers of all runs, in the order of the table."""
        return [str(name) for name in self._columns["id"]]

    @property
    def statuses(self) -> list[str]:
        """Status of all runs, in the order of the table: ``done``, ``failed``, ``interrupted`` or ``missing``."""
        return [str(status) for status in self._columns["status"]]

    @functools.cached_property
    def runs(self) -> Any:
        """runs.csv: a row per run. Columns ``run``, ``id``, ``status``, ``message`` (why a run failed; of a finished run its
        warnings), then the parameters, then every number of summary.json with its dotted name
        (``forces.peak_force_n``). A pandas DataFrame, or a numpy record array without pandas; a missing number is
        NaN."""
        return as_table(self._columns)

    def run(self, id: str) -> Run:
        """Results of one run. Raises ResultsError where there is no run of this id, or it has no results: it failed (the
        message says why), or they were not kept."""
        if id not in self.ids:
            raise ResultsError(f"{self.dir}: has no run {id}; column id of runs.csv lists them")
        row = self.ids.index(id)
        if not (self._folder(id) / "summary.json").is_file():
            message = str(self._columns["message"][row]) if "message" in self._columns else ""
            raise ResultsError(f"{self._folder(id)}: run {id} has no results; its status is "
                               f"{self._columns['status'][row]}{': ' + message if message else ''}")
        return Run(self._folder(id))

    def _folder(self, id: str) -> pathlib.Path:
        return self.dir / "runs" / id
