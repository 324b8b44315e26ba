#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: pictures show what is in the map. Colours of paths, criteria and orders are those of
the legend and count the rays that `query` counts; bodies hide rays; a lens's section is its profile;
glTF and VTK files hold the rays; the same bytes for any number of ranks."""
import base64
import json
import math
import os
import re
import struct
import subprocess
from xml.etree import ElementTree

import numpy
from PIL import Image

PROGRAM = os.environ["RAYMAP"]
LENS = os.path.join(os.environ["SOURCE_DIR"], "examples", "double-gauss", "scene.yaml")
PALETTE = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8a6d00"]
OTHER = "#9a9a9a"
SLOW = int(os.environ.get("RAYMAP_TEST_SCALE", "1")) > 1

HIDING = """
raymap: 1
units: mm
spectrum: {mode: spectral, wavelengths: [500]}
media:
  air: {index: 1}
surfaces:
  black: {type: absorber}
geometries:
  plate: {type: rectangle, size: [40, 40]}
  ground: {type: rectangle, size: [200, 200]}
objects:
  - {name: wall, geometry: plate, surface: black, front: air, back: air}
  - {name: end, geometry: ground, rotate: [0, 90, 0], at: [60, 0, 0], surface: black, front: air, back: air}
  - {name: floor, geometry: ground, rotate: [90, 0, 0], at: [0, -60, 0], surface: black, front: air, back: air}
sources:
  - {name: near, type: rays, flux: 1 W, medium: air, rays: [{origin: [-60, 0, -30], direction: [1, 0, 0]}]}
  - {name: far, type: rays, flux: 3 W, medium: air, rays: [{origin: [-60, 0, 30], direction: [1, 0, 0]}]}
cameras:
  - {name: front, at: [10, 5, -100], look_at: [0, 0, 0], up: [0, 1, 0], fov: 80, resolution: [800, 600]}
  - {name: between, at: [0, 3, -20], direction: [0, 0, 1], fov: 90, resolution: [600, 600]}
  - {name: along, at: [-20, 4, -30], direction: [1, 0, 0], up: [0, 1, 0], fov: 40, resolution: [800, 400]}
