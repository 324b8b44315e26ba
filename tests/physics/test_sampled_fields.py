#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Indices on grids, of noise and of formulas, through scene files.

A Luneburg lens of radius 1, n = sqrt(2 - r^2), sampled on N^3 nodes of [-1.1, 1.1]^3 brings every ray
of a beam to the point opposite; how far off it ends is the grid's doing. The bounds are those of
fourth-order integration through trilinear values with interpolated central differences (computed once
with numpy, 400 steps): 9.562e-3, 2.403e-3 and 5.956e-4 for N = 17, 33, 65; half as much again is allowed."""
import math
import os
import sys

from raymap import Checks, report

try:
    import h5py
    import numpy
except ImportError:
    print("no h5py here")
    sys.exit(77)

checks = Checks()
HEIGHTS, AZIMUTH = (0.1, 0.3, 0.5, 0.7, 0.9), 0.7
SCENE = """raymap: 1
units: mm
media:
  air: {{index: 1}}
  m: {{gradient: {gradient}}}
surfaces:
  bare: {{type: fresnel, coat: ideal}}
geometries:
  ball: {{type: sphere, radius: 1}}
objects:
  - {{name: ball, geometry: ball, surface: bare, outside: air, inside: m}}
sources:
  - name: probes
    type: rays
    rays: [{rays}]
"""


def scene_of(gradient, origins, direction=(0, 0, 1)):
    rays = ", ".join(f"{{origin: {list(o)}, direction: {list(direction)}, wavelength: 587.56}}"
                     for o in origins)
    return SCENE.format(gradient=gradient, rays=rays)


def exits(name, gradient, origins):
    """Where each ray leaves the ball, in double precision."""
    text = scene_of(gradient, origins)
    return [report(name, text, k)["steps"][1]["position"] for k in range(len(origins))]


def beam():
    return [(h * math.cos(AZIMUTH), h * math.sin(AZIMUTH), -2) for h in HEIGHTS]


def write_grid(n):
    axis = numpy.linspace(-1.1, 1.1, n)
    x, y, z = numpy.meshgrid(axis, axis, axis, indexing="ij")
    name = f"luneburg-{n}.h5"
    with h5py.File(name, "w") as file:
        data = file.create_dataset("n", data=numpy.sqrt(numpy.maximum(2 - x * x - y * y - z * z, 0.01)))
        data.attrs["lower"], data.attrs["upper"] = [-1.1] * 3, [1.1] * 3
    return name


def worst(points):
    return max(math.dist(p, (0, 0, 1)) for p in points)


def check_grids():
    bound = {17: 9.562e-3, 33: 2.403e-3, 65: 5.956e-4}
    found = {"trilinear": {}, "tricubic": {}}
    for n, most in bound.items():
        file = write_grid(n)
        for kind, errors in found.items():
            gradient = (f"{{type: grid, file: {file}, interpolation: {kind}, tolerance: 1.0e-6, "
                        "max_steps: 100000}")
            errors[n] = worst(exits("grid", gradient, beam()))
        checks.true(f"N = {n}: trilinear {found['trilinear'][n]:.3e} <= 1.5 x {most:.3e}",
                    found["trilinear"][n] <= 1.5 * most)
        checks.true(f"N = {n}: tricubic {found['tricubic'][n]:.3e} is better",
                    found["tricubic"][n] < found["trilinear"][n])
        os.remove(file)
    for kind, errors in found.items():
        order = math.log(errors[17] / errors[65], 4)
        checks.true(f"{kind} converges with order {order:.2f}", order >= 1.9)


def check_formula():
    """The same lens as a formula, with differences and with its own slopes."""
    for slope, most in (("", 1e-7), (", slope: [-x/sqrt(2-r^2), -y/sqrt(2-r^2), -z/sqrt(2-r^2)]", 1e-8)):
        gradient = f"{{type: formula, formula: 'sqrt(2 - r^2)'{slope}, tolerance: 1.0e-9}}"
        error = worst(exits("formula", gradient, beam()))
        checks.true(f"a formula{' with slopes' if slope else ''} ends {error:.1e} from the focus", error < most)


def noise(amplitude, tolerance=1e-8):
    return (f"{{type: noise, mean: 1.3, amplitude: {amplitude}, length: 0.2, seed: 3, "
            f"tolerance: {tolerance}}}")


def check_noise():
    """No amplitude: a straight line. Some: light sent back along its end comes back to its start."""
    start = (0.2, 0.1, -2)
    straight, uniform = (exits("noise", g, [start])[0] for g in (noise(0), "{type: constant, index: 1.3}"))
    checks.true("noise of amplitude 0 is no noise", math.dist(straight, uniform) < 1e-12)
    text = scene_of(noise(0.01), [start])
    there = report("there", text)["steps"]
    out, last = there[1], there[2]
    checks.true("noise bends light", math.dist(out["position"], uniform) > 1e-5)
    back = [a + 0.5 * b for a, b in zip(out["position"], last["direction"])]
    text = scene_of(noise(0.01), [back], [-d for d in last["direction"]])
    home = report("back", text)["steps"][1]["position"]
    off = math.dist(home, there[0]["position"])
    checks.true(f"light sent back comes back to {off:.1e}", off < 1e-6)


check_grids()
check_formula()
check_noise()
checks.finish()
