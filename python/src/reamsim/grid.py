# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Values on a regular lattice."""

from __future__ import annotations

import dataclasses
import itertools

import numpy
from numpy.typing import ArrayLike


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
