#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: whether a reflection makes a ghost is said by the side that the light met, in every command."""
import json
import os
import subprocess

PROGRAM = os.environ["RAYMAP"]
SCENE = """raymap: 1
units: mm
media: {{air: {{index: 1}}, water: {{index: 1.33}}}}
surfaces:
  gloss: {{type: mixture, reflect_specular: 0.3, reflect_diffuse: 0.35}}
  silver: {{type: mirror, reflectance: 1}}
geometries: {{disc: {{type: disc, radius: 10}}}}
objects: [{{name: two, geometry: disc, surface: {{front: gloss, back: silver}}, front: {front}, back: air}}]
sources:
  - {{name: behind, type: collimated, at: [0, 0, -20], direction: [0, 0, 1], shape: {{disc: 1}}, flux: 1 W, medium: air}}
  - {{name: before, type: collimated, at: [0, 0, 20], direction: [0, 0, -1], shape: {{disc: 1}}, flux: 1 W, medium: {front}}}
detectors: [{{name: far, type: intensity, cells: [6, 12], axis: [0, 0, 1]}}]
"""


def ask(*arguments):
    done = subprocess.run([PROGRAM, *map(str, arguments), "--json", "--quiet"], capture_output=True, text=True, timeout=120,
                          check=False)
    assert done.returncode == 0, (arguments, done.stderr)
    return json.loads(done.stdout)


def count(file, criterion):
    return ask("query", file, criterion)["rays"]["matched"]


for front in ("air", "water"):  # where media do not tell the side geometry does
    with open("two.yaml", "w", encoding="utf-8") as scene:
        scene.write(SCENE.format(front=front))
    for encoding in ("plain", "compact"):
        file = f"{front}-{encoding}.raymap"
        ask("trace", "two.yaml", "-o", file, "-n", 2000, "--encoding", encoding, "--force")
        mirrored = count(file, "source(behind) and hit(two, reflect_specular)")
        glossy = count(file, "source(before) and hit(two, reflect_specular)")
        assert mirrored == 1000 and 200 < glossy < 400, (mirrored, glossy)
        assert count(file, "source(behind) and ghost_order >= 1") == 0
        assert count(file, "source(before) and ghost_order == 1") == glossy
        assert count(file, "ghost_order == 1") == glossy == count(file, "registered(far where ghost_order == 1)")
        values = ask("stats", file, "--of", "ghost_order", "--bins", "-0.5,0.5,1.5")
        assert abs(values["mean"]["value"] - glossy / 2000) < 1e-12, values["mean"]
        values = ask("stats", file, "--of", "ghost_order(far)")
        assert values["values"] > 0 and abs(values["mean"]["value"] * values["values"] - glossy) < 1e-6, values["mean"]
        orders = ask("paths", file, "--matrix", "orders", "--detector", "far", "--top", "all")["orders"]
        rays = {}
        for row in orders:
            rays[row["ghost_order"]] = rays.get(row["ghost_order"], 0) + row["rays"]
            assert count(file, row["criterion"]) == row["rays"], row
        assert rays[1] == glossy and rays[0] >= mirrored, rays
