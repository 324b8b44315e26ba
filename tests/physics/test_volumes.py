#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Light from within bodies: places are uniform in spheres, closed tubes, lenses, boxes and meshes, along tracks and by grids; what total
reflection keeps in a cube (Weber & Lambe 1976) and in a fibre, with its cladding bare in air, too; maps are the same in either encoding, on any number of ranks."""
import json
import math
import os
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(os.environ["SOURCE_DIR"]) / "tests" / "cli"))
import asking  # noqa: E402
import h5py  # noqa: E402
import numpy as np  # noqa: E402
from asking import check, run, told_of  # noqa: E402
import raymap.serve  # noqa: E402


def trace(text, n, name="v", **more):
    pathlib.Path(f"{name}.yaml").write_text(text, encoding="utf-8")
    run("trace", f"{name}.yaml", "-n", n, "-o", f"{name}.raymap", "--force", "--quiet", **more)
    return f"{name}.raymap"


def share(target, which):
    told = json.loads(run("query", target, which, "--count", "--json"))
    return told["rays"]["matched"] / told["rays"]["total"]


def near(found, want, n, what):
    z = (found - want) / math.sqrt(want * (1 - want) / n)
    check(abs(z) < 4, f"{what}: {found:.5f}, not {want:.5f}: z = {z:.1f}")


CUBE = """raymap: 1
spectrum: {wavelengths: [500]}
limits: {steps: 400}
media: {air: {index: 1}, glass: {index: INDEX, absorption: 1e-6 /mm}}
surfaces: {bare: {type: fresnel}}
geometries: {cube: {type: box, size: [1, 1, 1]}}
objects: [{name: cube, geometry: cube, surface: bare, inside: glass, outside: air, rotate: [10, 20, 30]}]
sources: [{name: s, type: volume, in: cube}]
"""


def check_cube():
    for index, trapped in ((1.5, 0.23606797749979), (1.58, 1 - 3 * 0.225775762867188)):
        n = 12000
        near(1 - share(trace(CUBE.replace("INDEX", str(index)), n), "ended(left)"), trapped, n, f"trapped in a cube of {index}")


FIBRE = """raymap: 1
spectrum: {wavelengths: [500]}
media: {core: {index: 1.6}, clad: {index: 1.49}}
surfaces: {bare: {type: fresnel}, black: {type: absorber}}
geometries: {side: {type: cylinder, radius: 1, length: 100}, end: {type: disc, radius: 1}, skin: {type: cylinder, radius: 2, length: 100}}
objects:
  - name: fibre
    objects:
      - {name: side, geometry: side, surface: bare, front: clad, back: core}
      - {name: left, geometry: end, rotate: [180, 0, 0], surface: black, back: core}
      - {name: right, geometry: end, at: [0, 0, 100], surface: black, back: core}
  - {name: skin, geometry: skin, surface: black, back: clad}