"""


def run(*arguments, ranks=1, status=0):
    start = ["mpirun", "-np", str(ranks)] if ranks > 1 else []
    done = subprocess.run([*start, PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                          timeout=240, check=False)
    assert done.returncode == status, (arguments, done.returncode, done.stdout, done.stderr)
    return done.stdout if status == 0 else done.stderr


def count(map_path, criterion):
    return json.loads(run("query", map_path, criterion, "--count", "--json"))["rays"]["matched"]


def pixels(path):
    """[row][column][3] of a PNG file."""
    return numpy.asarray(Image.open(path).convert("RGB")).astype(int)


def is_red(image):
    red, green, blue = numpy.moveaxis(image, 2, 0)
    return (red > 150) & (green < 0.5 * red) & (blue < 0.5 * red)


def paths(svg):
    """(stroke, opacity, d) of every path of a picture."""
    out = []
    for element in ElementTree.parse(svg).iter():
        if element.tag.endswith("path"):
            opacity = element.get("opacity") or element.get("stroke-opacity") or "1"
            out.append((element.get("stroke"), float(opacity), element.get("d")))
    return out


def words(svg):
    return [element.text for element in ElementTree.parse(svg).iter()
            if element.tag.endswith("text") and element.text]


def strokes(svg, ink):
    return sum(stroke == ink for stroke, _, _ in paths(svg))


def test_colours():
    run("trace", LENS, "-o", "lens.raymap", "-n", "20000", "--quiet", "--force")
    n = count("lens.raymap", "registered(sensor)")
    criterion = ["--where", "registered(sensor)", "--limit", n]
    run("draw", "lens.raymap", *criterion, "--color", "order", "-o", "order.svg", "--force")
    legend = {match[2]: int(match[1].replace(",", "")) for word in words("order.svg")
              if (match := re.match(r"([0-9,]+) rays?, .* of flux: (.*)", word))}
    assert sum(legend.values()) == n > 500, (legend, n)
    run("query", "lens.raymap", "registered(sensor)", "-o", "rays.json", "--force")
    with open("rays.json", encoding="utf8") as file:
        rays = json.load(file)
    assert len(rays) == n
    own = {}
    for ray in rays: # the black paint scatters, all else makes ghosts
        before = ray["steps"][:next(r["step"] for r in ray["registrations"] if r["registered"])]
        scattered = any("reflect_diffuse" in step["events"] for step in before)
        ghost = sum("reflect_specular" in step["events"] for step in before)
        name = "scattered" if scattered else (f"ghost order {min(ghost, 4)}" + (
            ", direct light" if ghost == 0 else " and above" if ghost >= 4 else ""))
        own[name] = own.get(name, 0) + 1
    assert own == legend, (own, legend)

    run("draw", "lens.raymap", "--where", "source(sun)", "--where", "registered(sensor)", "--limit",
        20000, "-o", "criteria.svg", "--force", "--json")
    legend = {match[2]: int(match[1].replace(",", "")) for word in words("criteria.svg")
              if (match := re.match(r"([0-9,]+) rays?, .* of flux: (.*)", word))}
    assert legend == {"source(sun)": count("lens.raymap", "source(sun)"),
                      "registered(sensor)": count("lens.raymap",
                                                  "registered(sensor) and not source(sun)")}, legend
    assert strokes("criteria.svg", PALETTE[0]) >= legend["source(sun)"]
    assert strokes("criteria.svg", OTHER) == 0

    run("draw", "lens.raymap", *criterion, "--color", "path", "-o", "path.svg", "--force")
    rows = [word for word in words("path.svg") if " of flux: " in word]
    assert 2 <= len(rows) <= 8, rows
    assert strokes("path.svg", PALETTE[0]) > strokes("path.svg", PALETTE[6]) > 0

    # Where most paths have a ray each they are told apart more coarsely, unless --by says how.
    def singles(*by):
        run("draw", "lens.raymap", "--where", "registered(sensor where ghost_order >= 1)", "--color",
            "path", *by, "-o", "ghosts.svg", "--force")
        return (sum(word.startswith("1 ray, ") for word in words("ghosts.svg")),
                any("equal steps in a row count as one" in word for word in words("ghosts.svg")))

    objects, own = singles("--by", "object"), singles()
    assert not objects[1] and own[1]
    assert own[0] <= objects[0] <= 7, (own, objects)

    def mixtures(where):
        run("draw", "lens.raymap", "--where", where, "-o", "mixed.svg", "--force")
        return [word for word in words("mixed.svg") if word.startswith("several wavelengths")]

    assert mixtures("source(sun)") == ["several wavelengths"]
    assert sorted(mixtures("all")) == ["several wavelengths of star", "several wavelengths of sun"]

    # A section through the barrel alone has no glass in its legend.
    run("draw", "lens.raymap", "--view", "xy", "--cut", 100, "-o", "cut.svg", "--force")
    assert "other surface" in words("cut.svg") and "refracting surface" not in words("cut.svg")


def test_opacity():
    """A ray of less flux is fainter; --opacity sets that of the strongest."""
    run("draw", "hiding.raymap", "--view", "xy", "--opacity", "0.9", "-o", "flux.svg", "--force")
    faint, strong = sorted({opacity for stroke, opacity, _ in paths("flux.svg")
                            if opacity < 1 and stroke})
    assert math.isclose(strong, 0.9, abs_tol=0.01) and 0.3 < faint / strong < 0.8, (faint, strong)


def test_covered_criterion():
    """A criterion all of whose rays match an earlier one stands in the legend, with no ray."""
    run("draw", "lens.raymap", "--where", "registered(sensor)", "--where",
        "registered(sensor) and segments > 3", "--color", "criterion", "-o", "two.svg", "--force")
    told = [line for line in words("two.svg") if " ray" in line and ": registered(" in line]
    n = count("lens.raymap", "registered(sensor) and segments > 3")
    assert len(told) == 2 and told[1].startswith(
        f"0 of {n:,} matching rays: registered(sensor) and"), told


def test_shared_picture():
    """A rare criterion is drawn whole, the others share what it leaves; the legend says of how
    many, and no flux, of which the picture has no fair sample."""
    asked = ["ray == 19999", "source(star) and ray < 19999", "segments > 99999",
             "source(sun) and ray < 19999"]
    wheres = [word for text in asked for word in ("--where", text)]
    said = [json.loads(run("draw", "lens.raymap", *wheres, "--color", "criterion", "-o", "two.svg",
                           "--limit", 9, "--force", "--json", ranks=ranks)) for ranks in (1, 3)]
    n = [count("lens.raymap", text) for text in asked]
    assert said[0] == said[1] and said[0]["rays"] == {"matched": sum(n), "drawn": 9}, said
    told = [line for line in words("two.svg") if " ray" in line and ": " in line and
            not line.startswith("rays: ")]
    assert told == [f"1 ray: {asked[0]}", f"4 of {n[1]:,} matching rays: {asked[1]}",
                    f"0 rays: {asked[2]}", f"4 of {n[3]:,} matching rays: {asked[3]}"], told
    assert any("smallest ids of each criterion" in line for line in words("two.svg"))
    run("draw", "lens.raymap", *wheres, "--color", "criterion", "-o", "all.svg", "--limit", sum(n),
        "--force")
    assert any(line.endswith(f"% of flux: {asked[1]}") for line in words("all.svg"))


def test_depth():
    """Seen along +z, the wall hides part of the ray behind it, not of the one before."""
    run("draw", "hiding.raymap", "--eye=0,0", "--opacity", "1", "-o", "depth.svg", "--force")
    told = [(opacity, [[tuple(map(float, point)) for point in
                        re.findall(r"(-?[0-9.]+)[ ,](-?[0-9.]+)", run)]
                       for run in d.split("M")[1:]])
            for stroke, opacity, d in paths("depth.svg")
            if stroke and stroke not in ("#0f766e", "#222222")]
    hidden = [runs for opacity, runs in told if opacity < 0.25]
    whole = [runs for opacity, runs in told if 0.25 < opacity and len(runs) == 1]
    parted = [runs for opacity, runs in told if 0.25 < opacity and len(runs) == 2]
    assert len(hidden) == len(parted) == 1 and len(hidden[0]) == 1, told
    (x0, y0), (x1, y1) = hidden[0][0][0], hidden[0][0][-1]
    assert abs(math.dist((x0, y0), (x1, y1)) / scale_of("depth.svg") - 40) < 1, hidden
    assert whole, told


def test_pixels():
    """A black box in the middle of the picture is drawn in grey, paper around it is white."""
    run("draw", "hiding.raymap", "--where", "segments > 1000", "--eye=0,20", "-o", "box.png",
        "--force")
    image = pixels("box.png")
    assert ((image == 255).all(2).mean(1) > 0.5).any(), "nothing is white"
    red, green, blue = numpy.moveaxis(image[:, 200:-200], 2, 0)
    grey = ((150 < red) & (red < 250) & (abs(red - green) < 12) & (abs(green - blue) < 14)).sum()
    assert grey > 20000, grey

    # A picture whose size is no whole number of pixels has white edges, too.
    run("report", "lens.raymap", "--energy", "--where", "source(star)", "-o", "edge.png", "--force")
    assert (pixels("edge.png")[0] == 255).all(), "the edge is grey"


def test_profile():
    """The first surface of the lens is a sphere of its radius in the section."""
    with open(LENS, encoding="utf8") as file:
        text = file.read()
    run("draw", "lens.raymap", "--where", "segments > 1000", "--view", "yz", "-o", "section.svg",
        "--force")
    assert {"lens", "barrel", "cover"} <= set(words("section.svg")), "parts have no names"
    radius = 1 / float(re.search(r"curvature: *([0-9.]+)", text)[1])
    best = math.inf
    for _, _, d in paths("section.svg"):
        point = [(float(x), float(y)) for x, y in
                 re.findall(r"(-?[0-9.]+)[ ,](-?[0-9.]+)", d or "")]
        if len(point) < 12:
            continue
        for k in range(0, len(point) - 10, 2):
            (ax, ay), (bx, by), (cx, cy) = point[k], point[k + 5], point[k + 10]
            cross = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
            if abs(cross) < 1.0:
                continue
            r = math.dist(point[k], point[k + 5]) * math.dist(point[k + 5], point[k + 10]) * \
                math.dist(point[k + 10], point[k]) / (2 * abs(cross))
            best = min(best, abs(r / scale_of("section.svg") / radius - 1))
    assert best < 0.02, (best, radius)


def scale_of(svg):
    """Pixels per unit, by the scale bar: its two ends and its text."""
    label = next(word for word in words(svg) if re.fullmatch(r"[0-9.e+-]+ mm", word))
    for _, _, d in paths(svg):
        runs = [re.findall(r"(-?[0-9.]+)[ ,](-?[0-9.]+)", run) for run in (d or "").split("M")[1:]]
        if [len(run) for run in runs] == [2, 2, 2]:
            (x0, y0), (x1, y1) = runs[1]
            if y0 == y1 and runs[0][0][0] == runs[0][1][0] == x0 and runs[2][0][0] == x1:
                return (float(x1) - float(x0)) / float(label.split()[0])
    raise AssertionError("no scale bar")


def points_of(d):
    return [(float(x), float(y)) for x, y in re.findall(r"(-?[0-9.]+)[ ,](-?[0-9.]+)", d)]


def seen_from(at, ahead, up, fov, resolution, point):
    """Pixel of the picture that `draw --camera` makes, where the camera sees the point."""
    def normal(v):
        return [c / math.hypot(*v) for c in v]

    def cross(a, b):
        return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]

    def dot(a, b):
        return sum(x * y for x, y in zip(a, b))
    ahead = normal(ahead)
    right = normal(cross(ahead, up))
    above = cross(right, ahead)
    height = min(660, 1040 * resolution[1] / resolution[0])
    width, slope = max(round(height * resolution[0] / resolution[1]), 620), math.tan(math.radians(fov / 2))
    away = [p - a for p, a in zip(point, at)]
    scale = height / 2 / slope / dot(away, ahead)
    return 24 + width / 2 + scale * dot(away, right), 84 + height / 2 - scale * dot(away, above)


def test_camera():
    """A camera's picture is in perspective, with what is behind it cut off and what bodies hide
    faint."""
    ends = {z: [(-60, 0, z), (60, 0, z)] for z in (-30, 30)}

    def drawn(name):
        run("draw", "hiding.raymap", "--camera", name, "-o", "seen.svg", "--force")
        assert not any(re.fullmatch(r"[0-9.e+-]+ mm", word) for word in words("seen.svg")), "a scale"
        assert any(f"seen by camera {name}" in word for word in words("seen.svg"))
        return [(opacity, points_of(d)) for stroke, opacity, d in paths("seen.svg")
                if stroke not in ("#c2410c", "#e3b7a4", "#0f766e", "#333333") and opacity < 1]

    def has(lines, point, within=0.2):
        return any(math.dist(p, point) < within for _, line in lines for p in line)

    lines = drawn("front")
    camera = ([10, 5, -100], [-10, -5, 100], [0, 1, 0], 80, [800, 600])
    for z in (-30, 30):
        for end in ends[z]:
            assert has(lines, seen_from(*camera, end)), (z, end, lines)
    faint = min(opacity for opacity, _ in lines)
    hidden = [p for opacity, line in lines if opacity == faint for p in line]
    assert faint < 0.3 * max(opacity for opacity, _ in lines)
    for x in (-20, 20): # edges of the wall at z = 0 over the ray at z = 30
        edge = seen_from(*camera, (x, 5 - 5 / 1.3, 0))
        assert any(abs(p[0] - edge[0]) < 2.5 for p in hidden), (edge, hidden)

    lines = drawn("between")
    camera = ([0, 3, -20], [0, 0, 1], [0, 1, 0], 90, [600, 600])
    height = seen_from(*camera, (20, 0, 30))[1]
    assert lines and all(abs(p[1] - height) < 0.2 for _, line in lines for p in line), "one behind is drawn"

    lines = drawn("along")
    camera = ([-20, 4, -30], [1, 0, 0], [0, 1, 0], 40, [800, 400])
    assert has(lines, seen_from(*camera, (60, 0, -30))), lines
    x, y = zip(*[p for opacity, line in lines for p in line])
    assert max(x) < 24 + 1040 * 1.06 and max(y) > 84 + 500 and max(y) < 84 + 520 * 1.06, (max(x), max(y))

    assert "no camera named 'frnt' in hiding.raymap; did you mean 'front'?" in run(
        "draw", "hiding.raymap", "--camera", "frnt", "-o", "x.svg", status=3)
    assert "lens.raymap has no camera" in run("draw", "lens.raymap", "--camera", "a", "-o", "x.svg", status=3)


def test_leaving():
    """What leaves the scene goes on to the edge of the picture, in every view."""
    for view in ["yz", "3d"] if SLOW else ["yz"]:
        run("draw", "lens.raymap", "--where", "ended(left)", "--limit", 40, "--view", view, "-o",
            "left.svg", "--force")
        x, y, width, height = next(
            [float(e.get(key)) for key in ("x", "y", "width", "height")]
            for e in ElementTree.parse("left.svg").iter() if e.get("stroke") == "#b0b0b0")
        outside = [p for _, opacity, d in paths("left.svg") if opacity < 1
                   for p in points_of(d)[-1:]
                   if not (x <= p[0] <= x + width and y <= p[1] <= y + height)]
        assert len(outside) >= 40, (view, len(outside))


def test_detector_faces():
    """A detector on a curved surface is drawn on it, as far as its size goes."""
    with open("eye.yaml", "w", encoding="utf8") as file:
        file.write("""
