# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""Colours of `reamsim compare`: how far apart they are for readers with each kind of colour vision.

Differences are Euclidean in CIE 1976 L*a*b* (D65). Dichromacy is simulated by the matrices of Machado, Oliveira and
Fernandes (2009), severity 1, in linear RGB. A just noticeable difference is about 2.3."""

import itertools
import re

import numpy
import pytest
from conftest import ROOT

SOURCE = (ROOT / "render/plots/compare.cpp").read_text()
VISIONS = {
    "normal": numpy.eye(3),
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}


def lab(rgb, vision):
    rgb = numpy.asarray(rgb) / 255
    linear = numpy.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055)**2.4)
    seen = numpy.clip(numpy.asarray(VISIONS[vision]) @ linear, 0, 1)
    xyz = numpy.array([[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750],
                       [0.0193339, 0.1191920, 0.9503041]]) @ seen / [0.95047, 1, 1.08883]
    f = numpy.where(xyz > 216 / 24389, numpy.cbrt(xyz), (24389 / 27 * xyz + 16) / 116)
    return numpy.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def colors_of(name):
    text = re.search(name + r"\{([^}]+)\}", SOURCE)[1]
    return [[value >> 16, value >> 8 & 255, value & 255] for value in (int(word, 16) for word in text.split(","))]


@pytest.mark.parametrize("vision", VISIONS)
def test_curve_colours_are_apart(vision):
    colors = colors_of("kCurveColors")
    assert len(colors) == 6
    least = min(numpy.linalg.norm(lab(a, vision) - lab(b, vision)) for a, b in itertools.combinations(colors, 2))
    to_paper = min(numpy.linalg.norm(lab(a, vision) - lab([255] * 3, vision)) for a in colors)
    print(f"{vision}: least difference {least:.1f}, from white {to_paper:.1f}")
    assert least > 31 and to_paper > 30


@pytest.mark.parametrize("vision", VISIONS)
def test_the_ramp_has_an_order(vision):
    """Lightness rises along the ramp, and 21 steps of it can be told apart."""
    stops = numpy.array(colors_of("kRamp"), dtype=float)
    assert len(stops) == 10
    places = numpy.linspace(0, 9, 21)
    seen = [lab([numpy.interp(place, range(10), stops[:, c]) for c in range(3)], vision) for place in places]
    assert numpy.all(numpy.diff([color[0] for color in seen]) > 0)
    assert min(numpy.linalg.norm(a - b) for a, b in zip(seen, seen[1:])) > 2.3
