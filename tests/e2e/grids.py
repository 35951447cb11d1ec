# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Reads the grids of reamed.vdb with OpenVDB's own Python module: a second program that opens what reamsim writes."""

try:
    import pyopenvdb as vdb
except ImportError:  # its name since OpenVDB 11
    import openvdb as vdb

UNITS = {"density": "g/cm^3", "fill": "1", "surface": "mm", "removed_frame": "frame index"}


def read(path):
    return {name: vdb.read(path, name) for name in UNITS}


def same(a, b):
    """Whether two grids hold the same active voxels, values and background."""
    if a.background != b.background or a.activeVoxelCount() != b.activeVoxelCount():
        return False
    other = b.getConstAccessor()
    return all(other.probeValue(v.min) == (v.value, True) for v in a.iterOnValues())


def total(grid, only=None):
    """Sum over active voxels, tiles counted whole; where `only` is active and positive, when given."""
    accessor = only.getConstAccessor() if only is not None else None
    result = 0.0
    for v in grid.iterOnValues():
        if accessor is None or accessor.getValue(v.min) > 0:
            result += v.value * v.count
    return result
