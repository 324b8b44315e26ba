#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""What --cache, or RAYMAP_CACHE, keeps gives the same rays; what is damaged there is told and made anew, and a
place that cannot be written fails nothing."""
import json
import os
import pathlib
import struct
import subprocess

PROGRAM = os.environ["RAYMAP"]
SIDE = 30  # 1800 triangles, 90 KB
pathlib.Path("scene.yaml").write_text("""raymap: 1
units: mm
media: {air: {index: 1}}
surfaces: {white: {type: lambert, reflectance: 0.5}}
geometries: {hill: {type: mesh, file: hill.stl}}
objects: [{name: hill, geometry: hill, surface: white, inside: air, outside: air}]
sources: [{name: lamp, type: point, at: [15, 15, 30], direction: [0, 0, -1], distribution: {cone: 25}, medium: air}]
""")


def write_hill(height):
    def at(i, j):
        return struct.pack("<3f", i, j, height * (i * j % 5))
    body = b""
    for i in range(SIDE):
        for j in range(SIDE):
            for corners in (((i, j), (i + 1, j), (i + 1, j + 1)), ((i, j), (i + 1, j + 1), (i, j + 1))):
                body += bytes(12) + b"".join(at(*c) for c in corners) + bytes(2)
    pathlib.Path("hill.stl").write_bytes(bytes(80) + struct.pack("<I", 2 * SIDE * SIDE) + body)


def trace(*more, cache=""):
    """The digest, and what was said."""
    done = subprocess.run([PROGRAM, "trace", "scene.yaml", "-n", "500", "-o", "m.raymap", "--force", "--json", *more],
                          env=dict(os.environ, RAYMAP_CACHE=cache), capture_output=True, text=True, check=False, timeout=60)
    assert done.returncode == 0, (more, done.returncode, done.stderr)
    return json.loads(done.stdout)["digest"], done.stderr


def kept(folder="kept/meshes"):
    file, = pathlib.Path(folder).iterdir()
    return file


write_hill(0.2)
low = trace()[0]
assert trace("--cache", "kept/meshes")[0] == low
made = kept().stat().st_mtime_ns
digest, said = trace(cache="kept/meshes")
assert digest == low and kept().stat().st_mtime_ns == made and "hill" not in said, said

whole = kept().read_bytes()
kept().write_bytes(whole[:-1000] + bytes(1000))
digest, said = trace("--cache", "kept/meshes")
assert digest == low and "scene.yaml:5:" in said and "its checksum does not hold" in said and str(kept()) in said, said
assert kept().read_bytes() == whole

write_hill(0.4)  # takes the place of what it was
high = trace("--cache", "kept/meshes", "--threads", "1")[0]
assert high == trace("--cache", "scene.yaml/below")[0] != low and kept().stat().st_size == len(whole)
assert "cannot" in trace("--cache", "scene.yaml/below")[1]

# The text and the boxes of a scene of many instances.
N = 1500
scene = pathlib.Path("scene.yaml")
scene.write_text(scene.read_text().replace("objects: [{name: hill, geometry: hill, surface: white, inside: air, outside: air}]", "objects:\n" + "".join(
    f"- {{name: hill{i}, geometry: hill, at: [{i % 40 - 20}, {i // 40 - 20}, {i % 7}], scale: 0.1, surface: white, outside: air}}\n" for i in range(N))))
plain = trace()[0]
assert trace("--cache", "many")[0] == plain
files = {file.suffix: file for file in pathlib.Path("many").iterdir()}
assert set(files) == {".mesh", ".scene", ".boxes"}, files
made = {suffix: file.stat().st_mtime_ns for suffix, file in files.items()}
assert trace("--cache", "many") == (plain, "")
assert made == {suffix: file.stat().st_mtime_ns for suffix, file in files.items()}
whole = {suffix: file.read_bytes() for suffix, file in files.items()}
for suffix in (".scene", ".boxes"):
    files[suffix].write_bytes(whole[suffix][:-100] + bytes(100))
digest, said = trace("--cache", "many")
assert digest == plain and said.count("its checksum does not hold") == 1 and str(files[".scene"]) in said, said
assert {suffix: file.read_bytes() for suffix, file in files.items()} == whole
write_hill(0.2)  # whose boxes are others
moved = trace("--cache", "many", "--set", "objects.hill7.at=[0, 0, 9]")[0]
assert moved == trace("--set", "objects.hill7.at=[0, 0, 9]")[0] != plain

# Geometries that change places: the same places of objects, the same vertices.
mesh, ball = "{type: mesh, file: hill.stl}", "{type: sphere, radius: 3}"
text = scene.read_text().replace("geometries: {hill: {type: mesh, file: hill.stl}}", "geometries: {hill: MESH, ball: BALL}").replace(
    "geometry: hill, at: [-20, -20", "geometry: ball, at: [-20, -20")
digests = []
for one, other in ((mesh, ball), (ball, mesh)):
    scene.write_text(text.replace("MESH", one).replace("BALL", other))
    digests += [trace("--cache", "swapped")[0], trace()[0]]
assert digests[0] == digests[1] != digests[2] == digests[3], digests
