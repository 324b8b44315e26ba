# SPDX-License-Identifier: MIT
"""The promise: a scene may have more objects than 16 bits count. Object 70,000 is met, recorded,
found by name and told alike in both encodings."""
import json
import os
import subprocess
import sys

try:
    import h5py
except ImportError:
    print("no h5py here")
    sys.exit(77)

PROGRAM = os.environ["RAYMAP"]
N_TILE, RAYS = 70000, 8192
SCENE = """raymap: 1
units: mm
spectrum: {mode: spectral, wavelengths: [587.56]}
media: {air: {index: 1}}
surfaces:
  black: {type: absorber}
  white: {type: lambert, reflectance: 0.5}
geometries:
  wall: {type: rectangle, size: [40, 40]}
  tile: {type: rectangle, size: [0.9, 0.9]}
sources:
  - {name: lamp, type: point, at: [0, 0, 0], direction: [0, 0, 1], distribution: {cone: 15}, flux: 1 W, medium: air}
objects:
"""
TILE = "  - {name: tile%d, geometry: tile, at: [%d, %d, -50], surface: black, front: air, back: air}\n"
SCREEN = "  - {name: screen, geometry: wall, at: [0, 0, 40], surface: white, front: air, back: air}\n"


def run(*arguments):
    done = subprocess.run([PROGRAM, *map(str, arguments)], stdin=subprocess.DEVNULL,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=300,
                          check=False)
    assert done.returncode == 0, (arguments, done.returncode, done.stderr)
    return done.stdout


with open("many.yaml", "w", encoding="utf-8") as file:
    file.write(SCENE)
    for i in range(N_TILE):  # behind the lamp: what the screen scatters back meets them
        file.write(TILE % (i, i % 300 - 150, i // 300 - 117))
    file.write(SCREEN)

digest = {}
for encoding in ("plain", "compact"):
    target = encoding + ".raymap"
    run("trace", "many.yaml", "-o", target, "-n", RAYS, "--quiet", "--force", "--encoding", encoding)
    run("verify", target, "--quiet")
    digest[encoding] = json.loads(run("info", target, "--json"))["digest"]
    counted = json.loads(run("query", target, "hit(screen)", "--count", "--json", "--quiet"))
    assert counted["rays"]["matched"] == RAYS, counted
assert digest["plain"] == digest["compact"], digest
with h5py.File("plain.raymap/map.h5", "r") as index:
    objects = index["segment/object"][:]
    names = index["name/object"][:]
    assert names[N_TILE] == b"screen" and len(names) == N_TILE + 1
assert (objects == N_TILE).sum() >= RAYS, objects.max()
high = objects[(objects > 65535) & (objects < N_TILE)]
assert len(high) > 0, "no tile beyond 16 bits was met"
tile = int(high[0])
for encoding in digest:
    counted = json.loads(run("query", encoding + ".raymap", f"hit(tile{tile})", "--count", "--json", "--quiet"))
    assert counted["rays"]["matched"] == (high == tile).sum(), (encoding, tile, counted)
print(f"all as expected ({len(high)} hits of tiles beyond 16 bits)")