raymap: 1
units: mm
spectrum: {mode: spectral, wavelengths: [500]}
media: {air: {index: 1}}
surfaces: {black: {type: absorber}}
geometries: {ball: {type: sphere, radius: 20}}
objects: [{name: eye, geometry: ball, surface: black, front: air, back: air}]
detectors: [{name: retina, type: plane, on: eye, cells: 8, size: 20, direction: [0, 0, -1]}]
sources: [{name: led, type: point, flux: 1 W, medium: air, at: [0, 0, -40]}]
""")
    for view in ["yz", "3d"]:
        run("draw", "eye.yaml", "--view", view, "-o", "eye.svg", "--force")
        point = [p for stroke, _, d in paths("eye.svg") if stroke == "#0f766e" for p in points_of(d)]
        size = [(max(axis) - min(axis)) / scale_of("eye.svg") for axis in zip(*point)]
        assert "retina" in words("eye.svg")
        assert len(point) > 40, len(point)
        if view == "yz":
            assert abs(size[0] - 40) < 0.2 and abs(size[1] - 20) < 0.2, size


def test_upright():
    """Views of solids and sections have upwards what the scene's first camera has."""
    with open("hiding.yaml", encoding="utf8") as file:
        text = file.read()
    for at, look, up, axis in (([0, -90, 40], [0, 0, 0], "[0, 0, 1]", "z"), ([10, 5, -100], [0, 0, 0], "[0, 1, 0]", "y")):
        with open("upright.yaml", "w", encoding="utf8") as file:
            file.write(text[:text.index("cameras:")] +
                       f"cameras: [{{name: c, at: {at}, look_at: {look}, up: {up}}}]\n")
        for view in ("3d", "yz"):
            run("draw", "upright.yaml", "--view", view, "-o", "upright.svg", "--force")
            height = {e.text: float(e.get("y")) for e in ElementTree.parse("upright.svg").iter()
                      if e.tag.endswith("text") and e.text in ("x", "y", "z")}
            assert min(height, key=height.get) == axis, (view, axis, height)


