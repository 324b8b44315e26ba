#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: a mesh whose faces lie on planes, cylinders, cones, spheres and tori is met where these are, to 1e-9, and a body
of them is entered and left by turns. Points and normals are held against the surfaces' equations, a singlet and a pair of
lenses against the same as analytic lenses, which tests/physics/test_lenses.py holds against published ones."""
import json
import math
import os
import shutil
import subprocess
import sys

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
import h5py
import numpy
import raymap
from model_meshes import arc, box, cap, line, off_surface, revolved, sag, singlet, torus

checks = raymap.Checks()
EXACT = 1e-9
HEAD = """raymap: 1
units: mm
spectrum: {mode: spectral, wavelengths: [587.56]}
media: {air: {index: 1}, glass: {index: 1.5168}, flint: {index: 1.62}}
surfaces: {polished: {type: fresnel}}
"""
BEAM = """sources:
  - {name: beam, type: collimated, shape: {disc: 11.5}, at: [-0.7, -0.2, -20], direction: [0.05, 0.02, 1]}
detectors:
  - {name: focus, type: plane, at: [0, 0, 58], size: [200, 200], cells: [10, 10], direction: [0, 0, -1]}
"""
ROUND = math.radians(15)


def mesh_scene(file, more="", after=BEAM, geometry=""):
    return HEAD + f"""geometries: {{body: {{type: mesh, file: {file}{geometry}}}}}
objects: [{{name: body, geometry: body, surface: polished, inside: glass, outside: air{more}}}]
""" + after


def lens_scene(r1, r2, more=""):
    return HEAD + f"""geometries:
  body: {{type: lens, surface: polished, edge: polished, surfaces: [{{radius: {r1}, thickness: 8, medium: glass, aperture: 12}},
         {{radius: {r2}, medium: air, aperture: 12}}]}}
objects: [{{name: body, geometry: body, outside: air{more}}}]
""" + BEAM


def same_rays(what, a, b, rays):
    """Steps and registrations of two scenes' rays."""
    for ray, (first, second) in enumerate(zip(raymap.reports("a", a, rays), raymap.reports("b", b, rays))):
        name = f"{what}, ray {ray}"
        checks.close(f"{name}: steps", len(first["steps"]), len(second["steps"]))
        for k, (p, q) in enumerate(zip(first["steps"], second["steps"])):
            checks.true(f"{name}, step {k}: events", p["events"] == q["events"])
            checks.close(f"{name}, step {k}: place", p["position"], q["position"], abs=EXACT)
            if p["normal"]:
                dot = sum(x * y for x, y in zip(p["normal"], q["normal"]))
                sine = math.hypot(*numpy.cross(p["normal"], q["normal"]))
                checks.close(f"{name}, step {k}: normal", sine if dot else 1.0, 0.0, abs=EXACT)
        for p, q in zip(first["registrations"], second["registrations"]):
            for key in ("x", "y", "optical_path"):
                checks.close(f"{name}: {key} at the focus", p[key], q[key], abs=EXACT)


def test_singlet():
    singlet(50, -60, 8, 12, halves=2).write("singlet.ply")
    same_rays("singlet", mesh_scene("singlet.ply"), lens_scene(50, -60), 10 if raymap.SCALE > 1 else 4)
    # in inches, as an instance that is turned, moved and stretched along its axes
    small = singlet(50 / 25.4, -60 / 25.4, 8 / 25.4, 12 / 25.4)
    small.write("inches.ply")
    more = ", scale: [1, 1.2, 0.9], rotate: [3, -5, 40], at: [0.4, -0.3, 2]"
    same_rays("instance", mesh_scene("inches.ply", more, geometry=", scale: in"), lens_scene(50, -60, more), 6 if raymap.SCALE > 1 else 3)
    flat = raymap.report("a", mesh_scene("singlet.ply", geometry=", exact: false"), 1)
    true = raymap.report("b", mesh_scene("singlet.ply"), 1)
    checks.true("'exact: false' is flat", math.dist(flat["steps"][0]["position"], true["steps"][0]["position"]) > 1e-4)


BODIES = {
    "lens": (singlet(50, -60, 8, 12, halves=2), (0, 0, 4)),
    "meniscus": (singlet(30, 60, 8, 12), (0, 0, 5)),
    "torus": (torus(10, 3), (10, 0, 0)),
    "cone": (revolved([line((0, 0), (5, 0)), line((5, 0), (0, 8))]), (0, 0, 2)),
    "frustum": (revolved([line((0, 0), (5, 0)), line((5, 0), (2, 8)), line((2, 8), (0, 8))], 2 * ROUND, 2), (0, 0, 2)),
    "capsule": (revolved([arc((0, -5), (5, 0), (0, 0), 5), line((5, 0), (5, 9)), arc((5, 9), (0, 14), (0, 9), 5)], ROUND, 2),
                (1, 0.5, 4)),
    "rounded": (revolved([line((0, 0), (4, 0)), arc((4, 0), (6, 2), (4, 2), 2), line((6, 2), (6, 10)),
                          arc((6, 10), (4, 12), (4, 10), 2), line((4, 12), (0, 12))], ROUND), (1, 0.5, 5)),
    "pipe": (revolved([line((3, 0), (5, 0)), line((5, 0), (5, 9)), line((5, 9), (3, 9)), line((3, 9), (3, 0))], ROUND), (4, 0.1, 5)),
    "box": (box((4, 5, 6)), (0.3, 0.2, 0.1)),
    "triangles": (revolved([dict(cap(30, 0, 12, True), kind=0), line((12, sag(30, 12)), (12, 9)),
                            cap(-40, 9 - sag(-40, 12), 12, False)]), (0, 0, 5)),
}
MAPS = ("lens", "torus")
LIGHT = """limits: {steps: 40}
sources:
  - {name: in, type: point, at: %s, medium: glass}
  - {name: out, type: area, shape: {rectangle: [40, 40]}, at: [0, 0, 45], direction: [0, 0, -1]}
"""


