#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Light on the surface of objects (raymap irradiance).

A sphere under a slanted collimated beam of irradiance E: a patch between two parallels and two meridians catches
E times the integral of n.s over it, all of it E pi R^2 (shape: rows of cells; mesh: triangles of an octahedron
divided, E n.s each). A box scaled unequally and mirrored: E |n.s| per face. A closed room of Lambertian walls: every
triangle has what the map's own columns say arrives and is absorbed there, values and standard errors, and on the side
that the medium or the way says. Cells over texture coordinates (OBJ, glTF, PLY; charts that repeat) have what the columns
say by barycentric coordinates, and the area that 40,000 points of each triangle say. W at 555 nm are 683 lm. .vtp, .glb and .h5 are read here by what their formats say.
"""
import base64
import csv
import json
import math
import os
import struct
import subprocess
import xml.etree.ElementTree

import h5py
import numpy

from raymap import PROGRAM, Checks, columns, count, drop, many, run, some, trace

checks = Checks()
HEAD = """raymap: 1
units: cm
spectrum: {mode: spectral, wavelengths: [555]}
media: {air: {index: 1}, glass: {index: 1.5}}
"""
LINE = "spectrum: {lines: {555: 1}}, medium: air"


def vtp(path):
    """Points, offsets and cell data of a .vtp, by what VTK says of its files alone."""
    root = xml.etree.ElementTree.parse(path).getroot()
    assert (root.get("byte_order"), root.get("header_type")) == ("LittleEndian", "UInt64")
    piece = root.find("PolyData/Piece")
    found = {}
    for array in piece.iter("DataArray"):
        raw = base64.b64decode(array.text)
        size = int.from_bytes(raw[:8], "little")
        kind = {"Float64": "<f8", "Int64": "<i8"}[array.get("type")]
        found[array.get("Name")] = numpy.frombuffer(raw[8:8 + size], kind)
    assert len(found["points"]) == 3 * int(piece.get("NumberOfPoints"))
    assert len(found["offsets"]) == int(piece.get("NumberOfPolys"))
    found["points"] = found["points"].reshape(-1, 3)[found["connectivity"]]
    return found


def polygons(found):
    return numpy.split(found["points"], found["offsets"][:-1])


def glb(path):
    """Document and arrays of the first mesh of a .glb."""
    with open(path, "rb") as file:
        raw = file.read()
    magic, version, length, n, kind = struct.unpack_from("<5I", raw)
    assert (magic, version, length, kind) == (0x46546C67, 2, len(raw), 0x4E4F534A)
    document = json.loads(raw[20:20 + n])
    body = raw[28 + n:]
    primitive = document["meshes"][0]["primitives"][0]
    arrays = {}
    for name, index in (*primitive["attributes"].items(), ("indices", primitive["indices"])):
        accessor = document["accessors"][index]
        view = document["bufferViews"][accessor["bufferView"]]
        kind = {5126: "<f4", 5123: "<u2", 5125: "<u4"}[accessor["componentType"]]
        width = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        arrays[name] = numpy.frombuffer(body, kind, accessor["count"] * width, view["byteOffset"]).reshape(-1, width)
    return document, arrays


def answer(target, *arguments, ranks=1):
    start = ["mpirun", "-np", str(ranks)] if ranks > 1 else []
    arguments = [*map(str, arguments), *(["--force"] if "-o" in arguments else [])]
    done = subprocess.run([*start, PROGRAM, "irradiance", target, *arguments, "--json"],
                          stdout=subprocess.PIPE, text=True, check=True)
    return json.loads(done.stdout)


def refused(status, text, *arguments):
    done = subprocess.run([PROGRAM, "irradiance", *map(str, arguments)], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True, check=False)
    checks.true(f"{' '.join(map(str, arguments))}: {done.returncode} {done.stderr.strip()}",
                done.returncode == status and text in done.stderr)


# ---- a sphere in a beam, as a shape and as a mesh ----
def octahedron(depth):
    """Corners of the faces of an octahedron divided into 4^depth each, on the unit sphere."""
    axis = numpy.eye(3)
    faces = [(i * axis[0], j * axis[1], k * axis[2]) if i * j * k > 0 else (j * axis[1], i * axis[0], k * axis[2])
             for i in (1, -1) for j in (1, -1) for k in (1, -1)]
    for _ in range(depth):
        split = []
        for a, b, c in faces:
            ab, bc, ca = ((p + q) / numpy.linalg.norm(p + q) for p, q in ((a, b), (b, c), (c, a)))
            split += [(a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca)]
        faces = split
    return numpy.array(faces)


R, E = 2.0, 1000 / (0.05 ** 2 * math.pi)  # cm; 1000 W in a disc of 5 cm radius, W/m2
toward = numpy.array([0.48, 0.6, 0.64])   # the light's way, against it
with open("ball.obj", "w", encoding="ascii") as out:
    faces = octahedron(4)
    for face in faces:
        out.writelines(f"v {x:.9g} {y:.9g} {z:.9g}\n" for x, y, z in face)
    out.writelines(f"f {3 * k + 1} {3 * k + 2} {3 * k + 3}\n" for k in range(len(faces)))
BEAM = f"""sources:
  - {{name: beam, type: collimated, shape: {{disc: 5}}, at: [4.8, 6, 6.4], direction: [-0.48, -0.6, -0.64], flux: 1 kW,
     {LINE}}}
