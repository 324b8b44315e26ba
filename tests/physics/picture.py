# SPDX-License-Identifier: MIT
"""Renders scenes, and reads OpenEXR files as `raymap render` writes them (scan lines, 32-bit floats
R, G, B, zip), by the file layout of openexr.com/en/latest/OpenEXRFileLayout.html alone."""
import json
import struct
import zlib

import numpy

from raymap import run, write_scene

LUMINANCE = numpy.array([0.2126390058715104, 0.7151686787677559, 0.0721923153607337])


def attributes(data):
    """Header attributes {name: bytes} and where the header ends."""
    magic, version = struct.unpack_from("<II", data)
    assert magic == 20000630 and version & 0xFF == 2, "not an OpenEXR file"
    found, at = {}, 8
    while data[at]:
        name, at = text(data, at)
        _, at = text(data, at)
        size, = struct.unpack_from("<I", data, at)
        found[name] = data[at + 4:at + 4 + size]
        at += 4 + size
    return found, at + 1


def text(data, at):
    end = data.index(b"\0", at)
    return data[at:end].decode(), end + 1


def unzip(packed, size):
    """Undoes the deflate, the differences and the splitting into halves of EXR's ZIP."""
    if len(packed) == size:
        return packed
    bytes_ = numpy.frombuffer(zlib.decompress(packed), dtype=numpy.uint8).astype(numpy.int64)
    bytes_[1:] -= 128
    bytes_ = (numpy.cumsum(bytes_) & 0xFF).astype(numpy.uint8)
    whole = numpy.empty(size, dtype=numpy.uint8)
    half = (size + 1) // 2
    whole[0::2], whole[1::2] = bytes_[:half], bytes_[half:]
    return whole.tobytes()


def read_exr(path):
    """[height][width][3] floats."""
    with open(path, "rb") as file:
        data = file.read()
    head, at = attributes(data)
    x0, y0, x1, y1 = struct.unpack("<4i", head["dataWindow"])
    width, height = x1 - x0 + 1, y1 - y0 + 1
    rows = {0: 1, 2: 1, 3: 16}[head["compression"][0]]
    image = numpy.empty((height, width, 3))
    for k in range((height + rows - 1) // rows):
        offset, = struct.unpack_from("<Q", data, at + 8 * k)
        y, size = struct.unpack_from("<iI", data, offset)
        n = min(rows, height - (y - y0))
        plain = unzip(data[offset + 8:offset + 8 + size], n * width * 12)
        block = numpy.frombuffer(plain, dtype="<f4").reshape(n, 3, width)
        for i in range(n):  # channels stand in alphabetical order
            image[y - y0 + i] = block[i][::-1].T
    return image


def render(name, scene, *options):
    """The picture and the JSON report of a scene given as text."""
    target = name + ".exr"
    answer = json.loads(run("render", write_scene(name, scene), "-o", target, "--force", "--json",
                            "--quiet", *options))
    return read_exr(target), answer


def luminance(image):
    return image @ LUMINANCE