sources: [{name: s, type: volume, WHERE, medium: core}]
"""


def check_fibre():
    n = 20000
    for where, per_end in (("from: [0, 0, 45], to: [0, 0, 55]", (1 - 1.49 / 1.6) / 2), ("in: fibre", (1 - (1.49 / 1.6) ** 2) / 2)):
        target = trace(FIBRE.replace("WHERE", where), n)
        both = share(target, "hit(left) or hit(right)")
        if where[0] == "f":  # what meets the side beyond the critical angle and is reflected in part is gone after 45 mm
            near(both, 2 * per_end, n, f"to both ends, {where}")
        else:  # light that starts near an end reaches it without total reflection
            far = share(target, "hit(left) and start_z > 60 or hit(right) and start_z < 40")
            near(far, 0.8 * per_end, n, "to the far end from the whole core")
    # The same core bare in air.
    target = trace(FIBRE.replace("clad: {index: 1.49}", "clad: {index: 1}").replace("WHERE", "in: fibre"), n)
    far = share(target, "hit(left) and start_z > 60 or hit(right) and start_z < 40")
    near(far, 0.8 * 0.304688, n, "to the far end of a bare core")
    # And with its cladding, bare in air: axial index and skewness are kept, so light is caught that cannot leave the skin, or not the core.
    dice, radius = np.random.default_rng(7), 1.03
    z, angle, at = dice.random(1_000_000), 2 * math.pi * dice.random(1_000_000), np.sqrt(dice.random(1_000_000))
    axial, skew = (1.6 * z) ** 2, (1.6 * at * np.sqrt(1 - z * z) * np.sin(angle)) ** 2
    caught = ((axial + skew / radius ** 2 > 1) | (axial + skew > 1.49 ** 2)).mean() / 2
    check(abs(((axial + skew > 1) | (axial + skew > 1.49 ** 2)).mean() / 2 - 0.3047) < 1e-3, "a thin cladding catches 30.5 % an end")
    target = trace(CLAD.replace("RADIUS", str(radius)).replace("WHERE", "in: fibre"), n)
    far = share(target, "(hit(left*) and start_z > 60) or (hit(right*) and start_z < 40)")
    near(far, 0.8 * caught, n, "to the far end of a bare cladding")


CLAD = FIBRE.replace("media: {", "media: {air: {index: 1}, ").replace("radius: 2, length: 100}", "radius: RADIUS, length: 100}, "
                                                                     "ring: {type: disc, radius: RADIUS, inner: 1}").replace(
    "  - {name: skin, geometry: skin, surface: black, back: clad}", "  - {name: skin, geometry: skin, surface: bare, front: air, back: clad}\n"
    "  - {name: left_ring, geometry: ring, rotate: [180, 0, 0], surface: black, back: clad}\n"
    "  - {name: right_ring, geometry: ring, at: [0, 0, 100], surface: black, back: clad}")


BODIES = """raymap: 1
spectrum: {wavelengths: [500]}
media: {air: {index: 1}, glass: {index: 1}}
surfaces: {bare: {type: fresnel}, black: {type: absorber}}
geometries:
  rod: {type: cylinder, radius: 2, length: 10, closed: true}
  ball: {type: sphere, radius: 3}
  wedge: {type: mesh, file: wedge.obj}
  lens: {type: lens, surfaces: [{radius: 20, thickness: 5, medium: glass, aperture: 6}, {radius: -30, medium: air, aperture: 6}]}
objects:
  - {name: rod, geometry: rod, surface: bare, inside: glass, outside: air, rotate: [90, 0, 0]}
  - {name: ball, geometry: ball, surface: bare, inside: glass, outside: air, at: [20, 0, 0]}
  - {name: wedge, geometry: wedge, surface: bare, inside: glass, outside: air, at: [40, 0, 0]}
  - {name: lens, geometry: lens, outside: air, at: [60, 0, 0], rotate: [0, 90, 0], surface: bare, edge: bare}
sources:
  - {name: rod_light, type: volume, in: rod}
  - {name: ball_light, type: volume, in: ball}
  - {name: wedge_light, type: volume, in: wedge}
  - {name: lens_light, type: volume, in: lens}
  - {name: track, type: volume, from: [0, 0, 30], to: [10, 5, 30]}
  - {name: deposits, type: volume, file: edep.h5, dataset: edep, origin: [0, 0, 50], spacing: [1, 2, 3], unit: mm}
detectors: [{name: far, type: intensity, cells: [9, 9]}]
"""


def uniform(u, what):
    """Kolmogorov's distance of numbers that are to be uniform in (0, 1)."""
    u = np.sort(u)
    distance = np.abs(u - (np.arange(len(u)) + 0.5) / len(u)).max() * math.sqrt(len(u))
    check(0 <= u[0] and u[-1] <= 1 and distance < 2.0, f"{what}: {u[0]}, {u[-1]}, distance {distance:.2f}")