"""
BALL = HEAD + """surfaces: {grey: {type: lambert, reflectance: 0.25}, black: {type: absorber}}
geometries: {ball: {type: sphere, radius: 2}, faceted: {type: mesh, file: ball.obj}}
objects:
  - {name: ball, geometry: %s, %s surface: grey, inside: air, outside: air}
""" + BEAM
target = trace("ball", BALL % ("ball", ""), many(200_000))
told = answer(target, "ball", "-o", "ball.vtp", "-o", "ball.glb", "-o", "ball.h5", "-o", "ball.csv", "-o", "ball.svg")
checks.z("the sphere's flux: E pi R^2", told["flux"]["value"], E * math.pi * (R / 100) ** 2, told["flux"]["standard_error"])
checks.close("its area", told["area_m2"], 4 * math.pi * (R / 100) ** 2, 1e-6)
checks.close("its mean", told["mean"]["value"] * told["area_m2"], told["flux"]["value"], 1e-12)
got = vtp("ball.vtp")
checks.close("the cells together", (got["irradiance"] * got["area"]).sum() * 1e-4, told["flux"]["value"], 1e-9)
checks.close("absorbed", (got["absorbed"] * got["area"]).sum() * 1e-4, told["absorbed"]["value"], 1e-9)
scores, dark = [], 0
for corner, value, error, area in zip(polygons(got), got["irradiance"], got["irradiance_error"], got["area"]):
    lit = corner @ toward / R
    dark += value * (lit.max() < -0.05)
    if lit.min() < 0.2:
        continue
    theta = numpy.arccos(numpy.clip(corner[:, 2] / R, -1, 1))
    off = corner[numpy.hypot(corner[:, 0], corner[:, 1]) > 1e-6 * R]  # a pole has no meridian
    middle = math.atan2(off[:, 1].mean(), off[:, 0].mean())
    phi = (numpy.arctan2(off[:, 1], off[:, 0]) - middle + math.pi) % (2 * math.pi) - math.pi + middle
    a, b, u, v = theta.min(), theta.max(), phi.min(), phi.max()
    both = (b - a) / 2 - (math.sin(2 * b) - math.sin(2 * a)) / 4
    want = R * R * (both * (toward[0] * (math.sin(v) - math.sin(u)) - toward[1] * (math.cos(v) - math.cos(u))) +
                    toward[2] * (v - u) * (math.sin(b) ** 2 - math.sin(a) ** 2) / 2)
    checks.close("a patch's area", area, R * R * (v - u) * (math.cos(a) - math.cos(b)), 2e-5)
    quantum = 1000 / many(200_000) / area * 1e4  # a ray's
    scores.append((value - E * want / area) / math.sqrt(E * want / area * quantum))
    if value > 0:
        checks.close("a patch's error", error, math.sqrt(value * quantum), 1e-3)
scores = numpy.array(scores)
checks.true("nothing on the dark side", dark == 0)
checks.true(f"{len(scores)} patches within 4.2 errors: {abs(scores).max():.2f}", len(scores) > 500 and abs(scores).max() < 4.2)
checks.true(f"as the errors say: rms {scores.std():.3f}", 0.93 < scores.std() < 1.07)
with h5py.File("ball.h5") as file:
    checks.true(".h5 and .vtp", all(numpy.array_equal(file[name], got[name], equal_nan=True) for name in
                                    ("irradiance", "irradiance_error", "relative_error", "absorbed", "area")))
    checks.true(".h5: corners", numpy.array_equal(file["corner"], got["points"]) and
                numpy.array_equal(file["corner_end"], got["offsets"]) and file["irradiance"].attrs["units"] in ("W/m2", b"W/m2"))
with open("ball.csv", encoding="utf-8") as file:
    rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
checks.true(".csv", len(rows) == told["cells"])
for row in rows[::97]:
    checks.close(".csv: value", row["irradiance"], got["irradiance"][int(row["cell"])], 1e-9)
document, arrays = glb("ball.glb")
values, colour = arrays["_VALUE"][:, 0], arrays["COLOR_0"].astype(float)
checks.true(".glb: a value for every corner", numpy.array_equal(values, numpy.repeat(
    got["irradiance"], numpy.diff(got["offsets"], prepend=0)).astype("<f4")))
checks.true(".glb: where", numpy.array_equal(arrays["POSITION"], got["points"].astype("<f4")) and
            abs(document["nodes"][0]["scale"][0] - 0.01) < 1e-12 and document["nodes"][1]["name"] == "ball")
order = numpy.argsort(values)
grey = (colour @ [0.2126, 0.7152, 0.0722, 0])[order]
checks.true(".glb: brighter is more", (numpy.diff(grey) >= -1).all() and grey[-1] > 30 * grey[0] > 0)
checks.true(".glb: colours as they are", document["extensionsUsed"] == ["KHR_materials_unlit"])
with open("ball.svg", encoding="utf-8") as file:
    text = file.read()
checks.true(".svg: the scale", "irradiance, " in text and "W/m²" in text and "ball: irradiance in ball.raymap" in text)
lx = answer(target, "ball", "--quantity", "illuminance", "--unit", "klx")
checks.close("W at 555 nm in lx", lx["mean"]["value"], 0.683 * told["mean"]["value"], 2e-3)
checks.true("lm", (lx["unit"], lx["flux_unit"], lx["quantity"]) == ("klx", "lm", "illuminance"))
checks.close("its error", lx["mean"]["standard_error"] / lx["mean"]["value"],
             told["mean"]["standard_error"] / told["mean"]["value"], 1e-6)
inside = answer(target, "ball", "--side", "back")
checks.true("nothing from inside", inside["flux"]["value"] == 0 and inside["peak"] is None)
run("convert", target, "-o", "compact.raymap", "--encoding", "compact", "--quiet")
for name, ranks in (("compact.raymap", 1), (target, 2)):
    again = answer(name, "ball", "-o", "again.vtp", ranks=ranks)
    with open("again.vtp", "rb") as one, open("ball.vtp", "rb") as other:
        checks.true(f"{name} on {ranks} ranks: the same bits", one.read() == other.read() and again == told)
drop("compact.raymap")
drop(target)

target = trace("faceted", BALL % ("faceted", "scale: [2, 2, -2], at: [1, 0, 0],"), many(100_000))
told = answer(target, "ball", "--cells", "triangles", "-o", "faceted.vtp")
got = vtp("faceted.vtp")
corner = got["points"].reshape(-1, 3, 3)
normal = numpy.cross(corner[:, 1] - corner[:, 0], corner[:, 2] - corner[:, 0]) / 2
checks.true("2,048 triangles, counter-clockwise from outside", len(corner) == told["cells"] == 2048 and
            ((normal * (corner.mean(axis=1) - [1, 0, 0])).sum(axis=1) > 0).all())
want = E * numpy.maximum(normal @ toward, 0) / got["area"]
lit = want > 0.2 * E
scores = (got["irradiance"] - want)[lit] / numpy.sqrt(want * 1000 / many(100_000) / got["area"] * 1e4)[lit]
checks.true(f"E n.s of every triangle: {abs(scores).max():.2f}, rms {scores.std():.3f}",
            abs(scores).max() < 4.5 and 0.93 < scores.std() < 1.07)
checks.true("none on the dark side", not got["irradiance"][want == 0].any())
joined = answer(target, "ball", "--cells", "0.8 cm", "-o", "joined.vtp")
one = vtp("joined.vtp")
checks.true(f"{joined['cells']} cells of 2,048 triangles", 150 < joined["cells"] < 600)
checks.close("joined: as much light", joined["flux"]["value"], told["flux"]["value"], 1e-12)
flux = numpy.bincount(one["cell"].astype(int), one["area"] * one["irradiance"])
parts = numpy.bincount(one["cell"].astype(int), (got["area"] * got["irradiance"]))
checks.true("joined: a cell has what its triangles have", numpy.allclose(flux, parts, rtol=1e-9, atol=1e-12))
drop(target)

# ---- faces of a box, scaled unequally and mirrored, cut into small cells ----
BOX = HEAD + """surfaces: {black: {type: absorber}}
geometries: {cube: {type: box, size: [1, 1, 1]}}
objects:
  - {name: brick, geometry: cube, scale: [1, -2, 3], surface: black, inside: air, outside: air}