def test_bodies():
    for name, (model, inside) in BODIES.items():
        model.write(name + ".ply")
        text = mesh_scene(name + ".ply", after=LIGHT % list(inside))
        target = raymap.trace(name, text, raymap.many(20000 if name in MAPS else 6000), encoding="plain")
        stop, count, medium = raymap.columns(target, "ray/stop", "ray/segment_count", "segment/medium")
        last = medium[numpy.cumsum(count) - 1]
        checks.close(f"{name}: rays that end in an error", int((stop == 3).sum()), 0)
        checks.close(f"{name}: rays that leave the scene in glass", int(((stop == 1) & (last == 1)).sum()), 0)
        checks.true(f"{name}: rays leave it", int((stop == 1).sum()) > 0.5 * len(stop))
        for ray in raymap.some(range(1, 4), 0):
            for step in raymap.report(name, text, ray)["steps"][:12]:
                row = model.surfaces[step["face"]] if step["normal"] else (0,)
                if row[0] == 0:
                    continue
                off, normal = off_surface(row, step["position"])
                checks.close(f"{name}: distance from its surface", off, 0, abs=EXACT)
                sine = math.hypot(*numpy.cross(normal, step["normal"]))
                checks.close(f"{name}: sine between normals", sine, 0, abs=EXACT)


def told(target):
    return json.loads(raymap.run("info", target, "--json"))["digest"]


def test_maps():
    """One digest for any encoding, threads, ranks; maps are whole and say what they need."""
    for name in MAPS:
        scene = raymap.write_scene(name, mesh_scene(name + ".ply", after=LIGHT % list(BODIES[name][1])))
        plain = name + ".raymap"
        want = told(plain)
        for k, launch in enumerate(([], ["mpirun", "-np", "2"]) if name == "lens" else ([],)):
            target = f"{name}-{k}.raymap"
            shutil.rmtree(target, ignore_errors=True)
            subprocess.run([*launch, raymap.PROGRAM, "trace", scene, "-o", target, "-n", str(raymap.many(20000)), "--quiet",
                            "--encoding", "compact", "--threads", "2"], check=True, stderr=subprocess.DEVNULL)
            checks.true(f"{name}: digest of {target}", told(target) == want)
            raymap.run("verify", target, "--quiet")
    with h5py.File("lens.raymap/map.h5") as file:
        features = file.attrs["features"]
    features = features.decode() if isinstance(features, bytes) else features
    checks.true("feature of the map", "surfaces" in features.split())
    small = sum(os.path.getsize(os.path.join(d, f)) for d, _, fs in os.walk("lens-0.raymap") for f in fs)
    checks.true(f"compact: {small / raymap.many(20000):.1f} bytes a ray", small < 12 * raymap.many(20000) + 200000)


def test_pair():
    """Two bodies that touch with curved faces, against analytic lenses."""
    singlet(50, -40, 8, 12, halves=2).write("first.ply")
    singlet(-40, -200, 4, 12, chord=math.radians(7)).write("second.ply")
    after = "limits: {steps: 40}\n" + BEAM.replace("detectors:", "  - {name: in, type: point, at: [1, 2, 4], medium: glass}\ndetectors:")
    meshes = HEAD + """geometries: {a: {type: mesh, file: first.ply}, b: {type: mesh, file: second.ply}}
objects:
  - {name: a, geometry: a, surface: polished, inside: glass, outside: air}
  - {name: b, geometry: b, at: [0, 0, 8], surface: polished, inside: flint, outside: air}
""" + after
    lenses = HEAD + """geometries:
  a: {type: lens, surface: polished, edge: polished, surfaces: [{radius: 50, thickness: 8, medium: glass, aperture: 12},
      {radius: -40, medium: air, aperture: 12}]}
  b: {type: lens, surface: polished, edge: polished, surfaces: [{radius: -40, thickness: 4, medium: flint, aperture: 12},
      {radius: -200, medium: air, aperture: 12}]}
objects: [{name: a, geometry: a, outside: air}, {name: b, geometry: b, at: [0, 0, 8], outside: air}]
""" + after
    asked = ("registered(focus)", "hit(a, reflect_specular)", "hit(b) > 3", "hit(*, error)")
    a = raymap.rays(raymap.trace("pair", meshes, raymap.many(15000)), *asked)[0]
    b = raymap.rays(raymap.trace("pair-lenses", lenses, raymap.many(15000)), *asked)[0]
    checks.close("pair: rays that match", a, b, abs=2)
    checks.close("pair: errors", a[3], 0)


test_singlet()
test_bodies()
test_maps()
test_pair()
checks.finish()
