# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Small meshes and scans for key_ranges.py."""

import math
import struct

CORNERS = [(x, y, z) for z in (0, 1) for y in (0, 1) for x in (0, 1)]
TRIANGLES = ["021", "123", "456", "576", "014", "154", "263", "367", "042", "246", "135", "375"]


def cube(side, middle=(0, 0, 0)):
    """OBJ text of a cube; text keeps the digits of large and small coordinates."""
    vertices = ["v " + " ".join(repr(m + side * (c - 0.5)) for c, m in zip(corner, middle)) for corner in CORNERS]
    faces = ["f " + " ".join(str(int(corner) + 1) for corner in triangle) for triangle in TRIANGLES]
    return "\n".join(vertices + faces) + "\n"


def cylinder(radius, height, sides=24):
    """OBJ text of a flat tool: a closed cylinder from z = 0 up, without the resolution of a real one."""
    ring = [(radius * math.cos(2 * math.pi * i / sides), radius * math.sin(2 * math.pi * i / sides)) for i in range(sides)]
    vertices = [(x, y, z) for z in (0, height) for x, y in ring] + [(0, 0, 0), (0, 0, height)]
    faces = []
    for i in range(sides):
        j = (i + 1) % sides
        faces += [(2 * sides, j, i), (2 * sides + 1, sides + i, sides + j), (i, j, sides + j), (i, sides + j, sides + i)]
    lines = ["v " + " ".join(repr(c) for c in vertex) for vertex in vertices]
    return "\n".join(lines + ["f " + " ".join(str(c + 1) for c in face) for face in faces]) + "\n"


def scan(middle=(0, 0, 0), bone=1000, air=-1000, side=20):
    """NRRD bytes of 16-bit voxels of 1 mm: a block of half the side in the middle."""
    inside = range(side // 4, side - side // 4)
    origin = ",".join(repr(m - (side - 1) / 2) for m in middle)
    head = (
        "NRRD0004\ntype: int16\ndimension: 3\nspace: left-posterior-superior\n"
        f"sizes: {side} {side} {side}\nspace directions: (1,0,0) (0,1,0) (0,0,1)\nkinds: domain domain domain\n"
        f"endian: little\nencoding: raw\nspace origin: ({origin})\n\n"
    )
    values = [
        bone if x in inside and y in inside and z in inside else air
        for z in range(side)
        for y in range(side)
        for x in range(side)
    ]
    return head.encode() + struct.pack(f"<{len(values)}h", *values)


POSES = "time_s,x_mm,y_mm,z_mm,qw,qx,qy,qz\n" + "".join(f"{t / 100},0,0,{0.5 - t / 20},1,0,0,0\n" for t in range(20))