""" + BEAM
target = trace("brick", BOX, many(50_000))
for face, area, cosine in (("top", 2, 0.64), ("-y", 3, 0.6), ("+y", 3, 0)):
    told = answer(target, "brick", "--faces", face, "--cells", "2.5 mm")
    checks.close(f"area of {face}", told["area_m2"], area * 1e-4, 1e-6)
    checks.true(f"many cells of {face}", told["cells"] >= area / 0.25 ** 2)
    if cosine:
        checks.z(f"E cos on {face}", told["mean"]["value"], E * cosine, told["mean"]["standard_error"])
    else:
        checks.true(f"none on {face}", told["mean"]["value"] == 0)
refused(3, "no face 'lid'", target, "brick", "--faces", "lid")
drop(target)

# ---- a room: what arrives is what the map's columns say ----
ROOM = HEAD + """surfaces: {wall: {type: lambert, reflectance: 0.6}, clear: {type: fresnel}, sheet: {type: lambert, reflectance: 0.5}}
geometries:
  room: {type: box, size: [60, 40, 30]}
  pane: {type: rectangle, size: [20, 15]}
  ball: {type: sphere, radius: 4}
objects:
  - {name: room, geometry: room, surface: wall, inside: air, outside: air}
  - name: things
    objects:
      - {name: sheet, geometry: pane, at: [5, 0, 0], rotate: [20, 10, 0], surface: sheet, front: air, back: air}
      - {name: ball, geometry: ball, at: [-15, 0, 15], surface: clear, inside: glass, outside: air}
