# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Small scans, label maps and meshes for the tests of the documents: a ball of bone in air."""

import struct

import numpy

HEAD = """NRRD0004
type: {kind}
dimension: 3
{space}
sizes: {n} {n} {n}
space directions: (1,0,0) (0,1,0) (0,0,1)
kinds: domain domain domain
endian: little
encoding: raw
space origin: (0,0,0)
{more}
"""
LPS = "space: left-posterior-superior"
SIZE, RADIUS_MM = 40, 14


def ball():
    axis = numpy.arange(SIZE) - (SIZE - 1) / 2
    z, y, x = numpy.meshgrid(axis, axis, axis, indexing="ij")
    return x * x + y * y + z * z < RADIUS_MM**2


def write_scan(path, space=LPS):
    """A ball of 800 HU in air; its centre is at 19.5 mm along each axis, LPS."""
    hu = numpy.where(ball(), 800, -1000).astype("<i2")
    path.write_bytes(HEAD.format(kind="int16", space=space, n=SIZE, more="").encode() + hu.tobytes())


def write_label_map(path):
    """The same ball as 3D Slicer writes a segment."""
    more = "Segment0_ID:=Segment_1\nSegment0_LabelValue:=1\nSegment0_Layer:=0\nSegment0_Name:=scapula_left\n"
    head = HEAD.format(kind="unsigned char", space=LPS, n=SIZE, more=more)
    path.write_bytes(head.encode() + ball().astype("u1").tobytes())


def write_box(path, size_mm, open_side=False):
    """A box as binary STL; without one of its twelve triangles it is open."""
    corners = [(x * size_mm, y * size_mm, z * size_mm) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
    faces = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7), (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5)]
    faces = faces[1:] if open_side else faces
    triangles = b"".join(struct.pack("<12fH", 0, 0, 0, *corners[a], *corners[b], *corners[c], 0) for a, b, c in faces)
    path.write_bytes(b"\0" * 80 + struct.pack("<I", len(faces)) + triangles)
