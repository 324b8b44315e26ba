#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Closed bodies: `box`, `prism`, and tubes with caps.

* A room of each, lit from within and grey inside, keeps every ray: none finds a gap at an edge or a rim.
* A slab of glass passes (1 - R) / (1 + R), a box and a closed cylinder alike (Born & Wolf, 7th ed., 1.5.2).
* A prism of apex angle A turns a ray that crosses it symmetrically by D, sin((A + D) / 2) = n sin(A / 2) (4.7.2).
"""
import math

from raymap import Checks, drop, many, rays, report, trace

checks = Checks()
HEAD = "raymap: 1\nspectrum: {wavelengths: [587.56]}\nmedia: {air: {index: 1}, glass: {index: 1.5}}\n"
BODIES = {
    "box": "{type: box, size: [10, 8 mm, 0.6 cm]}",
    "prism": "{type: prism, sides: 5, radius: 8, length: 6}",
    "ell": "{type: prism, points: [[-4, 8], [-4, -4], [8, -4], [8, 3], [3, 3], [3, 8]], length: 6}",
    "cylinder": "{type: cylinder, radius: 5, length: 6, closed: true}",
    "cone": "{type: cone, radius: 5, radius2: 2, length: 6, closed: true}",
    "tip": "{type: cone, radius: 5, radius2: 0, length: 6, closed: true}",
}

for name, body in BODIES.items():
    room = trace("room-" + name, HEAD + f"""surfaces: {{grey: {{type: lambert, reflectance: 90 %}}}}
geometries: {{body: {body}}}
objects: [{{name: room, geometry: body, surface: grey, rotate: [20, 30, 40], at: [1, 2, 3]}}]
sources: [{{name: lamp, type: point, rotate: [20, 30, 40], at: [1.8, 1.6, 4.5]}}]
""", many(50_000))
    (kept,), total = rays(room, "ended(absorbed, room)")
    checks.close(f"{name}: rays kept by a closed room", kept, total)
    drop(room)

for name in ("box", "cylinder"):
    slab = trace("slab-" + name, HEAD + f"""geometries: {{body: {BODIES[name]}}}
objects: [{{name: slab, geometry: body, surface: fresnel, inside: glass, outside: air}}]
sources: [{{name: beam, type: collimated, shape: {{disc: 1}}, at: [0.3, 0.2, -5]}}]
detectors: [{{name: behind, type: plane, at: [0, 0, 9], size: 20, cells: 1}}]
""", many(200_000))
    (passed,), total = rays(slab, "registered(behind)")
    checks.share(f"{name}: passed by a slab", passed, total, 2 * 1.5 / (1.5 ** 2 + 1))
    drop(slab)

APEX, INDEX = math.radians(60), 1.5
turned = 2 * math.asin(INDEX * math.sin(APEX / 2)) - APEX
start = [-30 * math.cos(turned / 2), 5 - 30 * math.sin(turned / 2), 5]
ray = report("deviation", HEAD + f"""surfaces: {{clear: {{type: fresnel, coat: ideal}}}}
geometries: {{body: {{type: prism, sides: 3, radius: 20, length: 10}}}}
objects: [{{name: prism, geometry: body, rotate: [0, 0, 90 deg], surface: clear, inside: glass, outside: air}}]
sources: [{{name: beam, type: rays, rays: [{{origin: {start!r}, direction: [{math.cos(turned / 2)!r}, {math.sin(turned / 2)!r}, 0]}}]}}]
""")
# The corners of the mesh are in single precision.
checks.close("prism: direction behind it", ray["steps"][-1]["direction"],
             [math.cos(turned / 2), -math.sin(turned / 2), 0], abs=2e-7)
checks.finish()