sources:
  - {name: one, type: point, at: [-20, 10, 20], flux: 3 W, %s}
  - {name: two, type: point, at: [20, -5, 25], flux: 2 W, %s}
""" % (LINE, LINE)
target = trace("room", ROOM, 40_000, encoding="plain")
run("irradiance", target, "*", "--cells", "triangles", "-o", "room.h5", "--force")
emitted, source, segments, weight, start = columns(target, "ray/source", "ray/source", "ray/segment_count", "ray/weight", "ray/start")
place, hit, primitive, event, medium, normal = columns(target, "segment/position", "segment/object", "segment/primitive",
                                                       "segment/event", "segment/medium", "segment/normal")
emitted = numpy.bincount(source, minlength=2)
ray = numpy.repeat(numpy.arange(len(segments)), segments)
first = numpy.cumsum(segments.astype(int)) - segments
before = numpy.roll(place, 1, axis=0).astype(float)
before[first] = start
front = ((place - before) * normal).sum(axis=1) < 0
names = json.loads(run("info", target, "--json"))["objects"]
number = {o["name"]: k for k, o in enumerate(names)}
arrives = (event & (1 << 11 | 1 << 12)) == 0
per_ray = numpy.array([3, 2])[source] / emitted[source]


def estimate(chosen, cell, n):
    """Flux in n cells and its standard error, a ray being one sample."""
    total, variance = numpy.zeros(n), numpy.zeros(n)
    for s, flux in enumerate((3, 2)):
        rows = chosen & (source[ray] == s)
        key, times = numpy.unique(ray[rows] * n + cell[rows], return_counts=True)
        w, w2 = numpy.bincount(key % n, times, n), numpy.bincount(key % n, times * times, n)
        total += flux / emitted[s] * w
        variance += (flux / emitted[s]) ** 2 * emitted[s] / (emitted[s] - 1) * (w2 - w * w / emitted[s])
    return total, numpy.sqrt(variance)


with h5py.File("room.h5") as file:
    told = {name: file[name][()] for name in file}
    on = file.attrs["objects"].split("\n") if isinstance(file.attrs["objects"], str) else file.attrs["objects"].decode().split("\n")
walls = told["object"] == on.index("room")
checks.true("12 triangles", walls.sum() == 12 and (told["triangle"][walls] == numpy.arange(12)).all())
for name, chosen in (("irradiance", arrives), ("absorbed", arrives & ((event & 1 << 5) != 0))):
    flux, error = estimate(chosen & (hit == number["room"]), primitive, 12)
    area = told["area"][walls] * 1e-4
    checks.true(f"{name} of every triangle", numpy.allclose(told[name][walls] * area, flux, rtol=1e-9, atol=0))
    checks.true(f"{name}: its error", numpy.allclose(told[f"{name}_error"][walls] * area, error, rtol=1e-6, atol=0))
answer(target, "room", "--cells", "12 cm", "-o", "halved.vtp")
halved = vtp("halved.vtp")
wrong = 0
mine = [arrives & (hit == number["room"]) & (primitive == k) for k in range(12)]
mine = [(place[rows].astype(float), per_ray[ray[rows]]) for rows in mine]
for corner, triangle, value, area in zip(polygons(halved), halved["triangle"], halved["irradiance"], halved["area"]):
    at, each = mine[int(triangle)]
    axes = numpy.stack([corner[1] - corner[0], corner[2] - corner[0]], axis=1)
    share = (at - corner[0]) @ numpy.linalg.pinv(axes).T
    within = (share > -1e-6).all(axis=1) & (share.sum(axis=1) < 1 + 1e-6)
    wrong += abs(value * area * 1e-4 - each[within].sum()) > 2.5 * per_ray.max()
checks.true(f"{wrong} of {len(halved['area'])} halved triangles differ", len(halved["area"]) > 100 and wrong == 0)
longest = max(numpy.linalg.norm(c - numpy.roll(c, 1, axis=0), axis=1).max() for c in polygons(halved))
checks.true("no edge is longer", longest <= 12)
for name, side in (("sheet", "front"), ("sheet", "back"), ("ball", "back"), ("ball", "both")):
    rows = arrives & (hit == number[name])
    if side != "both":  # of glass the medium says it, and near the rim its rounded normal may not
        rows &= (front if name != "ball" else medium == 0) == (side == "front")
    flux, error = estimate(rows, numpy.zeros(len(rows), int), 1)
    got = answer(target, name, "--side", side)
    checks.close(f"{name} from {side}", got["flux"]["value"], flux[0], 1e-12)
    checks.close(f"{name} from {side}: error", got["flux"]["standard_error"], error[0], 1e-6)
both = answer(target, "things", "room", "--where", "source(one)")
checks.true("groups", [o["object"] for o in both["objects"]] == ["room", "sheet", "ball"])
checks.close("absorbed by the walls: as query counts", both["objects"][0]["absorbed"]["value"],
             count(target, "source(one) and ended(absorbed, room)")[0]["flux"]["matched"], 1e-12)

drop(target)

# ---- other shapes: their areas, and every arrival in the cell that has its place ----
SHAPES = HEAD + """surfaces: {grey: {type: lambert, reflectance: 0.5}}
geometries:
  disc: {type: disc, radius: 3, inner: 1}
  dish: {type: conic, curvature: 0.25, conic: -1, aperture: 3}
  tube: {type: cylinder, radius: 2, length: 5}
  cone: {type: cone, radius: 3, radius2: 1, length: 4}
