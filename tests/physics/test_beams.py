#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Beams: a Gaussian beam's power through apertures and its width on its way (RAD-17; Siegman, Lasers, 1986, ch. 17); apodised beams; fibre ends;
areas with an intensity of their own, by formula, table and lamp's file; maps are the same in either encoding and on any number of ranks."""
import json
import math
import os
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(os.environ["SOURCE_DIR"]) / "tests" / "cli"))
import asking  # noqa: E402
import h5py  # noqa: E402
import lamp_files  # noqa: E402
import numpy as np  # noqa: E402
from asking import check, run  # noqa: E402

HEAD = """raymap: 1
units: mm
spectrum: {wavelengths: [632.8]}
media: {air: {index: 1}}
geometries: {patch: {type: mesh, file: patch.obj}}
"""


def rays(sources, detectors, n):
    """Of each source: starts, directions; places on each plane."""
    text = HEAD + "sources:\n" + "".join(f"  - {{{source}, medium: air}}\n" for source in sources)
    text += "detectors:\n  - {name: all, type: intensity, cells: [9, 9]}\n"
    text += "".join(f"  - {{name: d{k}, type: plane, at: [0, 0, {z}], size: 50, cells: 1, side: both}}\n" for k, z in enumerate(detectors))
    pathlib.Path("b.yaml").write_text(text, encoding="utf-8")
    digests = set()
    for ranks, encoding in ((1, "plain"), (2, "compact")):
        run("trace", "b.yaml", "-n", n, "-o", "b.raymap", "--force", "--quiet", "--encoding", encoding, ranks=ranks)
        run("verify", "b.raymap")
        digests.add(json.loads(run("info", "b.raymap", "--json"))["digest"])
    check(len(digests) == 1, f"one map: {digests}")
    run("draw", "b.raymap", "--view", "xz", "--limit", 20, "-o", "b.svg", "--force")
    run("query", "b.raymap", "all", "-o", "b.h5", "--force", "--columns", "ray,registration")
    with h5py.File("b.h5") as file:
        ray, of = file["ray"], file["registration"]
        start = np.column_stack([ray[f"start_{k}"] for k in "xyz"])
        source, detector = np.array(of["source"]), np.array(of["detector"])
        place = np.column_stack([of[f"world_{k}"] for k in "xyz"])
        way = np.column_stack([of[f"direction_{k}"] for k in "xyz"])
        mine = np.array(ray["source"])
        return [(start[mine == s], way[(source == s) & (detector == 0)],
                 [place[(source == s) & (detector == d + 1)] for d in range(len(detectors))]) for s in range(len(sources))]


def near(found, want, n, what):
    z = (found - want) / math.sqrt(want * (1 - want) / n)
    check(abs(z) < 4, f"{what}: {found:.5f}, not {want:.5f}: z = {z:.1f}")


def uniform(u, what):
    """Kolmogorov's distance of numbers that are to be uniform in (0, 1)."""
    u = np.sort(u)
    distance = np.abs(u - (np.arange(len(u)) + 0.5) / len(u)).max() * math.sqrt(len(u))
    check(u[0] > -1e-3 and u[-1] < 1 + 1e-3 and distance < 2.0, f"{what}: {u[0]}, {u[-1]}, distance {distance:.2f}")


def check_gaussian():
    n = 100000
    rayleigh = math.pi / 632.8e-6
    ((start, way, planes), (_, other, _), (shifted, _, again)) = rays(
        ["name: laser, type: beam, waist: 1 mm, wavelength: 632.8 nm",
         f"name: wide, type: beam, waist: 2, divergence: {math.degrees(math.atan(0.1))} deg, at: [0, 0, -100]",
         "name: focused, type: beam, waist: 1, wavelength: 632.8, waist_at: 5 m, at: [0, 0, -5000]"],
        [0.001, 5000, 20000], 3 * n)
    for d, (z, w) in enumerate(((0, 1.0), (5000, 1.41926594831284), (20000, 4.15078948064648))):
        r = np.hypot(planes[d][:, 0], planes[d][:, 1])
        check(abs(w - math.sqrt(1 + (z / rayleigh) ** 2)) < 1e-6, "the width by its formula")
        uniform(1 - np.exp(-2 * r * r / (w * w)), f"power by radius at {z} mm")
        if d == 0:
            for radius, through in ((0.5, 0.393469340287367), (1.0, 0.864664716763387), (1.5, 0.988891003461758)):
                near((r < radius).mean(), through, n, f"through an aperture of {radius} mm")
        if d == 2:
            near((r < 5).mean(), 0.945090819160625, n, "through 5 mm at 20 m")
    tangent = np.hypot(other[:, 0], other[:, 1]) / other[:, 2]
    uniform(1 - np.exp(-2 * tangent ** 2 / 0.01), "directions far away")
    turn = planes[2][:, 0] * way[:, 1] - planes[2][:, 1] * way[:, 0]
    near((turn > 0).mean(), 0.5, n, "rays turn either way")
    w = math.sqrt(1 + (5000 / rayleigh) ** 2)
    uniform(1 - np.exp(-2 * (shifted[:, 0] ** 2 + shifted[:, 1] ** 2) / w ** 2), "5 m before the waist")
    uniform(1 - np.exp(-2 * (again[0][:, 0] ** 2 + again[0][:, 1] ** 2)), "at the waist")


