#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""A camera as a detector: the luminance of a uniform Lambertian area is flux / (pi area), seen frontally, tilted, and far off the line of sight, where the
flux of a pixel falls as cos^4; edges in focus are sharp and others as wide as the opening makes them; a room looks as `render` shows it."""
import json
import os
import subprocess

import numpy

from picture import luminance, render
from raymap import Checks, many, run, trace, write_scene

checks = Checks()
HEAD = """raymap: 1
units: m
spectrum: {mode: rgb}
media: {air: {index: 1}}
"""
AREA = """sources:
  - {{name: area, type: area, shape: {{rectangle: [{w}, {w}]}}, at: [0, 0, 0], rotate: [{tilt}, 0, 0], flux: {flux} lm, spectrum: {{rgb: [1, 1, 1]}}, medium: air}}
"""
CAMERA = "  - {{name: {name}, type: camera, at: [0, 0, 3], look_at: [0, 0, 0], up: [0, 1, 0], fov: {fov}, resolution: [{n}, {n}], aperture: {r}{more}}}\n"


def see(target, name, *options):
    """The picture and its errors, upper row first, and what is told of it."""
    answer = json.loads(run("detector", target, name, "-o", name + ".npz", "--force", "--json", "--quiet", *options))
    data = numpy.load(name + ".npz")
    return data["value"][::-1], data["standard_error"][::-1], answer


def uniform(what, value, error, want):
    for v, e in zip(value.ravel(), error.ravel()):
        checks.z(what, v, want, e, limit=4.5)


def extent(low, high, shift):
    """Of tangents low to high, by brute force: the mean over the opening's disc."""
    n = 60
    r, a = numpy.sqrt((numpy.arange(n) + 0.5) / n) * shift, 2 * numpy.pi * (numpy.arange(n) + 0.5) / n
    p = numpy.array([[x * numpy.cos(y), x * numpy.sin(y)] for x in r for y in a])
    t = [low[k] + (high[k] - low[k]) * (numpy.arange(40) + 0.5) / 40 for k in range(2)]
    x, y = numpy.meshgrid(t[0], t[1])
    f = [((1 + (x - q[0]) ** 2 + (y - q[1]) ** 2) ** -2.0).mean() for q in p]
    return numpy.mean(f) * (high[0] - low[0]) * (high[1] - low[1])


RAYS = many(400_000)
FRONT = HEAD + AREA.format(w=1, tilt=0, flux=1000) + "detectors:\n" + "".join([
    CAMERA.format(name="front", fov=22.61986494804042, n=12, r=0.3, more=""),
    CAMERA.format(name="watt", fov=22.61986494804042, n=12, r=0.3, more=", focus: 3, response: V"),
    CAMERA.format(name="behind", fov=22.61986494804042, n=96, r=0.3, more=", focus: 6"),
    "  - {name: pinhole, type: camera, at: [0, 0, 3], direction: [0, 0, -1], up: [0, 1, 0], fov: 22.61986494804042, resolution: [96, 96], aperture: 0.1}\n"])
target = trace("front", FRONT, RAYS)
L = 1000 / numpy.pi
value, error, answer = see(target, "front")
checks.true("named", answer["type"] == "camera" and answer["unit"] == "cd/m2" and answer["quantity"] == "luminance" and answer["cells"] == [12, 12])
uniform("front", value[1:11, 1:11], error[1:11, 1:11], L)
inside = value[1:11, 1:11].mean()
checks.z("front in all", inside, L, L / numpy.sqrt(answer["registrations"]))
rim = numpy.concatenate([value[0], value[11], value[:, 0], value[:, 11]])
checks.true("sharp where it is in focus", (rim == 0).all())
checks.true("in lm V changes nothing", numpy.array_equal(see(target, "watt")[0], value))
flux, _, _ = see(target, "front", "--quantity", "flux")
for i, j in ((1, 1), (5, 6), (10, 3)):
    low = [(i - 6) * 0.2 / 6, (5 - j) * 0.2 / 6]
    checks.close(f"etendue of pixel {i}, {j}", flux[j, i] / value[j, i], numpy.pi * 0.09 * extent(low, [x + 0.2 / 6 for x in low], 0.1), rel=2e-4)
coarse, _, _ = see(target, "front", "--cells", "3x3")
checks.close("other pixels", coarse[1, 1], value[4:8, 4:8].mean(), rel=1e-3)

# not in focus: of the opening's disc as much sees a place beside the edge as lies on the area's side of a straight line
for name, spread in (("behind", 0.3 * (1 / 3 - 1 / 6)), ("pinhole", 0.1 / 3)):
    value, error, _ = see(target, name)
    at = (numpy.arange(96) + 0.5) / 96 * 0.4 - 0.2
    q = numpy.clip(((1 / 6 - numpy.abs(at))[:, None] + 0.4 / 96 * (numpy.arange(16) - 7.5) / 16) / spread, -1, 1)
    law = L * (0.5 + (q * numpy.sqrt(1 - q * q) + numpy.arcsin(q)) / numpy.pi).mean(axis=1)
    rows = numpy.abs(at) < 1 / 6 - spread - 0.0045
    profile, noise = value[rows].mean(axis=0), numpy.sqrt((error[rows] ** 2).sum(axis=0)) / rows.sum()
    for first in range(0, 96, 4):
        part = slice(first, first + 4)
        if law[part].mean() < 0.2 * L:
            checks.true(f"{name}: dark beyond", profile[part].mean() < 0.5 * L)
        else:
            checks.z(f"{name}: half-shadow", profile[part].mean(), law[part].mean(), numpy.sqrt((noise[part] ** 2).sum()) / 4)
    checks.true(f"{name}: sharp", (value[:, numpy.abs(at) > 1 / 6 + spread + 0.0045] == 0).all())