objects:
""" + "".join(f"""  - {{name: {name}, geometry: {name}, at: [{10 * k}, 0, 0], scale: 2, surface: grey, front: air, back: air}}
""" for k, name in enumerate(("disc", "dish", "tube", "cone"))) + """sources:
""" + "".join(f"""  - {{name: s{k}, type: point, at: [{10 * k + 1}, 1, 2], flux: 1 W, {LINE}}}
""" for k in range(4))
target = trace("shapes", SHAPES, 20_000, encoding="plain")
told = answer(target, "disc", "dish", "tube", "cone", "--cells", "14 mm", "-o", "shapes.vtp")
wanted = (math.pi * (9 - 1), math.pi / 6 * 4 * ((16 + 9) ** 1.5 - 64) / 4, 4 * math.pi * 5, math.pi * (3 + 1) * math.hypot(4, 2))
found = vtp("shapes.vtp")
place, hit, event = columns(target, "segment/position", "segment/object", "segment/event")
names = [o["name"] for o in json.loads(run("info", target, "--json"))["objects"]]
whole, told_cell = polygons(found), found["cell"].astype(int)
for k, name in enumerate(("disc", "dish", "tube", "cone")):
    one = [o for o in told["objects"] if o["object"] == name][0]
    checks.close(f"area of the {name}", one["area_m2"] * 1e4, 4 * wanted[k], 1e-5)
    at = place[(hit == names.index(name)) & ((event & (1 << 11 | 1 << 12)) == 0)].astype(float) - [10 * k, 0, 0]
    profile = at[:, 2] if name in ("tube", "cone") else numpy.hypot(at[:, 0], at[:, 1])
    around = numpy.arctan2(at[:, 1], at[:, 0])
    total = 0
    for cell in numpy.flatnonzero(found["object"] == k):
        corner = whole[cell] - [10 * k, 0, 0]
        along = corner[:, 2] if name in ("tube", "cone") else numpy.hypot(corner[:, 0], corner[:, 1])
        off = corner[numpy.hypot(corner[:, 0], corner[:, 1]) > 1e-6]
        middle = math.atan2(off[:, 1].mean(), off[:, 0].mean())
        turn = numpy.abs((numpy.arctan2(off[:, 1], off[:, 0]) - middle + math.pi) % (2 * math.pi) - math.pi).max()
        here = ((profile > along.min() - 1e-5) & (profile < along.max() + 1e-5) &
                (numpy.abs((around - middle + math.pi) % (2 * math.pi) - math.pi) < turn + 1e-5)).sum()
        count_told = found["irradiance"][cell] * found["area"][cell] * 1e-4 * 5000
        total += abs(here - count_told) > 0.01  # 5,000 rays a watt; a few lie on borders
    checks.true(f"{name}: {total} of {one['cells']} cells differ", one["cells"] > 60 and total < 0.02 * one["cells"])

# ---- cells over texture coordinates: sums over the columns, whatever of the body a cell has ----
def shares(corner, at):
    axes = numpy.stack([corner[1] - corner[0], corner[2] - corner[0]], axis=1)
    two = (at - corner[0]) @ numpy.linalg.pinv(axes).T
    return numpy.concatenate([1 - two.sum(axis=1, keepdims=True), two], axis=1)


UNIT = numpy.array([(0, 0), (1, 0), (1, 1), (0, 1)], float)
quad = [numpy.array([(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)], float)]
quad_uv = [UNIT * 0.8 + 0.1]
boxes, box_uv = [], []  # six charts of a third by a half, outside in front
for k, (axis, sign) in enumerate((a, s) for a in range(3) for s in (1, -1)):
    side = numpy.zeros((4, 3))
    side[:, axis] = sign
    side[:, (axis + 1) % 3] = (2 * UNIT[:, 0] - 1) * sign
    side[:, (axis + 2) % 3] = 2 * UNIT[:, 1] - 1
    boxes.append(side)
    box_uv.append((UNIT * 0.9 + 0.05 + (k % 3, k // 3)) / (3, 2))
stacked_uv = [UNIT * 0.035 + (0.01 + 0.035 * (k % 2), 0.01) for k in range(4)]  # two charts side by side in a cell, each twice
apart_uv = [UNIT * 0.03 + (0.01 + 0.03 * (k % 2), 0.01 + 0.03 * (k // 2)) for k in range(4)]  # four side by side
turned = numpy.array(((math.cos(0.3), -math.sin(0.3)), (math.sin(0.3), math.cos(0.3))))


def write_obj(name, sides, uvs):
    with open(name, "w", encoding="ascii") as file:
        for side in sides:
            file.writelines("v %.9g %.9g %.9g\n" % tuple(p) for p in side)
        for uv in uvs:
            file.writelines("vt %.9g %.9g\n" % tuple(p) for p in uv)
        for at in range(1, 4 * len(sides), 4):
            file.write(f"f {at}/{at} {at + 1}/{at + 1} {at + 2}/{at + 2}\nf {at}/{at} {at + 2}/{at + 2} {at + 3}/{at + 3}\n")


def write_gltf(name, side, uv):
    """Rows of a glTF texture run downwards."""
    data = (side.astype("<f4").tobytes() + numpy.stack([uv[:, 0], 1 - uv[:, 1]], axis=1).astype("<f4").tobytes() +
            numpy.array([0, 1, 2, 0, 2, 3], "<u2").tobytes())
    views = [{"buffer": 0, "byteOffset": o, "byteLength": n} for o, n in ((0, 48), (48, 32), (80, 12))]
    kinds = (("VEC3", 5126, 4), ("VEC2", 5126, 4), ("SCALAR", 5123, 6))
    accessors = [{"bufferView": k, "componentType": c, "count": n, "type": t} for k, (t, c, n) in enumerate(kinds)]
    accessors[0].update(min=side.min(axis=0).tolist(), max=side.max(axis=0).tolist())
    with open(name, "w", encoding="ascii") as file:
        json.dump({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
                   "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2}]}],
                   "accessors": accessors, "bufferViews": views,
                   "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," +
                                base64.b64encode(data).decode()}]}, file)


def write_ply(name, side, uv):
    with open(name, "w", encoding="ascii") as file:
        file.write("ply\nformat ascii 1.0\nelement vertex 4\n" +
                   "".join(f"property float {p}\n" for p in ("x", "y", "z", "s", "t")) +
                   "element face 2\nproperty list uchar int vertex_indices\nend_header\n")
        file.writelines("%.9g %.9g %.9g %.9g %.9g\n" % (*p, *q) for p, q in zip(side, uv))
        file.write("3 0 1 2\n3 0 2 3\n")


write_obj("uv-quad.obj", quad, quad_uv)
write_obj("uv-turned.obj", quad, [UNIT @ turned.T * 2 - 0.3])  # slanted, over several repeats
write_obj("uv-box.obj", boxes, box_uv)
write_obj("uv-stacked.obj", boxes[:4], stacked_uv)
write_obj("uv-apart.obj", boxes[:4], apart_uv)
write_gltf("uv-quad.gltf", quad[0], quad_uv[0])
write_ply("uv-quad.ply", quad[0], quad_uv[0])
BODIES = {"obj": ("uv-quad.obj", quad, quad_uv), "gltf": ("uv-quad.gltf", quad, quad_uv), "ply": ("uv-quad.ply", quad, quad_uv),
          "turned": ("uv-turned.obj", quad, [UNIT @ turned.T * 2 - 0.3]), "box": ("uv-box.obj", boxes, box_uv),
          "stacked": ("uv-stacked.obj", boxes[:4], stacked_uv), "apart": ("uv-apart.obj", boxes[:4], apart_uv)}
UV = HEAD + "surfaces: {grey: {type: lambert, reflectance: 0.5}}\ngeometries:\n" + "".join(
    f"  {name}: {{type: mesh, file: {body[0]}, uv: true}}\n" for name, body in BODIES.items()) + """  plain: {type: mesh, file: uv-quad.obj}
  ball: {type: sphere, radius: 1}
