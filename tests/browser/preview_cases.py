# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""A scan whose bodies are known, its scenario, and changes of YAML texts: the cases of preview_page.py."""

import numpy

SPACING = numpy.array([0.8, 0.7, 1.1])  # mm, of the scan along x, y, z of LPS
BONE, RADIUS = numpy.array([31.0, -12.0, 205.0]), 20.0  # a ball of bone
MARKS = [numpy.array(p) for p in ((6.0, 10.0, 180.0), (52.0, -33.0, 224.0), (12.0, -30.0, 190.0))]  # denser balls of 2.2 mm
MARK_RADIUS = 2.2

SCENARIO = """\
# A ball of bone; the page finds the rest.
version: 2

bone:
  source: ct
  voxel_mm: 0.8
  ct:
    path: ball.nrrd
    threshold_hu: 300      # half way between air and bone
    seed_mm: [31, -12, 205]
    cut_spheres:
      # far from the ball
      - center_mm: [60, 20, 225]
        radius_mm: 3       # of a small ball

tool: {mesh: %s}

motion:
  frame: glenoid
  frame_rate_hz: 100
  plunge: {entry_mm: [0, 0, 0], axis: [0, 0, -1], approach_mm: 2, feed_mm_s: 2, depth_mm: 3, retract_mm: 3, spin_rpm: 250}

render:
  enabled: false
"""


def write_scan(path):
    """A scan whose axes run against LPS: x and z fall with the indices."""
    low, dims = numpy.array([0.0, -42.0, 172.0]), numpy.array([80, 84, 58])
    axes = [low[i] + SPACING[i] * numpy.arange(dims[i]) for i in range(3)]
    x, y, z = numpy.meshgrid(*axes, indexing="ij")

    def ball(center, radius):
        away = numpy.sqrt((x - center[0]) ** 2 + (y - center[1]) ** 2 + (z - center[2]) ** 2)
        return numpy.clip(0.5 - (away - radius) / 1.4, 0, 1)

    hu = 600 * ball(BONE, RADIUS)
    for mark in MARKS:
        hu = numpy.maximum(hu, 2000 * ball(mark, MARK_RADIUS))
    stored = numpy.ascontiguousarray(hu[::-1, :, ::-1].transpose(2, 1, 0)).astype("<i2")  # x fastest
    origin = [axes[0][-1], axes[1][0], axes[2][-1]]
    header = (f"NRRD0004\ntype: short\ndimension: 3\nspace: left-posterior-superior\nsizes: {dims[0]} {dims[1]} {dims[2]}\n"
              f"space directions: (-{SPACING[0]},0,0) (0,{SPACING[1]},0) (0,0,-{SPACING[2]})\nkinds: domain domain domain\n"
              f"endian: little\nencoding: raw\nspace origin: ({origin[0]},{origin[1]},{origin[2]})\n\n")
    path.write_bytes(header.encode() + stored.tobytes())


EDITS = [
    # text, changes, the text afterwards
    ("a:\n  b: 1  # one\n  c: 2\n", [[["a", "b"], "3"]], "a:\n  b: 3  # one\n  c: 2\n"),
    ("a: {b: 1, c: [1, 2]}  # both\nd: 1\n", [[["a", "c"], "[3, 4]"]], "a: {b: 1, c: [3, 4]}  # both\nd: 1\n"),
    ("a: {}\n", [[["a", "b"], "1"]], "a: {b: 1}\n"),
    ("a: {b: 1}\n", [[["a", "c", "d"], ["[1, 2]"]]], "a: {b: 1, c: {d: [[1, 2]]}}\n"),
    ("a: {b: 1, c: 2}\n", [[["a", "b"], None]], "a: {c: 2}\n"),
    ("a: {b: 1, c: 2}\n", [[["a", "c"], None]], "a: {b: 1}\n"),
    ("a:\n  g: {\n    x: 1,  # one\n    y: 2\n  }\nb: 1\n", [[["a", "g", "x"], "5"]], "a:\n  g: {\n    x: 5,  # one\n    y: 2\n  }\nb: 1\n"),
    ("a:\n  b: 1\n\n# of d\nd: 1\n", [[["a", "c", "e"], "5"]], "a:\n  b: 1\n  c:\n    e: 5\n\n# of d\nd: 1\n"),
    ("a:\n  l:\n  - [1, 2]\n  - [3, 4]\n  m: 1\n", [[["a", "l"], ["[5, 6]"]]], "a:\n  l:\n    - [5, 6]\n  m: 1\n"),
    ("a:\n  l:\n    - {b: 1}\n    -  b: 1   # x\n       c: 2\n", [[["a", "l", 1, "b"], "9"]], "a:\n  l:\n    - {b: 1}\n    -  b: 9   # x\n       c: 2\n"),
    ("a:\r\n  b: 1\r\n", [[["a", "b"], "2"]], "a:\r\n  b: 2\r\n"),
    ('"a":\n    "b": "x # y"  # z\n', [[["a", "b"], "2"]], '"a":\n    "b": 2  # z\n'),
    ("a:\n  b: [1,\n      2]\n  c: 1\n", [[["a", "b"], "[3]"]], "a:\n  b: [3]\n  c: 1\n"),
    ("a:\n  b: 1\n  # of c\n  c: 2\n", [[["a", "b"], None]], "a:\n  # of c\n  c: 2\n"),
    ("a:\n  note: |\n    b: 7\n  b: 1\n", [[["a", "b"], "2"]], "a:\n  note: |\n    b: 7\n  b: 2\n"),
    ("v: 2\n", [[["a", "b"], "1"]], "v: 2\na:\n  b: 1\n"),
    ("a:\nv: 2\n", [[["a", "b"], "1"]], "a:\n  b: 1\nv: 2\n"),
    ("v: 2", [[["a"], "1"]], "v: 2\na: 1"),
    ("a: null  # none\nb: 1\n", [[["a", "b"], "1"]], "a:  # none\n  b: 1\nb: 1\n"),
    ("a:\n  # of l\n  l:  # list\n    - b: 1\n      c: 2  # last\n# of d\nd: 1\n", [[["a", "l"], [{"b": "3", "c": "4"}]]],
     "a:\n  # of l\n  l:  # list\n    - b: 3\n      c: 4\n# of d\nd: 1\n"),
    ("a:\n  n: |\n    text\n\nd: 1\n", [[["a", "b"], "1"]], "a:\n  n: |\n    text\n  b: 1\n\nd: 1\n"),
    ("a:\n  l:\n    - [1, 2]\n  m: 1\n", [[["a", "l"], None]], "a:\n  m: 1\n"),
    ("a:\n  b:    # nothing yet\n  c: 1\n", [[["a", "b"], {"x": "1"}]], "a:\n  b:    # nothing yet\n    x: 1\n  c: 1\n"),
    ("a:\n  b:\n  # of c\n  c: 1\n", [[["a", "b"], "1"]], "a:\n  b: 1\n  # of c\n  c: 1\n"),
    ("a:\r\n  b: 1  # x\r\nd: 1\r\n", [[["a", "c"], "2"]], "a:\r\n  b: 1  # x\r\n  c: 2\r\nd: 1\r\n"),
    ("---\n# c\na: 1\n...\n", [[["b"], "2"]], "---\n# c\na: 1\nb: 2\n...\n"),
]
