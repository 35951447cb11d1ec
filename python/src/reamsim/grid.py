# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Values on a regular lattice: reamed.vdb, reamed.vti and depth_map.csv."""

from __future__ import annotations

import contextlib
import dataclasses
import importlib
import itertools
import pathlib
import re
import zlib

import numpy
from numpy.typing import ArrayLike

from .errors import MissingPackage, ResultsError
from .tables import number_array

_TRAILER_KEY, _TRAILER = b"_reamsim_trailer", b"REAMSIM-CRC32 %08x\n"  # ends reamed.vdb: a sum of the bytes before it
_MOST_VOXELS = 2**33  # of a lattice; more is taken for a damaged file


@dataclasses.dataclass(frozen=True)
class Grid:
    """Values at the centres of square cells or cubic voxels.

    Attributes:
        values: array; ``values[i, j, k]`` belongs to x, y, z (``values[i, j]`` to x, y of a depth map).
        origin_mm: position of the centre of the first voxel, ``values[0, 0, 0]``.
        voxel_mm: edge of a voxel.
        frame: the frame of `origin_mm`: ``bone``, or ``depth map`` (x, y of depth_map.csv: the glenoid frame, or the
            frame of the tool at its deepest where the bone has none).
        unit: unit of the values; empty for a fraction or a number.
    """

    values: numpy.ndarray
    origin_mm: numpy.ndarray
    voxel_mm: float
    frame: str = "bone"
    unit: str = ""

    def world_from_index(self, index: ArrayLike) -> numpy.ndarray:
        """Position (mm) of index coordinates, which may be fractions. Shape (..., dimensions)."""
        return self.origin_mm + self.voxel_mm * numpy.asarray(index, dtype=float)

    def index_from_world(self, position_mm: ArrayLike) -> numpy.ndarray:
        """Index coordinates, with fractions, of positions in mm. Round them to find the voxel."""
        return (numpy.asarray(position_mm, dtype=float) - self.origin_mm) / self.voxel_mm

    def at(self, position_mm: ArrayLike) -> numpy.ndarray:
        """Values of the voxels that contain the positions (mm); NaN outside of the lattice."""
        index = numpy.floor(self.index_from_world(position_mm) + 0.5).astype(int)
        inside = numpy.all((index >= 0) & (index < self.values.shape), axis=-1)
        found = self.values[tuple(numpy.where(inside[..., None], index, 0).T)].T.astype(float)
        return numpy.where(inside, found, numpy.nan)

    def interpolated(self, position_mm: ArrayLike) -> numpy.ndarray:
        """Values between the centres of voxels, linear along each axis; NaN outside of the outermost centres."""
        index = self.index_from_world(position_mm)
        first = numpy.floor(index).astype(int)
        # On the last centre the cell before it serves.
        last = numpy.array(self.values.shape) - 1
        first = numpy.where(index == last, last - 1, first)
        inside = numpy.all((first >= 0) & (first < last), axis=-1)
        part = index - first
        out = numpy.zeros(index.shape[:-1])
        for corner in itertools.product((0, 1), repeat=self.values.ndim):
            weight = numpy.prod(numpy.where(corner, part, 1 - part), axis=-1)
            cell = numpy.where(inside[..., None], first + corner, 0)
            out += weight * self.values[tuple(numpy.moveaxis(cell, -1, 0))]
        return numpy.where(inside, out, numpy.nan)

    def centers_mm(self, axis: int) -> numpy.ndarray:
        """Positions (mm) of the voxel centres along one axis (0 is x)."""
        return self.origin_mm[axis] + self.voxel_mm * numpy.arange(self.values.shape[axis])

    @property
    def extent_mm(self) -> tuple[float, ...]:
        """Lower and upper edge of the lattice along x, then y ..., as matplotlib's ``extent`` wants them."""
        edges = [(self.centers_mm(axis)[[0, -1]] + [-self.voxel_mm / 2, self.voxel_mm / 2]).tolist()
                 for axis in range(self.values.ndim)]
        return tuple(edge for pair in edges for edge in pair)


@dataclasses.dataclass(frozen=True)
class DepthMap(Grid):
    """Depth of the removed bone by column (mm; 0 where nothing was removed, NaN without bone).

    Attributes:
        before_z_mm, after_z_mm: height of the bone before and after reaming, on the same lattice; NaN without bone.
    """

    before_z_mm: numpy.ndarray = dataclasses.field(default_factory=lambda: numpy.empty((0, 0)))
    after_z_mm: numpy.ndarray = dataclasses.field(default_factory=lambda: numpy.empty((0, 0)))


def read_vdb(path: pathlib.Path, name: str, unit: str) -> Grid:
    """The grid `name` of reamed.vdb on the whole lattice; 4 bytes a voxel. Raises MissingPackage where OpenVDB's
    Python module is not installed; ResultsError where the file is missing, damaged or has no such grid."""
    openvdb = _openvdb(f"the grid {name} of {path.name}")
    if not path.is_file():
        raise ResultsError(f"{path}: no such file; the run did not write or keep it")
    if not _is_complete(path):
        raise ResultsError(f"{path}: damaged: its checksum does not fit; expected a complete file")
    try:
        grid = openvdb.read(str(path), name)
        dims = tuple(int(n) for n in grid.metadata["lattice_dims"])
    except (OSError, RuntimeError, KeyError) as error:
        raise ResultsError(f"{path}: damaged, or has no grid {name}: {error}") from error
    values = numpy.empty(_checked(dims, path), dtype=numpy.float32)
    grid.copyToArray(values)
    return Grid(values, numpy.array(grid.transform.indexToWorld((0, 0, 0))), float(grid.transform.voxelSize()[0]),
                unit=unit)


