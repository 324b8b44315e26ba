#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: a compact map that is traced has the rays, sums and images of a plain one, for any ranks
and threads, whether its blocks can be encoded in parts or, like those of the foggy scene, cannot: then
their rays are traced a second time and must not be counted twice."""
import json
import os
import shutil
import subprocess
import sys

if not shutil.which("mpirun"):
    print("no mpirun here")
    sys.exit(77)

PROGRAM = os.environ["RAYMAP"]
ROOM = os.path.join(os.environ["SOURCE_DIR"], "examples", "room", "scene.yaml")
FOG = """raymap: 1
media: {air: {index: 1}, fog: {index: 1.2, absorption: 0.05}}
surfaces: {white: {type: lambert, reflectance: 0.9}, clear: {type: fresnel}}
geometries: {plate: {type: rectangle, size: [90, 90]}, ball: {type: sphere, radius: %s}}
objects:
  - {name: floor, geometry: plate, at: [0, 0, -9], surface: white, front: air, back: air}
  - {name: ball, geometry: ball, at: [5, 0, 0], surface: clear, inside: fog, outside: air}
sources:
  - {name: bulb, type: point, flux: 1 W, medium: air}
detectors:
  - {name: sensor, type: plane, at: [0, 0, 12], size: [30, 30], cells: [16, 16]}
"""
SLOW = int(os.environ.get("RAYMAP_TEST_SCALE", "1")) > 1
SAME = ("rays", "segments", "registrations", "digest", "sources", "objects", "detectors")


def run(*arguments, ranks=1):
    start = ["mpirun", "-np", str(ranks)] if ranks > 1 else []
    done = subprocess.run([*start, PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                          timeout=240, check=False)
    assert done.returncode == 0, (arguments, done.returncode, done.stdout, done.stderr)
    return done.stdout


def told(path):
    info = json.loads(run("info", path, "--json"))
    return {key: info[key] for key in SAME}, run("report", path, "--energy").replace(path, "")


def image(path, detector):
    run("detector", path, detector, "-o", "image.csv", "--force", "--quiet")
    with open("image.csv", encoding="utf-8") as file:
        return file.read()


for radius in ("4", "0.7", "0.1"):
    with open(f"ball-{radius}.yaml", "w", encoding="utf-8") as file:
        file.write(FOG % radius)
for scene, detector, n in ((ROOM, "floor_map", 3000), ("ball-4.yaml", "sensor", 20001),
                           ("ball-0.7.yaml", "sensor", 20001), ("ball-0.1.yaml", "sensor", 30001)):
    run("trace", scene, "-n", n, "-o", "plain.raymap", "--encoding", "plain", "--force", "--quiet")
    want, want_image = told("plain.raymap"), image("plain.raymap", detector)
    for ranks, threads in ((1, 1), (1, 2), (3, 1)) if SLOW else ((2, 2),):
        run("trace", scene, "-n", n, "-o", "compact.raymap", "--encoding", "compact", "--threads",
            threads, "--force", "--quiet", ranks=ranks)
        assert told("compact.raymap") == want, (scene, ranks, threads)
        assert image("compact.raymap", detector) == want_image, (scene, ranks, threads)
        run("verify", "compact.raymap", "--quiet")

# Ids end where 64 bits do.
LAST = ("ball-0.7.yaml", "--first-ray", 2**64 - 616, "-n", 600, "--force", "--quiet")
run("trace", *LAST, "-o", "plain.raymap", "--encoding", "plain")
run("trace", *LAST, "-o", "compact.raymap", "--encoding", "compact")
assert told("compact.raymap") == told("plain.raymap")