SPHERE = """
raymap: 1
spectrum: {wavelengths: [550]}
media: {air: {index: 1}}
surfaces: {white: {type: lambert, reflectance: 0.999}}
geometries: {ball: {type: sphere, radius: 10}}
objects: [{name: ball, geometry: ball, surface: white, inside: air, outside: air}]
sources: [{name: lamp, type: point, flux: 1 W}]
"""


def test_long_rays():
    """Hundreds of legs of a ray are many short paths: one long one would take a renderer with the
    square of its length. Each leg is drawn once."""
    with open("sphere.yaml", "w", encoding="utf-8") as file:
        file.write(SPHERE)
    run("trace", "sphere.yaml", "-o", "sphere.raymap", "-n", 3, "--quiet", "--force")
    run("draw", "sphere.raymap", "-o", "sphere.svg", "--force", "--quiet")
    legs = json.loads(run("info", "sphere.raymap", "--json"))["segments"]
    points = [d.count("M") + d.count("L") for _, opacity, d in paths("sphere.svg")
              if opacity < 1]
    assert legs > 300 and max(points) <= 32, (legs, max(points))
    assert sum(n - 1 for n in points) == legs, (sum(n - 1 for n in points), legs)


def glb(path):
    with open(path, "rb") as file:
        data = file.read()
    magic, version, total = struct.unpack("<4sII", data[:12])
    assert (magic, version, total) == (b"glTF", 2, len(data))
    size, kind = struct.unpack("<I4s", data[12:20])
    assert kind == b"JSON" and size % 4 == 0
    scene = json.loads(data[20:20 + size])
    size_bin, kind = struct.unpack("<I4s", data[20 + size:28 + size])
    assert kind == b"BIN\0" and scene["buffers"] == [{"byteLength": size_bin}]
    return scene, data[28 + size:]


