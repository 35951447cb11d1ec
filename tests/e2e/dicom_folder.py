# SPDX-FileCopyrightText: the reamsim authors
# SPDX-License-Identifier: Apache-2.0

"""A DICOM folder of an NRRD scan, one file per slice: explicit VR, little endian, uncompressed."""

import gzip
import struct

LONG = {b"OB", b"OW", b"SQ", b"UN", b"UT"}
STORAGE = "1.2.840.10008.5.1.4.1.1.2"  # CT Image Storage
ROOT = "1.2.826.0.1.3680043.8.498"


def element(group, number, kind, value):
    if isinstance(value, str):
        value = value.encode()
        value += (b"\0" if kind == b"UI" else b" ") * (len(value) % 2)
    length = struct.pack("<HI", 0, len(value)) if kind in LONG else struct.pack("<H", len(value))
    return struct.pack("<HH", group, number) + kind + length + value


def short(group, number, value):
    return element(group, number, b"US", struct.pack("<H", value))


def read_nrrd(path):
    head, data = path.read_bytes().split(b"\n\n", 1)
    fields = dict(line.split(": ", 1) for line in head.decode().splitlines()[1:] if ": " in line)
    assert fields["type"] == "int16" and fields["space"] == "left-posterior-superior", fields
    return fields, gzip.decompress(data) if fields["encoding"] == "gzip" else data


def slice_of(k, pixels, size, spacing, position):
    uid = f"{ROOT}.1.{k + 1}"
    body = b"".join([
        element(0x0008, 0x0016, b"UI", STORAGE), element(0x0008, 0x0018, b"UI", uid), element(0x0008, 0x0060, b"CS", "CT"),
        element(0x0020, 0x000D, b"UI", f"{ROOT}.2"), element(0x0020, 0x000E, b"UI", f"{ROOT}.3"),
        element(0x0020, 0x0013, b"IS", str(k + 1)), element(0x0020, 0x0032, b"DS", "\\".join(f"{x:.6f}" for x in position)),
        element(0x0020, 0x0037, b"DS", "1\\0\\0\\0\\1\\0"), short(0x0028, 0x0002, 1),
        element(0x0028, 0x0004, b"CS", "MONOCHROME2"), short(0x0028, 0x0010, size[1]), short(0x0028, 0x0011, size[0]),
        element(0x0028, 0x0030, b"DS", f"{spacing[1]}\\{spacing[0]}"), short(0x0028, 0x0100, 16), short(0x0028, 0x0101, 16),
        short(0x0028, 0x0102, 15), short(0x0028, 0x0103, 1), element(0x0028, 0x1052, b"DS", "0"),
        element(0x0028, 0x1053, b"DS", "1"), element(0x7FE0, 0x0010, b"OW", pixels)])
    meta = b"".join([
        element(0x0002, 0x0001, b"OB", b"\0\1"), element(0x0002, 0x0002, b"UI", STORAGE), element(0x0002, 0x0003, b"UI", uid),
        element(0x0002, 0x0010, b"UI", "1.2.840.10008.1.2.1"), element(0x0002, 0x0012, b"UI", ROOT)])
    return b"\0" * 128 + b"DICM" + element(0x0002, 0x0000, b"UL", struct.pack("<I", len(meta))) + meta + body


def write(nrrd, folder):
    fields, data = read_nrrd(nrrd)
    size = [int(n) for n in fields["sizes"].split()]
    axes = [[float(x) for x in axis.strip("()").split(",")] for axis in fields["space directions"].split()]
    origin = [float(x) for x in fields["space origin"].strip("()").split(",")]
    spacing = [axis[i] for i, axis in enumerate(axes)]
    folder.mkdir(parents=True)
    plane = 2 * size[0] * size[1]
    for k in range(size[2]):
        position = [origin[0], origin[1], origin[2] + k * spacing[2]]
        slice_bytes = slice_of(k, data[k * plane:(k + 1) * plane], size, spacing, position)
        (folder / f"{k:04}.dcm").write_bytes(slice_bytes)