def light(d):
    return 100 * max(d[2], 0) ** 2


def check_areas():
    n = 20000
    pathlib.Path("a.ies").write_text(lamp_files.ies(light, "C", lamp_files.steps(0, 360, 30), lamp_files.steps(0, 90, 2.5)), encoding="ascii")
    disc = "type: area, shape: {disc: 2}"
    found = rays([f"name: fibre, {disc}, na: 0.22", f"name: led, {disc}, distribution: {{cosine_power: 3}}", f"name: spot, {disc}, cone: 20",
                  f"name: table, {disc}, distribution: {{table: {{angle: [0, 30], value: [1, 1]}}}}",
                  f"name: lamp, {disc}, distribution: {{table: a.ies}}, flux: 1 lm, spectrum: {{lines: {{632.8: 1}}}}",
                  "name: point, type: point, distribution: {table: {file: a.ies}}, direction: [1, 0, 0], flux: 1 lm, spectrum: {lines: {632.8: 1}}",
                  "name: mesh, type: area, shape: {mesh: patch}, cosine_power: 3, direction: [0, 1, 0]",
                  "name: plain, type: area, shape: {disc: 2}",
                  "name: hat, type: collimated, shape: {disc: 3}, profile: {gaussian: 2}",
                  "name: ring, type: collimated, shape: {disc: 3}, profile: {radius: [1, 2], value: [1, 1]}"], [], 10 * n)
    fibre, led, spot, table, lamp, point, mesh, plain, hat, ring = found
    uniform((fibre[1][:, 0] ** 2 + fibre[1][:, 1] ** 2) / 0.22 ** 2, "a fibre's end")
    uniform(led[1][:, 2] ** 4, "cos^3")
    uniform(mesh[1][:, 1] ** 4, "cos^3 of a mesh")
    uniform((1 - spot[1][:, 2]) / (1 - math.cos(math.radians(20))), "a cone")
    uniform((1 - table[1][:, 2]) / (1 - math.cos(math.radians(30))), "a table")
    uniform(lamp[1][:, 2] ** 3, "a lamp's file on an area")
    uniform(point[1][:, 0] ** 3, "a lamp's file of a point")
    uniform(plain[1][:, 2] ** 2, "Lambert")
    for of, what in ((fibre, "fibre"), (led, "led"), (plain, "plain")):
        uniform((of[0][:, 0] ** 2 + of[0][:, 1] ** 2) / 4, f"places of {what}")
        uniform(np.arctan2(of[1][:, 1], of[1][:, 0]) / (2 * math.pi) + 0.5, f"azimuths of {what}")
    square = hat[0][:, 0] ** 2 + hat[0][:, 1] ** 2
    uniform((1 - np.exp(-square / 2)) / (1 - math.exp(-4.5)), "a Gaussian over a disc")
    uniform((ring[0][:, 0] ** 2 + ring[0][:, 1] ** 2 - 1) / 3, "a ring")


def check_mistakes():
    for source, said in (("type: beam, waist: 1", "give 'wavelength', by which"), ("type: beam, wavelength: 500", "'waist' is missing"),
                         ("type: beam, waist: 1, wavelength: 500, divergence: 1", "give 'wavelength', by which"),
                         ("type: area, shape: {disc: 1}, na: 1.5", "'na' must be greater than 0 and up to 1"),
                         ("type: area, shape: {disc: 1}, na: 0.2, cone: 3", "give one of 'cone', 'cosine_power', 'na' and 'table'"),
                         ("type: point, distribution: {na: 0.2}", "'na' is of an area"),
                         ("type: collimated, shape: {rectangle: 1}, profile: {gaussian: 1}", "'profile' is of a disc"),
                         ("type: collimated, shape: {disc: 1}, profile: {radius: [2, 3], value: [1, 1]}", "no light within its disc"),
                         ("type: area, shape: {disc: 1}, distribution: {table: none.ies}", "none.ies")):
        pathlib.Path("m.yaml").write_text(HEAD + f"sources: [{{name: s, {source}, medium: air}}]\n", encoding="utf-8")
        told = run("check", "m.yaml", status=3)
        check(said in told, f"{source}: {said}\n{told}")


pathlib.Path("patch.obj").write_text("v 0 0 0\nv 3 0 0\nv 0 3 0\nf 1 2 3\n", encoding="ascii")
check_gaussian()
check_areas()
check_mistakes()
asking.finish()
