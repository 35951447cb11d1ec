# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""The surface of the reamed bone: reamed.glb and reamed.stl."""

from __future__ import annotations

import dataclasses
import json
import pathlib
import struct
from typing import Any

import numpy

from .errors import ResultsError


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


def read_surface(folder: pathlib.Path) -> Surface:
    """The surface from reamed.glb, or from reamed.stl where that is missing. Raises ResultsError where both are
    missing, or the file is damaged."""
    for name, read in (("reamed.glb", _read_glb), ("reamed.stl", _read_stl)):
        path = folder / name
        if not path.is_file():
            continue
        try:
            surface = read(path.read_bytes())
            if surface.faces.size and int(surface.faces.max()) >= len(surface.vertices):
                raise ValueError("a triangle names a vertex that is missing")
            return surface
        except (ValueError, KeyError, IndexError, TypeError, struct.error) as error:
            raise ResultsError(f"{path}: damaged: {error}") from error
    raise ResultsError(f"{folder}: has neither reamed.glb nor reamed.stl; the run did not write them (output.meshes)")


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
