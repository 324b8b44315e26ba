#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Gradient media that are known at points, or by their statistics alone.

Luneburg's lens on a grid of N^3 values with trilinear interpolation (the gradient trilinear between
central differences) misses the focus by 0.009562, 0.002403, 0.0005956 for N = 17, 33, 65 at most
(computed with numpy by 400 Runge-Kutta steps): order 2; tricubic interpolation must do better. Perlin's
noise: without amplitude rays are straight; light sent back comes back; the same seed bends the same
way; the mean square of the angle grows as the path, as for any short-range disorder (Chernov 1960,
Wave Propagation in a Random Medium, part I).
"""
import math

import h5py
import numpy

from raymap import Checks, columns, drop, many, report, trace

checks = Checks()
HEAD = "raymap: 1\nunits: mm\nspectrum: {mode: spectral, wavelengths: [550]}\n"


def source(at, direction, medium, shape="disc: 1.0e-13"):
    return (f"  - {{name: beam, type: collimated, shape: {{{shape}}}, at: {at}, direction: "
            f"{direction}, flux: 1 W, spectrum: {{lines: {{550: 1}}}}, medium: {medium}}}\n")


def lens_on_grid(n, interpolation, at, direction):
    return HEAD + f"""media:
  air: {{index: 1}}
  lens: {{gradient: {{type: grid, file: lens-{n}.h5, dataset: n, lower: [-1.1, -1.1, -1.1],
    upper: [1.1, 1.1, 1.1], interpolation: {interpolation}}}}}
geometries: {{ball: {{type: sphere, radius: 1}}}}
objects:
  - {{name: ball, geometry: ball, surface: fresnel, outside: air, inside: lens}}
sources:
""" + source(at, direction, "lens")


def worst_focus(n, interpolation):
    worst = 0.0
    c, s = math.cos(0.7), math.sin(0.7)
    for h in (0.1, 0.3, 0.5, 0.7, 0.9):
        # Just inside the sphere: outside of it light is in air.
        x = -math.sqrt(1 - h * h) * (1 - 1e-9)
        start = [x, h * c * (1 - 1e-9), h * s * (1 - 1e-9)]
        end = report("grid", lens_on_grid(n, interpolation, start, [1, 0, 0]))["steps"][0]
        # Across the ray: the sphere, met at an angle, lengthens what it misses by.
        miss = numpy.cross(numpy.subtract(end["position"], (1, 0, 0)), end["direction"])
        worst = max(worst, float(numpy.linalg.norm(miss)))
    return worst


error = {}
for n, want in ((17, 0.009562), (33, 0.002403), (65, 0.0005956)):
    axis = numpy.linspace(-1.1, 1.1, n)
    z, y, x = numpy.meshgrid(axis, axis, axis, indexing="ij")
    with h5py.File(f"lens-{n}.h5", "w") as file:
        file["n"] = numpy.sqrt(numpy.maximum(2 - x * x - y * y - z * z, 0.01)).transpose(2, 1, 0)
    error[n] = worst_focus(n, "trilinear")
    cubic = worst_focus(n, "tricubic")
    print(f"grid of {n}: {error[n]:.3g}, tricubic {cubic:.3g}")
    checks.true(f"grid of {n}: {error[n]}", error[n] <= 1.5 * want)
    checks.true(f"tricubic grid of {n}: {cubic}", cubic < want)
order = math.log2(error[17] / error[65]) / 2
checks.true(f"order {order}", order >= 1.9)


def noise(length, amplitude, light, behind="noise", options=""):
    """A column of noise from z = -1; `behind` the plane at z = length air, or more of it."""
    end = length if behind == "air" else length + 1
    last = "" if behind == "air" else (f"  - {{name: last, geometry: end, at: [0, 0, {end}], "
                                       "surface: absorber, front: air, back: noise}\n")
    return HEAD + f"""media:
  air: {{index: 1}}
  noise: {{gradient: {{type: noise, mean: 1.3, amplitude: {amplitude}, length: 1, seed: 7,
    frame: world{options}}}}}
geometries: {{side: {{type: cylinder, radius: 30, length: {end + 1}}}, end: {{type: disc, radius: 30}}}}
objects:
  - {{name: side, geometry: side, at: [0, 0, -1], surface: absorber, outside: air, inside: noise}}
  - {{name: first, geometry: end, at: [0, 0, -1], surface: absorber, front: noise, back: air}}
  - {{name: plane, geometry: end, at: [0, 0, {length}], surface: fresnel, front: {behind}, back: noise}}
{last}sources:
""" + light


START, AHEAD = [0.3, 0.2, 0.1], [0, 0, 1]
LIGHT = source(START, AHEAD, "noise")
straight = report("noise", noise(10, 0, LIGHT))["steps"][0]
checks.close("no amplitude", straight["position"], [0.3, 0.2, 10], abs=1e-12)
for amplitude in (1e-3, 1e-2):
    there = report("noise", noise(10, amplitude, LIGHT))["steps"][0]
    checks.true("light is bent", math.dist(there["position"], (0.3, 0.2, 10)) > 1e-6)
    finer = report("noise", noise(10, amplitude, LIGHT, options=", tolerance: 1.0e-11"))["steps"][0]
    checks.close("default tolerance", there["position"], finer["position"], abs=1e-6)
    # From the plane back to another one at the start; the noise stands in the world.
    back = source(there["position"][:2] + [10 - 1e-9], [-c for c in there["direction"]], "noise")
    scene = noise(10, amplitude, back).replace("at: [0, 0, 10], surface", "at: [0, 0, 0.1], surface")
    again = report("noise-back", scene)["steps"][0]
    checks.close("sent back", again["position"], START, abs=1e-6)


def mean_square_angle(length):
    light = source([0, 0, 0], AHEAD, "noise", "disc: 20")
    target = trace("turbulence", noise(length, 1e-3, light, "air", ", tolerance: 1.0e-6"),
                   many(10_000), encoding="plain")
    (end,) = columns(target, "ray/end_direction")
    drop(target)
    end = end[end[:, 2] > 0].astype(float)
    checks.true("rays got through", len(end) > 0.9 * many(10_000))
    return (end[:, :2] ** 2).sum(1).mean()


ratio = mean_square_angle(40) / mean_square_angle(20)
print(f"mean square angle over twice the path: {ratio:.3f}")
checks.close("mean square angle over twice the path", ratio, 2.0, rel=0.15)
checks.finish()
