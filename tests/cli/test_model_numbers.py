# SPDX-License-Identifier: MIT
"""The promise: compact maps are decoded by the group indices, scattering and sags that they hold, whatever a
machine computes of the scene; maps of earlier programs, which hold none, by the scene's own. Maps whose numbers differ are not
merged."""
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


SHAPED = """raymap: 1
units: mm
spectrum: {wavelengths: [500]}
media: {air: {index: 1}, glass: {index: 1.5}}
surfaces: {clear: {type: fresnel}, black: {type: absorber}}
geometries:
  form: {type: conic, radius: 30, aperture: {ellipse: [6, 5], at: [0.5, 0]}, xy: {norm: 5, terms: {x2y1: 0.125, x0y3: -0.0625}}}
  facets: {type: conic, radius: [0, -20], conic: [0, -1], aperture: {rectangle: [12, 12]}, inner: 0.25, fresnel: true}
  lens: {type: lens, surfaces: [{radius: 40, toroid: inf, thickness: 3, medium: glass, aperture: {ellipse: [5, 6]}},
                                {medium: air, aperture: {ellipse: [5, 6]}, zernike: {norm: 6, order: noll, terms: {4: 0.01}}}]}
  cap: {type: conic, radius: 50, aperture: 8}
  wall: {type: rectangle, size: [90, 90]}
objects:
  - {name: f, geometry: form, surface: clear, front: glass, back: air}
  - {name: c, geometry: cap, at: [0, 0, 4], surface: clear, front: air, back: glass}
  - {name: g, geometry: facets, at: [0, 0, 8], surface: clear, front: air, back: air}
  - {name: l, geometry: lens, at: [0, 0, 12], outside: air}
  - {name: w, geometry: wall, at: [0, 0, 40], surface: black, front: air, back: air}
sources: [{name: s, type: collimated, shape: {disc: 4}, at: [0, 0, -9], direction: [0, 0, 1], flux: 1 W, medium: air}]
"""


def run(*arguments, status=0, says=""):
    done = subprocess.run([PROGRAM, *arguments, "--quiet"], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True, timeout=120, check=False)
    assert done.returncode == status and says in done.stderr, (arguments, done.returncode, done.stdout, done.stderr)
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


def changed(change, of="a.raymap"):
    shutil.rmtree("b.raymap", ignore_errors=True)
    shutil.copytree(of, "b.raymap")
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

# Sags: every coefficient and outline as in the text; x^i y^j at (i + j) (i + j + 1) / 2 + j.
for name, scene, first in (("a", SHAPED, "0"), ("more", SHAPED, "2000"), ("other", SHAPED.replace("0.0625", "0.0626"), "2000")):
    with open("scene.yaml", "w", encoding="utf-8") as text:
        text.write(scene)
    run("trace", "scene.yaml", "-o", f"{name}.raymap", "-n", "2000", "--first-ray", first, "--force")
PATH = mean("a.raymap", "path_length")


def look_at_sags(file):
    sag, name = file["model/0/sag"], [n.decode() for n in file["name/geometry"]]
    rows = {n: [k for k, g in enumerate(sag["geometry"]) if name[g] == n] for n in name}
    form, facets = rows["form"][0], rows["facets"][0]
    xy = np.zeros(231)
    xy[3 * 4 // 2 + 1], xy[3 * 4 // 2 + 3] = 0.125, -0.0625
    assert np.array_equal(sag["xy"][form], xy) and sag["xy_norm"][form] == 5 and sag["n_xy"][form] == 4
    assert list(sag["half"][form]) == [6, 5] and list(sag["at"][form]) == [0.5, 0] and sag["inner"][facets] == 0.25
    assert list(sag["curvature"][facets]) == [0, -1 / 20] and list(sag["conic"][facets]) == [0, -1]
    assert sag["rectangle"][facets] == 1 and list(sag["fresnel"]).count(1) == 1 and sag["fresnel"][facets] == 1
    walls = [r for r in rows.values() if len(r) == 2]  # the lens's edge: its bottom and top
    assert len(walls) == 1 and [sag["base"][k] for k in walls[0]] == [2, 0] and sag["n_zernike"][walls[0][1]] == 3
    assert abs(sag["zernike"][walls[0][1]][2 * 3 // 2 + 1] - 0.01 * 3**0.5) < 1e-15


def other_xy(file):
    put(file["model/0/sag/xy"], 9, -0.0626)


def other_hole(file):
    put(file["model/0/sag/inner"], 1, 0.26)


def other_facets(file):
    put(file["model/0/sag/conic"], 3, -1.01)


def other_radius(file):
    curvature = file["model/0/geometry/shape.curvature"]
    put(curvature, int(np.flatnonzero(curvature[()] == 1 / 50)[0]), 1 / 50.1)


def without_sags(file):
    del file["model/0/sag"]


changed(look_at_sags)
run("merge", "a.raymap", "more.raymap", "-o", "sum.raymap", "--force")
run("merge", "a.raymap", "other.raymap", "-o", "sum.raymap", "--force", status=3)
for change in (other_radius, other_xy, other_hole, other_facets):
    changed(change, "more.raymap")
    run("merge", "a.raymap", "b.raymap", "-o", "sum.raymap", "--force", status=3, says="computes other numbers from the scene")
changed(other_xy)
assert mean("b.raymap", "path_length") != PATH
run("verify", "b.raymap", status=4)
changed(lambda file: put(file["model/0/sag/xy_norm"], 0, -5.0))
run("info", "b.raymap", status=4, says="/model/0/sag")
changed(without_sags)
run("verify", "b.raymap")
assert mean("b.raymap", "path_length") == PATH
print("all as expected")