def check_places():
    pathlib.Path("wedge.obj").write_text("v 0 0 0\nv 3 0 0\nv 0 3 0\nv 0 0 3\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", encoding="ascii")
    edep = np.arange(24.0).reshape(2, 3, 4)
    with h5py.File("edep.h5", "w") as file:
        file["edep"] = edep
    digests = set()
    for ranks, encoding in ((1, "compact"), (3, "compact"), (2, "plain")):
        pathlib.Path("b.yaml").write_text(BODIES, encoding="utf-8")
        run("trace", "b.yaml", "-n", 12000, "-o", "b.raymap", "--force", "--quiet", "--encoding", encoding, ranks=ranks)
        with h5py.File("b.raymap/map.h5") as index:
            digests.add(str(index.attrs["digest"]))
    run("verify", "b.raymap")
    check(len(digests) == 1, f"one map: {digests}")
    run("draw", "b.raymap", "--view", "xz", "--limit", 20, "-o", "b.svg", "--force")
    run("query", "b.raymap", "all", "-o", "b.h5", "--force", "--columns", "ray,registration")
    with h5py.File("b.h5") as file:
        ray = file["ray"]
        check(set(np.array(ray["registration_count"])) == {1}, "each ray leaves the scene")
        source, place = np.array(ray["source"]), np.column_stack([ray[f"start_{k}"] for k in "xyz"])
        way = np.column_stack([file[f"registration/direction_{k}"] for k in "xyz"])
    for s in range(6):
        for k in range(3):
            uniform((way[source == s, k] + 1) / 2, f"directions of source {s}, part {k}")
    rod, ball, wedge, lens, track, deposit = (place[source == s] for s in range(6))
    uniform(-rod[:, 1] / 10, "along the rod")
    uniform((rod[:, 0] ** 2 + rod[:, 2] ** 2) / 4, "across the rod")
    uniform((np.linalg.norm(ball - [20, 0, 0], axis=1) / 3) ** 3, "in the ball")
    sums = (wedge - [40, 0, 0]).sum(axis=1) / 3
    uniform(sums ** 3, "in a tetrahedron")
    z, square = lens[:, 0] - 60, lens[:, 1] ** 2 + lens[:, 2] ** 2
    front, back = 20 - np.sqrt(400 - square), 5 - 30 + np.sqrt(900 - square)
    uniform((z - front) / (back - front), "between a lens's surfaces")
    uniform(track[:, 0] / 10, "along a track")
    check(np.abs(track[:, 1] - track[:, 0] / 2).max() < 1e-5, "on a track")
    cell = np.rint((deposit - [0, 0, 50]) / [1, 2, 3]).astype(int)
    count = np.zeros(edep.shape)
    np.add.at(count, tuple(cell.T), 1)
    want = edep / edep.sum() * len(deposit)
    check(np.abs((count - want) / np.sqrt(np.maximum(want, 1))).max() < 4.5, "cells by their deposits")
    uniform(deposit[:, 1] / 2 - cell[:, 1] + 0.5, "in a cell")


def check_mistakes(server):
    for old, new, said in ((", in: ball}", "}", "'in' is missing: the body that shines"),
                           (", in: ball}", ", in: bal}", "unknown object or group 'bal' (did you mean 'ball'?)"),
                           (", in: ball}", ", in: rod_light}", "'rod_light' is no object or group"),
                           (", in: ball}", ", in: ball, at: [0, 0, 1]}", "'at' is of a grid in a 'file'"),
                           (", to: [10, 5, 30]}", "}", "'to' is missing: a track has two ends"),
                           ("type: volume, in: ball", "type: volume, in: bottom",
                            "of 4096 places in the box about the body 0 lie inside: it must be closed")):
        text = BODIES.replace(old, new).replace("  - {name: ball, ", "  - {name: bottom, geometry: flat, surface: black, at: [0, 0, -90]}\n  - {name: ball, ", 1)
        text = text.replace("  ball: {type", "  flat: {type: disc, radius: 3}\n  ball: {type")
        its, told = told_of(server, text.replace("in: bottom}", "in: bottom, medium: air}"))
        check(its["errors"] and said in told, f"{said}\n{told}")
    pathlib.Path("b.yaml").write_text(BODIES, encoding="utf-8")
    told = run("trace", "b.yaml", "--without", "ball", "-n", 10, "-o", "w.raymap", "--force", "--quiet", status=3)
    check("source 'ball_light': the body that it fills is not in the scene" in told, told)
    run("trace", "b.yaml", "--without", "ball", "--without", "ball_light", "--without", "rod", "--without", "rod_light", "-n", 100, "-o",
        "w.raymap", "--force", "--quiet")
    run("verify", "w.raymap")


check_places()
with raymap.serve.start("b.yaml") as asked:
    check_mistakes(asked)
check_cube()
check_fibre()
asking.finish()
