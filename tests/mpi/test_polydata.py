#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: `query -o OUT.vtp` holds the rays that -o OUT.json lists, as the polylines of a VTK
XML file, byte for byte the same for any number of ranks. The file is read by its documented form."""
import base64
import json
import math
import os
import shutil
import struct
import subprocess
import sys
from xml.etree import ElementTree

PROGRAM = os.environ["RAYMAP"]
SCENE = os.path.join(os.environ["SOURCE_DIR"], "examples", "double-gauss", "scene.yaml")
FORMS = {"UInt8": "B", "Int32": "i", "UInt32": "I", "Int64": "q", "UInt64": "Q", "Float32": "f",
         "Float64": "d"}
CRITERION = "hit('lens.*', reflect_specular) >= 2"


def run(*arguments, ranks=1):
    start = ["mpirun", "-np", str(ranks)] if ranks > 1 else []
    done = subprocess.run([*start, PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                          timeout=240, check=False)
    assert done.returncode == 0, (arguments, done.returncode, done.stdout, done.stderr)
    return done.stdout


def numbers(array):
    raw = base64.b64decode(array.text, validate=True)
    nbytes = struct.unpack("<Q", raw[:8])[0]
    assert len(raw) == 8 + nbytes, array.attrib
    form, width = FORMS[array.get("type")], int(array.get("NumberOfComponents"))
    values = struct.unpack(f"<{nbytes // struct.calcsize(form)}{form}", raw[8:])
    if width == 1 or array.get("Name") == "position":
        return values
    return tuple(values[k:k + width] for k in range(0, len(values), width))


def text(array):
    strings = bytes(map(int, array.text.split())).decode().split("\0")
    assert strings.pop() == "" and len(strings) == int(array.get("NumberOfTuples"))
    return strings


def read(path):
    """Rays in order: what the cells say, and their points."""
    root = ElementTree.parse(path).getroot()
    assert root.attrib == {"type": "PolyData", "version": "1.0", "byte_order": "LittleEndian",
                           "header_type": "UInt64"}
    data = root.find("PolyData")
    names = {array.get("Name"): text(array) for array in data.iterfind("FieldData/Array")}
    rays, n_piece = [], 0
    for piece in data.iterfind("Piece"):
        part = {child.tag: {array.get("Name"): numbers(array) for array in child}
                for child in piece}
        n_point, n_line = int(piece.get("NumberOfPoints")), int(piece.get("NumberOfLines"))
        position = part["Points"]["position"]
        assert len(position) == 3 * n_point
        assert all(len(values) == n_point for values in part["PointData"].values())
        assert all(len(values) == n_line for values in part["CellData"].values())
        assert part["Lines"]["connectivity"] == tuple(range(n_point))
        begin = 0
        for row, end in enumerate(part["Lines"]["offsets"]):
            points = [{"position": position[3 * k:3 * k + 3],
                       **{name: values[k] for name, values in part["PointData"].items()}}
                      for k in range(begin, end)]
            rays.append({"points": points,
                         **{name: values[row] for name, values in part["CellData"].items()}})
            begin = end
        assert begin == n_point
        n_piece += 1
    return names, rays, n_piece


def near(a, b):
    return math.isclose(a, b, rel_tol=1e-6, abs_tol=1e-6)


def compare(names, ray, told):
    assert ray["ray"] == told["ray"]
    assert names["sources"][ray["source"]] == told["source"]
    assert names["stops"][ray["stop"]] == told["stop"]
    assert near(ray["flux"], told["flux"]["value"] if isinstance(told["flux"], dict) else told["flux"])
    assert len(ray["points"]) >= len(told["steps"]) + 1
    start, *steps = [point for point in ray["points"]]
    assert start["event"] == 0
    steps = [point for point in steps if point["event"] != 0]
    assert len(steps) == len(told["steps"]), (ray, told)
    for point, step in zip(steps, told["steps"]):
        assert all(map(near, point["position"], step["position"])), (point, step)
        events = [word for bit, word in enumerate(names["event_bits"])
                  if point["event"] >> bit & 1]
        assert events == step["events"], (events, step)
        met = names["objects"][point["object"]] if point["object"] >= 0 else None
        assert met == step.get("object"), (met, step)
        assert names["media"][point["medium"]] == step["medium"], (point, step)


shutil.rmtree("a.raymap", ignore_errors=True)
run("trace", SCENE, "-o", "a.raymap", "-n", "30000", "--quiet")
run("query", "a.raymap", CRITERION, "-o", "a.vtp", "--force", "--quiet")
run("query", "a.raymap", CRITERION, "-o", "a.json", "--force", "--quiet")
names, rays, n_piece = read("a.vtp")
with open("a.json", encoding="utf8") as file:
    told = json.load(file)
assert len(rays) == len(told) > 100, (len(rays), len(told))
for ray, its in zip(rays, told):
    compare(names, ray, its)

run("query", "a.raymap", "all", "-o", "all.vtp", "--force", "--quiet")
_, rays, n_piece = read("all.vtp")
assert n_piece > 1 and [ray["ray"] for ray in rays] == list(range(30000)), n_piece
run("query", "a.raymap", "not all", "-o", "none.vtp", "--force", "--quiet")
assert read("none.vtp")[1:] == ([], 0)
if not shutil.which("mpirun"):
    print("no mpirun here: one rank was looked at")
    sys.exit(0)
run("query", "a.raymap", "all", "-o", "two.vtp", "--force", "--quiet", ranks=2)
with open("all.vtp", "rb") as one, open("two.vtp", "rb") as two:
    assert one.read() == two.read()