def test_gltf():
    n = 50
    run("draw", "lens.raymap", "--where", "registered(sensor)", "--limit", n, "--color", "order",
        "-o", "lens.glb", "--force")
    scene, data = glb("lens.glb")
    names = [node["name"] for node in scene["nodes"]]
    assert "lens.1" in names and scene["nodes"][0]["scale"] == [0.001] * 3, names
    lines = 0
    for mesh in scene["meshes"]:
        primitive = mesh["primitives"][0]
        accessor = scene["accessors"][primitive["attributes"]["POSITION"]]
        view = scene["bufferViews"][accessor["bufferView"]]
        assert view["byteLength"] == 12 * accessor["count"]
        points = struct.unpack_from(f"<{3 * accessor['count']}f", data, view["byteOffset"])
        for k in range(3):
            assert min(points[k::3]) == struct.unpack("f", struct.pack("f", accessor["min"][k]))[0]
            assert max(points[k::3]) == struct.unpack("f", struct.pack("f", accessor["max"][k]))[0]
        if primitive.get("mode") == 1:
            lines += accessor["count"] // 2
            continue
        corners = scene["accessors"][primitive["indices"]]
        view = scene["bufferViews"][corners["bufferView"]]
        index = struct.unpack_from(f"<{corners['count']}I", data, view["byteOffset"])
        assert max(index) < accessor["count"] and corners["count"] % 3 == 0
    run("query", "lens.raymap", "registered(sensor)", "--limit", n, "-o", "rays.json", "--force")
    with open("rays.json", encoding="utf8") as file:
        rays = json.load(file)
    assert lines == sum(len(ray["steps"]) for ray in rays), lines
    run("draw", "lens.raymap", "--where", "registered(sensor)", "--limit", n, "--color", "order",
        "-o", "lens.gltf", "--force")
    with open("lens.gltf", encoding="utf8") as file:
        text = json.load(file)
    head, packed = text["buffers"][0].pop("uri").split(",")
    assert head == "data:application/octet-stream;base64" and text == scene
    assert base64.b64decode(packed, validate=True) == data