objects:
""" + "".join(f"""  - {{name: {name}, geometry: {name}, at: [{8 * k}, 0, 0], surface: grey, front: air, back: air}}
""" for k, name in enumerate([*BODIES, "plain", "ball"])) + "sources:\n" + "".join(
    f"  - {{name: s{k}, type: point, at: [{8 * k + 0.5}, 0.7, 2.5], flux: 1 W, {LINE}}}\n" for k in range(len(BODIES)))
target = trace("uv", UV, 30_000, encoding="plain")
place, hit, primitive, event, of, before = columns(
    target, "segment/position", "segment/object", "segment/primitive", "segment/event", "ray/segment_count", "ray/weight")
names = [o["name"] for o in json.loads(run("info", target, "--json"))["objects"]]
each = len(BODIES) / 30_000 if len(before) == 30_000 else float("nan")  # W a ray
W, H = 12, 7
for k, (name, (_, sides, uvs)) in some(enumerate(BODIES.items()), 1, 2, 3, 4, 5):
    done = subprocess.run([PROGRAM, "irradiance", target, name, "--uv", f"{W}x{H}", "-o", "uv.h5", "-o", "uv.npy", "-o", "uv.csv",
                           "-o", "uv.vtp", *(("-o", "uv.png") if name == "box" else ()), "--force", "--json"], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True, check=True)
    told = json.loads(done.stdout)
    whole = answer(target, name, "--cells", "triangles")
    checks.close(f"{name}: flux is that of the triangles", told["flux"]["value"], whole["flux"]["value"], 1e-12)
    checks.close(f"{name}: area is that of the triangles", told["area_m2"], whole["area_m2"], 1e-9)
    checks.true(f"{name}: covered twice is told", (told["uv"]["covered_twice"] > 0) == (name in ("turned", "stacked")) ==
                ("are summed" in done.stderr) and (name != "stacked" or told["uv"]["covered_twice"] == 1))
    with h5py.File("uv.h5") as file:
        value, area, absorbed = (file[key][0] for key in ("irradiance_uv", "area_uv", "absorbed_uv"))
        facets = (file["irradiance"][()] * file["area"][()]).sum() * 1e-4
    checks.close(f"{name}: facets together", facets, told["flux"]["value"], 1e-9)
    checks.true(f"{name}: .npy is the same", numpy.array_equal(numpy.load("uv.npy")[0], value, equal_nan=True))
    with open("uv.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if line[0] != "#"))
    checks.true(f"{name}: .csv", len(rows) == told["cells"] == (area > 0).sum() and all(
        abs(float(r["irradiance"]) - value[int(r["row"]), int(r["column"])]) <= 1e-6 * numpy.nanmax(value) for r in rows))
    want, grown = numpy.zeros((H, W)), numpy.zeros((H, W))
    for triangle in range(2 * len(sides)):
        pick = [0, 1, 2] if triangle % 2 == 0 else [0, 2, 3]
        corner, uv = sides[triangle // 2][pick], uvs[triangle // 2][pick]
        at = place[(hit == names.index(name)) & (primitive == triangle) & ((event & (1 << 11 | 1 << 12)) == 0)]
        cell = numpy.floor(shares(corner, at.astype(float) - [8 * k, 0, 0]) @ uv * [W, H]).astype(int) % [W, H]
        numpy.add.at(want, (cell[:, 1], cell[:, 0]), each)
        a, b = (numpy.arange(40_000) * step % 1 for step in (0.7548776662466927, 0.5698402909980532))  # even, on no lattice
        fold = a + b > 1
        a, b = numpy.where(fold, 1 - a, a), numpy.where(fold, 1 - b, b)
        cell = numpy.floor(numpy.stack([1 - a - b, a, b], axis=1) @ uv * [W, H]).astype(int) % [W, H]
        size = numpy.linalg.norm(numpy.cross(corner[1] - corner[0], corner[2] - corner[0])) / 2
        numpy.add.at(grown, (cell[:, 1], cell[:, 0]), size / len(a))
    checks.close(f"{name}: area of cells", abs(area - grown).max() / grown.max(), 0, 0, 1e-2)
    off = abs(numpy.nan_to_num(value) * area * 1e-4 - want)
    checks.true(f"{name}: cells as the columns have it: off by {off.max() / each:.2f} rays, {off.sum() / each:.0f} of "
                f"{want.sum() / each:.0f}", off.max() < 2.5 * each and off.sum() < 2e-3 * want.sum() and want.sum() > 0)
    checks.true(f"{name}: no cell without surface has light", (numpy.isnan(value) == (area == 0)).all())
refused(3, "say `uv: true` in its geometry", target, "plain", "--uv", "8x8")
refused(3, "'ball' is no mesh", target, "ball", "--uv", "8x8")
refused(2, "of one object", target, "obj", "box", "--uv", "8x8", "-o", "a.png")
refused(2, "leave out --cells", target, "obj", "--uv", "8x8", "--cells", "1")
refused(2, "256x256", target, "obj", "--uv", "8")
drop(target)
with open("uv-bad.yaml", "w", encoding="ascii") as out:
    out.write(BALL.replace("file: ball.obj", "file: ball.obj, uv: true") % ("faceted", ""))
done = subprocess.run([PROGRAM, "check", "uv-bad.yaml"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False)
checks.true("a file without them: " + done.stdout.strip(), done.returncode == 3 and "has no texture coordinates" in done.stdout)

# ---- wrong input ----
target = trace("room", ROOM, 100)
refused(3, "did you mean 'room'", target, "rom")
refused(3, "'one' is a source, no object", target, "one")
refused(2, "--cells '-1'", target, "room", "--cells", "-1")
refused(2, "ask for longer --cells", target, "room", "--cells", "1e-9 mm")
refused(2, "--side 'up'", target, "room", "--side", "up")
refused(2, "one of W/m2", target, "room", "--unit", "lx")
refused(3, "--faces are of meshes", target, "ball", "--faces", "0")
refused(2, ".vtp", target, "room", "-o", "room.txt")
refused(2, "--eye", target, "room", "-o", "a.png", "--eye", "up")
checks.true("nothing is left behind", not os.path.exists("a.png"))
drop(target)
checks.finish()
