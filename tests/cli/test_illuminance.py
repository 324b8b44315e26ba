#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: lux are lumens by V(lambda): of sources in W where the scene says their spectra, else an error."""
import json
import os
import subprocess

PROGRAM = os.environ["RAYMAP"]
# CIE 1924 V(lambda) between its tabulated values at 480, 490, 580, 590, 650, 660 nm, linearly.
V = {486.13: 0.13902 + 0.613 * (0.20802 - 0.13902), 587.56: 0.870 - 0.756 * (0.870 - 0.757),
     656.27: 0.107 - 0.627 * (0.107 - 0.061)}
SCENE = """raymap: 1
units: m
spectrum: {{mode: spectral, wavelengths: [486.13, 587.56, 656.27]}}
media: {{air: {{index: 1}}}}
geometries: {{wall: {{type: rectangle, size: [4, 4]}}}}
objects: [{{name: screen, geometry: wall, at: [0, 0, 1], surface: absorber, front: air, back: air}}]
sources:
  - {{name: yellow, type: collimated, at: [0, 0, 0], direction: [0, 0, 1], shape: {{disc: 1}}, flux: 2 W, {yellow}}}
  - {{name: mixed, type: collimated, at: [0, 0, 0], direction: [0, 0, 1], shape: {{disc: 1}}, flux: 4 W,
      spectrum: {{lines: {{486.13: 1, 656.27: 3}}}}}}
detectors: [{{name: eye, type: plane, on: screen, size: [4, 4], cells: [8, 8], at: [0, 0, 1], direction: [0, 0, -1]}}]
"""


def run(*arguments, status=0):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == status, (arguments, done.returncode, done.stderr)
    return done


def trace(name, yellow):
    with open(f"{name}.yaml", "w", encoding="utf-8") as scene:
        scene.write(SCENE.format(yellow=yellow))
    run("trace", f"{name}.yaml", "-o", f"{name}.raymap", "-n", 4000, "--force", "--quiet")


def image(*options):
    return json.loads(run("detector", "lit.raymap", "eye", "--json", "--quiet", *options).stdout)


trace("lit", "spectrum: {lines: {587.56: 1}}")
lux, watt = image("--quantity", "illuminance"), image("--quantity", "irradiance")
assert (lux["quantity"], lux["unit"], lux["flux"]["unit"]) == ("illuminance", "lx", "lm"), lux
assert (watt["quantity"], watt["unit"], watt["flux"]["unit"]) == ("irradiance", "W/m2", "W"), watt
want = 683 * (2 * V[587.56] + 4 * (0.25 * V[486.13] + 0.75 * V[656.27]))
assert abs(lux["flux"]["total"] / want - 1) < 0.01, (lux["flux"], want)
assert abs(lux["mean"]["value"] / (lux["flux"]["total"] / 16) - 1) < 1e-9
assert image("--quantity", "illuminance", "--cells", "3x3")["flux"] == lux["flux"]
told = run("detector", "lit.raymap", "eye", "--json", "--quantity", "luminance")
assert json.loads(told.stdout)["unit"] == "W/(m2 sr)" and "this is the radiance" in told.stderr
# Of one wavelength the error is as large a part as that of the watts.
one, other = (image("--quantity", quantity, "--where", "source(yellow)")["flux"] for quantity in ("illuminance", "irradiance"))
assert abs(one["total"] / other["total"] / (683 * V[587.56]) - 1) < 0.01
assert abs(one["standard_error"] / one["total"] - other["standard_error"] / other["total"]) < 1e-6

trace("dark", "medium: air")
told = run("detector", "dark.raymap", "eye", "--quantity", "illuminance", status=3).stderr
assert "source 'yellow' is in W" in told and "spectrum" in told and "irradiance" in told, told
run("detector", "dark.raymap", "eye", "--quantity", "irradiance", "--quiet")