COLOURS = """
raymap: 1
units: mm
spectrum: {mode: rgb}
media: {air: {index: 1}}
surfaces:
  red: {type: lambert, reflectance: {rgb: [0.8, 0.05, 0.05]}}
  grey: {type: lambert, reflectance: 0.4}
  metal: {type: mirror, metal: {n: 0.5, k: 3}}
  rough: {type: mirror, metal: {n: 0.5, k: 3}, scatter: {model: ggx, alpha: 0.2}}
geometries: {ball: {type: sphere, radius: 5}}
objects:
  - {name: a, geometry: ball, surface: red, front: air, back: air}
  - {name: b, geometry: ball, at: [20, 0, 0], surface: grey, front: air, back: air}
  - {name: c, geometry: ball, at: [40, 0, 0], surface: red, front: air, back: air}
  - {name: d, geometry: ball, at: [60, 0, 0], surface: metal, front: air, back: air}
  - {name: e, geometry: ball, at: [80, 0, 0], surface: rough, front: air, back: air}
sources: [{name: s, type: collimated, shape: {disc: 1}, at: [0, 0, -20], flux: 1 W, medium: air}]
"""


def test_object_colours():
    """Bodies have the colours of what they throw back, in every format."""
    with open("colours.yaml", "w", encoding="utf8") as file:
        file.write(COLOURS)
    run("trace", "colours.yaml", "-o", "colours.raymap", "-n", 2, "--quiet", "--force")
    mirror = ((0.5 - 1) ** 2 + 9) / ((0.5 + 1) ** 2 + 9)
    wanted = {"red": [0.8, 0.05, 0.05], "grey": [0.4] * 3, "metal": [mirror] * 3, "rough": [mirror] * 3}
    run("draw", "colours.raymap", "--limit", 1, "-o", "colours.gltf", "--force")
    with open("colours.gltf", encoding="utf8") as file:
        scene = json.load(file)
    named = {m["name"]: m["pbrMetallicRoughness"] for m in scene["materials"]}
    for name, colour in wanted.items():
        assert all(abs(a - b) < 1e-6 for a, b in zip(named[name]["baseColorFactor"], colour)), (name, named[name])
        assert named[name]["metallicFactor"] == (name in ("metal", "rough"))
    mesh = {node["name"]: node["mesh"] for node in scene["nodes"] if "mesh" in node}
    assert mesh["a"] == mesh["c"] and len({mesh[k] for k in "abde"}) == 4, mesh
    run("draw", "colours.raymap", "--limit", 1, "-o", "colours.html", "--force")
    with open("colours.html", encoding="utf8") as file:
        albedo = re.findall(r'"albedo": ?\[([^\]]*)\]', file.read())
    for got, name in zip(albedo, ("red", "grey", "red", "metal", "rough")):
        assert all(abs(float(a) - b) < 1e-6 for a, b in zip(got.split(","), wanted[name])), (name, got)
    assert len(albedo) == 5
    run("draw", "colours.raymap", "--limit", 1, "--view", "xz", "-o", "colours.svg", "--force")
    svg = ElementTree.parse("colours.svg")
    inks = {element.get("stroke") for element in svg.iter() if element.get("stroke")}
    red = [ink for ink in inks if int(ink[1:3], 16) > 180 and int(ink[3:5], 16) < 90 and int(ink[5:7], 16) < 90]
    assert "#454545" in inks and red, inks
    assert "other surface, each in its colour" in words("colours.svg")
    run("draw", "colours.raymap", "--limit", 1, "--view", "3d", "-o", "colours.png", "--force")
    reds = is_red(pixels("colours.png")).sum()
    assert reds > 2000, reds
    # Without light, and nothing within, a body has all its walls: its red lid is seen from above.
    with open("lone.yaml", "w", encoding="utf8") as file:
        file.write("""raymap: 1
surfaces: {red: {type: lambert, reflectance: {rgb: [0.8, 0.05, 0.05]}}, black: {type: absorber}}
geometries: {block: {type: box, size: [1, 1, 1]}}
objects: [{name: block, geometry: block, surface: black, faces: [{faces: top, surface: red}]}]
background: {radiance: 1, trace: false}
cameras: [{name: c, at: [3, -5, 4], look_at: [0, 0, 0], fov: 30, resolution: [40, 30]}]
""")
    run("draw", "lone.yaml", "-o", "lone.png", "--force")
    reds = is_red(pixels("lone.png")).sum()
    assert reds > 2000, reds


