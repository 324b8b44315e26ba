#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: a curved segment that ends on a mesh has the length, the optical path and the direction that it has where
analytic faces stand in the same place."""
import os
import random
import subprocess

import h5py

PROGRAM = os.environ["RAYMAP"]
PARTS, RAYS = 40, 80  # 19,200 triangles

HEAD = """raymap: 1
units: mm
spectrum: {mode: spectral, wavelengths: [587.56]}
media:
  air: {index: 1}
  rod: {gradient: {type: selfoc, n0: 1.6, A: 0.09, frame: world}}
"""
MESH = """geometries:
  box: {type: mesh, file: box.obj}
objects:
  - {name: box, geometry: box, surface: absorber, inside: rod, outside: air}
"""
FACES = """geometries:
  end: {type: rectangle, size: [2, 2]}
  wall: {type: rectangle, size: [2, 10]}
  side: {type: rectangle, size: [10, 2]}
objects:
""" + "".join(f"  - {{name: {name}, geometry: {shape}, at: {at}, rotate: {turn}, surface: absorber, front: air, back: rod}}\n"
              for name, shape, at, turn in (
                  ("back", "end", [0, 0, 10], [0, 0, 0]), ("front", "end", [0, 0, 0], [180, 0, 0]),
                  ("up", "wall", [0, 1, 5], [-90, 0, 0]), ("down", "wall", [0, -1, 5], [90, 0, 0]),
                  ("right", "side", [1, 0, 5], [0, 90, 0]), ("left", "side", [-1, 0, 5], [0, -90, 0])))


def write_box():
    number, corners, triangles = {}, [], []

    def vertex(p):
        if p not in number:
            number[p] = len(corners) + 1
            corners.append(p)
        return number[p]

    for axis, side in ((axis, side) for axis in range(3) for side in (0, 1)):
        for i in range(PARTS):
            for j in range(PARTS):
                quad = []
                for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                    share = [a / PARTS, b / PARTS]
                    share.insert(axis, side)
                    quad.append(vertex((2 * share[0] - 1, 2 * share[1] - 1, 10 * share[2])))
                if (side == 1) != (axis != 1):  # outwards
                    quad.reverse()
                triangles += [quad[:3], [quad[0], *quad[2:]]]
    with open("box.obj", "w", encoding="utf-8") as file:
        file.writelines("v {!r} {!r} {!r}\n".format(*p) for p in corners)
        file.writelines("f {} {} {}\n".format(*t) for t in triangles)


def rays():
    draw = random.Random(3)
    lines = [f"      - {{origin: {[draw.uniform(-.5, .5), draw.uniform(-.5, .5), draw.uniform(.5, 9.5)]}, "
             f"direction: {[draw.uniform(-.4, .4), draw.uniform(-.4, .4), draw.choice((1, -1))]}}}\n" for _ in range(RAYS)]
    return "sources:\n  - name: lamp\n    type: rays\n    medium: rod\n    flux: 1 W\n    rays:\n" + "".join(lines)


def trace(name, scene):
    with open(f"{name}.yaml", "w", encoding="utf-8") as file:
        file.write(scene)
    subprocess.run([PROGRAM, "trace", f"{name}.yaml", "-o", f"{name}.raymap", "-n", str(RAYS), "--encoding", "plain", "--force",
                    "--quiet"], check=True)
    with h5py.File(f"{name}.raymap/shard-00000/piece-00000.h5") as piece:
        last = piece["ray/segment_count"][:].cumsum() - 1
        return (piece["ray/path_length"][:], piece["ray/optical_path"][:], piece["segment/position"][:][last],
                piece["ray/end_direction"][:])


write_box()
on_mesh, on_faces = trace("mesh", HEAD + MESH + rays()), trace("faces", HEAD + FACES + rays())
for what, a, b, most in zip(("length", "optical path", "place", "direction"), on_mesh, on_faces, (1e-11, 1e-11, 2e-6, 2e-7)):
    off = abs(a - b).max()
    assert off <= most, (what, off)