def _openvdb(purpose: str):
    """OpenVDB's Python module, which was called pyopenvdb before OpenVDB 11. Raises MissingPackage."""
    for name in ("openvdb", "pyopenvdb"):
        with contextlib.suppress(ImportError):
            return importlib.import_module(name)
    raise MissingPackage("pyopenvdb", purpose, "python3-openvdb")


def _is_complete(path: pathlib.Path) -> bool:
    """Whether the checksum fits. OpenVDB would read a file that is cut off, or crash."""
    with path.open("rb") as file:
        left = path.stat().st_size - len(_TRAILER % 0)
        if _TRAILER_KEY not in file.read(4096):
            return left > 0  # of an older version, without a checksum
        file.seek(0)
        checksum = 0
        while left > 0 and (block := file.read(min(left, 1 << 20))):
            checksum = zlib.crc32(block, checksum)
            left -= len(block)
        return file.read() == _TRAILER % checksum


def read_vti(path: pathlib.Path) -> Grid:
    """reamed.vti: density × fill, g/cm³. Needs no other package. Raises ResultsError where the file is damaged."""
    data = path.read_bytes()
    begin = data.find(b'<AppendedData encoding="raw">\n_')
    head = data[:max(begin, 0)].decode("ascii", errors="replace")
    extent, origin, step = (re.search(rf'{name}="([^"]+)"', head) for name in ("WholeExtent", "Origin", "Spacing"))
    try:
        if extent is None or origin is None or step is None or 'Name="density_g_cm3"' not in head:
            raise ValueError("not the header of a file of reamsim")
        dims = tuple(int(n) + 1 for n in extent[1].split()[1::2])
        values = _inflated(data, data.index(b"_", begin) + 1, _checked(dims, path))
        return Grid(values, numpy.array([float(x) for x in origin[1].split()]), float(step[1].split()[0]), unit="g/cm³")
    except (ValueError, zlib.error) as error:
        raise ResultsError(f"{path}: damaged: {error}") from error


def _checked(dims: tuple[int, ...], path: pathlib.Path) -> tuple[int, ...]:
    if len(dims) != 3 or min(dims) < 1 or numpy.prod(dims, dtype=float) > _MOST_VOXELS:
        raise ResultsError(f"{path}: damaged: the lattice is {dims}")
    return dims


def _inflated(data: bytes, at: int, dims: tuple[int, ...]) -> numpy.ndarray:
    """The blocks of a compressed array: their number, the size of one and of the last (0: whole), each compressed size."""
    blocks, whole, last = (int(n) for n in numpy.frombuffer(data, "<u8", 3, at))
    voxels = int(numpy.prod(dims))
    if whole % 4 != 0 or not 0 < whole * blocks < 4 * voxels + whole + 1:
        raise ValueError("its table of blocks does not fit its lattice")
    sizes = numpy.frombuffer(data, "<u8", blocks, at + 24)
    at += 24 + 8 * blocks
    out = numpy.empty(voxels, dtype="<f4")
    for block, size in enumerate(int(n) for n in sizes):
        wanted = last if last and block == blocks - 1 else whole
        raw = zlib.decompressobj().decompress(data[at:at + size], wanted + 1)
        if len(raw) != wanted:
            raise ValueError(f"block {block} has {len(raw)} bytes; expected {wanted}")
        out[block * whole // 4:][:wanted // 4] = numpy.frombuffer(raw, "<f4")
        at += size
    if data[at:].strip() != b"</AppendedData>\n</VTKFile>":
        raise ValueError("cut off")
    # x runs fastest in the file
    return out.reshape(dims, order="F")


def read_depth_map(path: pathlib.Path) -> DepthMap:
    """depth_map.csv on its lattice. Raises ResultsError where the file is missing or damaged, or its columns do not
    lie on a lattice."""
    table = number_array(path)
    try:
        x, y = table["x_mm"], table["y_mm"]
        steps = numpy.concatenate([numpy.diff(numpy.unique(x)), numpy.diff(numpy.unique(y))])
        step = float(steps[steps > 1e-6].min())
        i, j = ((axis - axis.min()) / step for axis in (x, y))
        if max(abs(i - i.round()).max(), abs(j - j.round()).max()) > 1e-3:
            raise ValueError("columns do not lie on a regular grid")
        shape = (int(i.max().round()) + 1, int(j.max().round()) + 1)
        layers = [numpy.full(shape, numpy.nan) for _ in range(3)]
        for layer, name in zip(layers, ("depth_mm", "before_z_mm", "after_z_mm")):
            layer[i.round().astype(int), j.round().astype(int)] = table[name]
    except (ValueError, IndexError) as error:
        raise ResultsError(f"{path}: damaged: {error}") from error
    return DepthMap(layers[0], numpy.array([x.min(), y.min()]), step, frame="depth map", unit="mm", before_z_mm=layers[1],
                    after_z_mm=layers[2])