def test_polydata():
    run("draw", "lens.raymap", "--where", "registered(sensor)", "--limit", 40, "--color", "order",
        "-o", "lens.vtp", "--force")
    root = ElementTree.parse("lens.vtp").getroot()
    cells = {array.get("Name") for array in root.iterfind(".//CellData/DataArray")}
    points = {array.get("Name") for array in root.iterfind(".//PointData/DataArray")}
    assert {"group", "flux", "path_length", "optical_path", "wavelength"} <= cells, cells
    assert {"event", "object", "primitive", "normal", "medium"} <= points, points
    assert root.find(".//FieldData/Array[@Name='groups']") is not None


def test_ranks():
    told = []
    for ranks in (1, 4) if SLOW else (1, 2):
        run("draw", "hiding.raymap", "--camera", "along", "-o", "a.png", "--force", ranks=ranks)
        with open("a.png", "rb") as file:
            told.append(file.read())
    assert told[0] == told[1]
    for name in ("a.svg", "a.glb", "a.vtp")[0 if SLOW else 1:]:
        told = []
        for ranks in (1, 3):
            run("draw", "lens.raymap", "--where", "registered(sensor)", "--color", "path",
                "--view", "3d", "-o", name, "--force", ranks=ranks)
            with open(name, "rb") as file:
                told.append(file.read())
        assert told[0] == told[1], name


