# SPDX-License-Identifier: MIT
"""The promise: compact maps are decoded by the group indices and scattering that they hold, whatever a
machine computes of the scene; maps of earlier programs, which hold none, by the scene's own."""
import json
import os
import shutil
import subprocess

import numpy as np
from sealed_map import edit, put

PROGRAM = os.environ["RAYMAP"]
NM = np.array([420.0, 500.0, 650.0])
SCENE = """raymap: 1
units: mm
time: on
spectrum: {wavelengths: [420, 500, 650]}
media:
  glass: {glass: N-BK7}
  hazy: {index: 1.5, scattering: {haze: 0.1, thickness: 3, g: 0.9}}
surfaces: {clear: {type: fresnel}, black: {type: absorber}}
geometries: {ball: {type: sphere, radius: 3}, wall: {type: rectangle, size: [40, 40]}}
objects:
  - {name: b, geometry: ball, at: [0, 0, 5], surface: clear, inside: hazy, outside: glass}
  - {name: w, geometry: wall, at: [0, 0, 20], surface: black, front: glass, back: glass}
sources: [{name: s, type: collimated, shape: {disc: 2}, at: [0, 0, -9], direction: [0, 0, 1], flux: 1 W, medium: glass}]
"""


def run(*arguments, status=0):
    done = subprocess.run([PROGRAM, *arguments, "--quiet"], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True, timeout=120, check=False)
    assert done.returncode == status, (arguments, done.returncode, done.stdout, done.stderr)
    return done.stdout


def mean(path, number):
    return json.loads(run("stats", path, "--of", number, "--json"))["mean"]["value"]


# N-BK7's Sellmeier formula (SCHOTT), n - L dn/dL; ASTM D1003 haze: the share of light that is turned by more than 2.5 degrees
# in air, by Henyey and Greenstein.
B, C = np.array([1.03961212, 0.231792344, 1.01046945]), np.array([0.00600069867, 0.0200179144, 103.560653])
L2 = (NM[:, None] * 1e-3)**2
N = np.sqrt(1 + np.sum(B * L2 / (L2 - C), axis=1))
GROUP = N + np.sum(B * C * L2 / (L2 - C)**2, axis=1) / N
MU = np.sqrt(1 - (np.sin(np.radians(2.5)) / 1.5)**2)
BEYOND = (1 - 0.81) / 1.8 * (1 / np.sqrt(1.81 - 1.8 * MU) - 1 / 1.9)
SCATTERING = -np.log(0.9) / (BEYOND * 3)

with open("scene.yaml", "w", encoding="utf-8") as text:
    text.write(SCENE)
shutil.rmtree("a.raymap", ignore_errors=True)
run("trace", "scene.yaml", "-o", "a.raymap", "-n", "4000")
GROUP_PATH, PATH = mean("a.raymap", "group_path"), mean("a.raymap", "path_length")


def changed(change):
    shutil.rmtree("b.raymap", ignore_errors=True)
    shutil.copytree("a.raymap", "b.raymap")
    for name in ("map.h5", "map-start.h5"):
        if os.path.exists(f"b.raymap/{name}"):
            edit(f"b.raymap/{name}", change)


def look(file):
    model = file["model/0"]
    assert np.allclose(model["times/n_group"][0], GROUP, rtol=1e-12), (model["times/n_group"][0], GROUP)
    assert np.allclose(model["turbid/scattering"][1], SCATTERING, rtol=1e-9)
    assert np.all(model["turbid/scattering"][0] == 0) and model["turbid/scattering_g"][1] == 0.9


def other_groups(file):
    put(file["model/0/times/n_group"], None, 3.0)


def other_scattering(file):
    put(file["model/0/turbid/scattering"], slice(3, 6), 2 * SCATTERING)


def as_before(file):
    del file["model/0/times"], file["model/0/turbid"]


changed(look)
changed(other_groups)
assert abs(mean("b.raymap", "group_path") / mean("b.raymap", "path_length") - 3) < 0.01
run("verify", "b.raymap", status=4)
changed(other_scattering)
assert mean("b.raymap", "path_length") != PATH
run("verify", "b.raymap", status=4)
changed(as_before)
run("verify", "b.raymap")
assert (mean("b.raymap", "group_path"), mean("b.raymap", "path_length")) == (GROUP_PATH, PATH)
print("all as expected")