tilted = trace("tilted", HEAD + AREA.format(w=1, tilt=60, flux=1000) + "detectors:\n" + CAMERA.format(name="front", fov=22.61986494804042, n=12, r=0.1, more=""), RAYS)
value, error, _ = see(tilted, "front")
uniform("tilted", value[5:7, 2:10], error[5:7, 2:10], L)
checks.true("tilted: foreshortened", (value[:2] == 0).all() and (value[10:] == 0).all())

wide = trace("wide", HEAD + AREA.format(w=7, tilt=0, flux=49000) + "detectors:\n" + CAMERA.format(name="wide", fov=90, n=5, r=0.3, more=""), RAYS)
value, error, _ = see(wide, "wide")
uniform("cos^4", value, error, L)
flux, _, _ = see(wide, "wide", "--quantity", "flux")
checks.true("less light in the corners", flux[0, 0] < 0.4 * flux[2, 2])

# a room with a lamp, a ball and coloured walls: as `render` has it, on 1 and 2 ranks alike
ROOM = HEAD + """surfaces:
  white: {type: lambert, reflectance: 0.7}
  red: {type: lambert, reflectance: {rgb: [0.8, 0.2, 0.2]}}
geometries:
  wall: {type: rectangle, size: [14, 14]}
  ball: {type: sphere, radius: 0.7}
objects:
  - {name: floor, geometry: wall, surface: white, at: [0, 0, -1], front: air, back: air}
  - {name: wall, geometry: wall, surface: red, at: [0, 1.5, 0], rotate: [90, 0, 0], front: air, back: air}
  - {name: ball, geometry: ball, surface: white, at: [0.4, 0.3, -0.3], front: air, back: air}
sources:
  - {name: lamp, type: area, shape: {rectangle: [1, 1]}, at: [-0.3, -0.5, 2], direction: [0, 0, -1], flux: 1000 lm, spectrum: {rgb: [1, 1, 1]}, medium: air}
detectors:
  - {name: cam, type: camera, %s}
cameras:
  - {name: cam, type: thin_lens, medium: air, %s}
"""
VIEW = "at: [0, -3, 0.5], look_at: [0, 1, -0.3], fov: 60, resolution: [6, 4], aperture: 0.35"
room = "room.raymap"
run("trace", write_scene("room", ROOM % (VIEW, VIEW)), "-o", room, "-n", many(300_000), "--force", "--quiet")
value, error, answer = see(room, "cam", "--color", "true")
with open("late.yaml", "w", encoding="utf-8") as file:
    file.write("detectors: [{name: late, type: camera, " + VIEW + "}]\n")
checks.close("laid over the map", list(see(room, "late", "--receivers", "late.yaml")[0].ravel()), list(value.ravel()), rel=0.02, abs=0.05)
checks.close("pixels", [d["cells"] for d in json.loads(run("info", room, "--json"))["detectors"]], [[6, 4]])
colour = numpy.load("cam.npz")["rgb"][::-1]
other = subprocess.run(["mpirun", "-np", "2", os.environ["RAYMAP"], "detector", room, "cam", "--json", "--quiet"], capture_output=True, text=True, check=True)
checks.true("2 ranks", json.loads(other.stdout) == answer)
image, _ = render("seen", ROOM % (VIEW, VIEW), "--samples", many(1024))
want = luminance(image)
for v, e, w in zip(value.ravel(), error.ravel(), want.ravel()):
    checks.z("as render shows it", v, w, numpy.hypot(e, 0.01 * w), limit=4.5)
checks.z("mean of the room", value.mean(), want.mean(), want.mean() * 0.015)
checks.close("red of the wall", colour[0, :, 0].sum() / colour[0, :, 1].sum(), image[0, :, 0].sum() / image[0, :, 1].sum(), rel=0.1)

for text, arguments in (("--tally", ["--tally"]), ("none of --region", ["--region=0,0,1,1"]), ("none of --region", ["--over", "direction"]),
                        ("luminance (radiance), flux or spectral", ["--quantity", "illuminance"]), ("a spot lies on a plane", ["--spot"]),
                        ("luminance (radiance), flux or spectral", ["--quantity", "intensity"])):
    done = subprocess.run([os.environ["RAYMAP"], "detector", target, "front", *arguments], capture_output=True, text=True, check=False)
    checks.true(f"{arguments}: {done.stderr}", done.returncode == 2 and text in done.stderr)
for wrong, text in (("aperture: 0.1", "say where camera 'c' looks"), ("direction: [0, 0, 1]", "aperture"), ("direction: [0, 0, 1], aperture: 0.1, cells: 3", "cells")):
    path = write_scene("bad", HEAD + AREA.format(w=1, tilt=0, flux=1) + "detectors: [{name: c, type: camera, " + wrong + "}]\n")
    done = subprocess.run([os.environ["RAYMAP"], "check", path], capture_output=True, text=True, check=False)
    checks.true(f"{wrong}: {done.stderr}", done.returncode == 3 and text in done.stderr)
checks.finish()