def test_mistakes():
    for options, word in (
            (["--color", "pink"], "natural, path, criterion or order"),
            (["--color", "criterion"], "--where"),
            (["--opacity", "2"], "greater than 0 and at most 1"),
            (["--eye", "north"], "AZIMUTH,ELEVATION"),
            (["--eye", "1,2", "--view", "xy"], "3d"),
            (["--cut", "3", "--view", "3d"], "section"),
            (["--camera", "front", "--view", "3d"], "leave out --view"),
            (["--color", "path", "--where", "all", "--where", "all"], "several --where")):
        assert word in run("draw", "lens.raymap", "-o", "bad.svg", *options, status=2), options
    assert not os.path.exists("bad.svg")
    for k, name in enumerate(("none.svg", "none.glb", "none.vtp", "none.png")):
        for colour in ("path", "order", "natural") if SLOW else (("path", "order", "natural")[k % 3],):
            run("draw", "lens.raymap", "--where", "segments > 1000", "--color", colour, "-o", name,
                "--force")


with open("hiding.yaml", "w", encoding="utf8") as scene_file:
    scene_file.write(HIDING)
run("trace", "hiding.yaml", "-o", "hiding.raymap", "-n", "2", "--quiet", "--force")
test_colours()
test_opacity()
test_covered_criterion()
test_shared_picture()
test_depth()
test_pixels()
test_profile()
test_camera()
test_leaving()
test_detector_faces()
test_upright()
test_gltf()
test_object_colours()
test_polydata()
test_long_rays()
test_ranks()
test_mistakes()
