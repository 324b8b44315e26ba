# SPDX-License-Identifier: MIT
"""The promise: what `check` says of scatter models is what a reader of docs/scene.md works out from the parameters; measured
tables are read the right way around, travel with the map, and are refused with the line where they are wrong.

Klems matrices here are made: every patch of every block has a number of its own, so that a reader which takes lines for columns,
front for back or one azimuth for another differs.
"""
import base64
import json
import math
import os
import random
import re
import shutil
import struct
import subprocess

from asking import told_of  # knows where the package is
import raymap.serve

PROGRAM = os.environ["RAYMAP"]
failures = []

SCENE = """raymap: 1
units: mm
spectrum: {wavelengths: [%s]}
media: {air: {index: 1}, glass: {index: 1.5168}}
surfaces: {face: %s}
geometries: {plate: {type: rectangle, size: [1000, 1000]}}
objects: [{name: plate, geometry: plate, surface: face, front: air, back: %s}]
sources: [%s]
"""
BEAM = "{name: s%d, type: rays, flux: 1 W, medium: air, rays: [{origin: [%r, %r, %r], direction: [%r, %r, %r]}]}"


def beam(k, theta, phi, front=True):
    """Light that travels towards azimuth phi, theta from the normal."""
    s, c = math.sin(math.radians(theta)), math.cos(math.radians(theta))
    x, y, z = s * math.cos(math.radians(phi)), s * math.sin(math.radians(phi)), -c if front else c
    return BEAM % (k, -x, -y, -z, x, y, z)


def run(*arguments):
    return subprocess.run([PROGRAM, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)


def write(name, text):
    with open(name, "w", encoding="utf-8") as file:
        file.write(text)
    return name


def scene(surface, nm="587.56", back="air", sources=beam(0, 0, 0)):
    return write("scene.yaml", SCENE % (nm, surface, back, sources))


def fail(what):
    failures.append(what)
    print("FAIL " + what)


def close(what, got, want, within):
    if not (got is not None and abs(got - want) <= within):
        fail(f"{what}: {got}, not {want}")


def told(path, **keys):
    with open(path, encoding="utf-8") as file:
        return told_of(SERVER, file.read(), **keys)


def checked(path, surface="face"):
    its, said = told(path, surface=surface)
    if its["errors"]:
        fail(f"check: {said}")
        return None
    return its["surface"]


def refused(path, complaint, name="", surface=""):
    its, said = told(path)
    if not its["errors"] or complaint not in said or name not in said:
        fail(f"{surface}: '{complaint}' expected: {said[-600:]}")


# ---- what check prints ----

def check_numbers():
    tis = {0: 1.5774e-3, 30: 1.4875e-3, 60: 1.2188e-3, 80: 9.460e-4}
    its = checked(scene("{type: mirror, reflectance: 0.95, scatter: {model: harvey, b0: 0.13947, l: 0.01, s: -1.5}}"))
    by = its["sides"][0]["by_angle"]
    for angle, want in tis.items():
        k = by["angle"].index(angle)
        close(f"TIS at {angle}", by["reflect_diffuse"][k], want, 2e-7)
        close(f"specular at {angle}", by["reflect_specular"][k], 0.95 - want, 2e-7)
    if its["scatter"] != {"reflect": "harvey", "transmit": None, "reciprocal": True, "asymmetry": {"reflect": None, "transmit": None}}:
        fail(f"scatter: {its['scatter']}")
    both = checked(scene("{type: mirror, reflectance: 0.95, scatter: {model: harvey, b0: 0.13947, l: 0.01, s: -1.5}, contamination: {level: 100}}"))
    if both["scatter"]["reciprocal"] or both["scatter"]["reflect"] != "harvey and contamination":
        fail(f"two models: {both['scatter']}")
    dust = "{type: mirror, reflectance: 0.95, contamination: {level: 50, n: %s, k: %s}}"
    coloured = checked(scene(dust % ("{wavelength: [500, 600], value: [1.4, 1.6]}", "{wavelength: [500, 600], value: [0.1, 0]}"), "500, 600"))
    for nm, n, k in (("500", 1.4, 0.1), ("600", 1.6, 0)):
        alone = checked(scene(dust % (n, k), nm))["sides"][0]["by_angle"]
        at = coloured["sides"][0]["by_wavelength"]
        for key in ("reflect_specular", "reflect_diffuse", "absorb"):
            close(f"particles at {nm} nm, {key}", at[key][at["wavelength"].index(float(nm))], alone[key][0], 1e-5)
    bsdf = its["sides"][0]["bsdf"][1]
    k = bsdf["angle"].index(50)
    x = math.sin(math.radians(50)) - 0.5
    close("BSDF from 30 to 50 degrees", bsdf["reflected"][k], 0.13947 * (1 + (x / 0.01) ** 2) ** -0.75, 1e-9)
    # scaled: l with the wavelength, b0 with its fourth power
    half = checked(scene("{type: mirror, reflectance: 1, scatter: {model: harvey, b0: 0.13947, l: 0.01, s: -1.5, reference: 500}}", "1000"))
    bsdf = half["sides"][0]["bsdf"][0]
    close("scaled", bsdf["reflected"][bsdf["angle"].index(0)], 0.13947 / 16, 1e-12)
    lens = checked(scene("{type: fresnel, scatter: {model: harvey, roughness: 2 nm, correlation: 10 um}}", back="glass"))
    by, r = lens["sides"][0]["by_angle"], (0.5168 / 2.5168) ** 2
    close("rough lens, reflected", by["reflect_diffuse"][0] / r, -math.expm1(-1.8297e-3), 1e-7)
    close("rough lens, refracted", by["transmit_diffuse"][0] / (1 - r), 1.2217e-4, 2e-8)
    for side in lens["sides"]:
        for k in range(len(side["by_angle"]["angle"])):
            whole = sum(side["by_angle"][name][k] for name in
                        ("reflect_specular", "reflect_diffuse", "transmit_specular", "transmit_diffuse", "absorb"))
            close("energy", whole, 1, 1e-12)
    done = run("check", "scene.yaml")
    if "surface face: harvey scatters" not in done.stdout or "0, 30, 60, 80 degrees" not in done.stdout:
        fail("check does not say what scatters")
    for name in ("picture.svg", "picture.png"):
        if run("check", "scene.yaml", "--surface", "face", "--plot", name, "--force").returncode != 0 or os.path.getsize(name) < 5000:
            fail("no picture")


def check_contamination():
    """Levels cover what the standard's sizes do; light passes the particles twice."""
    for level, covers in ((400, "0.106 %"), (600, "0.798 %")):
        dusty = "{type: mirror, reflectance: 0.9, contamination: {level: %d, slope: 0.926, area: 1 ft2, n: 1.53, k: 1e-3}}" % level
        done = run("check", scene(dusty), "--surface", "face")
        found = re.search(r"particles cover ([0-9.]+) % of it", done.stdout)
        if not found or abs(float(found[1]) - float(covers[:-2])) > 0.0015 * float(covers[:-2]) * 4:
            fail(f"level {level} covers {done.stdout[:300]}")
    both = scene("{type: mirror, reflectance: 0.9, scatter: {model: harvey, b0: 1.4, l: 0.01, s: -1.5}, contamination: {level: 600}}",
                 sources=beam(0, 40, 0))
    by = checked(both)["sides"][0]["by_angle"]
    k = by["angle"].index(40)
    want, harvey = by["reflect_diffuse"][k], 10 * 0.14 / 0.13947 * 1.4875e-3
    if not want > harvey + 0.01:
        fail(f"two models scatter {want}")
    heavy = checked(write("heavy.yaml", SCENE % (
        "587.56", "{type: mirror, reflectance: 0.9, scatter: {model: harvey, b0: 0.7, l: 0.2, s: -1.5}, contamination: {level: 900, area: 0.02 m2}}",
        "air", beam(0, 0, 0))))
    for specular, diffuse in zip(heavy["sides"][0]["by_angle"]["reflect_specular"], heavy["sides"][0]["by_angle"]["reflect_diffuse"]):
        if specular < 0 or specular + diffuse > 0.9 + 1e-12:
            fail(f"more than the reflectance: {specular} + {diffuse}")
    run("trace", both, "-o", "dust.raymap", "-n", 40000, "--quiet", "--force")
    answer = json.loads(run("query", "dust.raymap", "scatter(*)", "scatter(contamination)", "scatter(harvey)", "--count", "--json").stdout)
    scattered, dust, lobe = (one["rays"]["matched"] for one in answer)
    close("share of both", scattered / 40000, want, 4 * math.sqrt(want / 40000))
    alone = checked(scene("{type: mirror, reflectance: 0.9, contamination: {level: 600}}"))["sides"][0]["by_angle"]["reflect_diffuse"][k]
    close("share of particles", dust / 40000, alone, 4 * math.sqrt(alone / 40000))
    if dust + lobe != scattered or run("verify", "dust.raymap").returncode != 0:
        fail(f"a map of two models: {answer}")
    check_which_model()
    shutil.rmtree("dust.raymap")
    check_dusty_glass()


def check_which_model():
    """Each ray by itself: one model sends light straight back, the other hardly ever; how much each takes differs between wavelengths."""
    back = "{type: scatter, reflectance: 0.9, reflect: {model: retro, sigma: 0.005, tis: {wavelength: [450, 650], value: [0.05, 0.8]}}, contamination: {level: 900}}"
    both = scene(back, "450, 650", sources=beam(0, 40, 0))
    angle = math.radians(40)
    with open(both, "a", encoding="utf-8") as file:
        file.write(f"detectors: [{{name: back, type: intensity, axis: [{-math.sin(angle)!r}, 0, {math.cos(angle)!r}], cells: [180, 1]}}]\n")
    run("trace", both, "-o", "which.raymap", "-n", 10000, "--quiet", "--force")
    criteria = [f"scatter({name}){more}" for name in ("retro", "contamination", "*") for more in ("", " and registered(back where angle < 3)")]
    answer = json.loads(run("query", "which.raymap", *criteria, "scatter(retro) and scatter(contamination)", "--count", "--json").stdout)
    lobe, lobe_back, dust, dust_back, scattered, _, twice = (one["rays"]["matched"] for one in answer)
    if lobe_back != lobe or dust_back > 10 or lobe + dust != scattered or twice or min(lobe, dust) < 1500:
        fail(f"which of two models: {answer}")
    shutil.rmtree("which.raymap")


GLASS = """raymap: 1
units: mm
spectrum: {wavelengths: [450, 650]}
media: {air: {index: 1}, glass: {table: {wavelength: [450, 650], n: [1.53, 1.51]}}}
surfaces:
  dusty: {type: fresnel, scatter: {model: harvey, roughness: 30 nm, correlation: 1 um}, contamination: {level: 900, area: 0.02 m2}}
  paint: {type: scatter, reflectance: 0.1, reflect: {model: lambert}, contamination: {level: 900, area: 0.02 m2}}
geometries:
  plate: {type: box, size: [20, 20, 5]}
  wall: {type: rectangle, size: [30, 30]}
objects:
  - {name: plate, geometry: plate, surface: dusty, inside: glass, outside: air}
  - {name: wall, geometry: wall, at: [0, 0, -10], surface: paint, front: air, back: air}
sources: [{name: sun, type: collimated, shape: {disc: 2}, at: [-3, 0, 20], direction: [0.2, 0, -1], flux: 1 W}]
"""


def check_dusty_glass():
    """Particles lie outside: once crossed by what passes, not at all by what the glass reflects; one map however it is made."""
    by = {side["from"]: side["by_angle"] for side in checked(write("glass.yaml", GLASS), "dusty")["sides"]}
    inside = by["glass"]
    for k, angle in enumerate(inside["angle"]):
        sums = sum(inside[way][k] for way in ("reflect_specular", "reflect_diffuse", "transmit_specular", "transmit_diffuse"))
        if not sums < 1 + 1e-12 or (angle > 45 and abs(sums - 1) > 1e-12):
            fail(f"dusty glass from inside at {angle}: {sums}")
    outside = checked(write("clean.yaml", GLASS.replace("scatter: {model: harvey, roughness: 30 nm, correlation: 1 um}, ", "")), "dusty")
    side = [side for side in outside["sides"] if side["from"] == "air"][0]["by_angle"]
    n = {450: 1.53, 650: 1.51}[outside["wavelength"]]
    bare = ((n - 1) / (n + 1)) ** 2
    once, twice = side["transmit_specular"][0] / (1 - bare), side["reflect_specular"][0] / bare
    close("light that crosses particles twice", twice, once**2, 1e-9)
    for k in range(len(side["angle"])):
        if side["angle"][k] == 0 and not 0.02 < side["reflect_diffuse"][k] / side["transmit_diffuse"][k] < 0.3:
            fail("what particles send back")
    digests = set()
    for name, more in (("compact", []), ("plain", ["--encoding", "plain"]), ("threads", ["--threads", 2])):
        done = run("trace", "glass.yaml", "-o", f"{name}.raymap", "-n", 10000, "--quiet", "--force", *more)
        if done.returncode != 0 or name != "threads" and run("verify", f"{name}.raymap").returncode != 0:
            fail(f"dusty glass, {name}: {done.stderr[-300:]}")
        digests.add(json.loads(run("info", f"{name}.raymap", "--json").stdout)["digest"])
    if len(digests) != 1:
        fail(f"dusty glass: {digests}")
    for name in ("compact", "plain", "threads"):
        shutil.rmtree(f"{name}.raymap", ignore_errors=True)
    cemented = GLASS.replace("inside: glass, outside: air", "inside: glass, outside: glass")
    refused(write("cemented.yaml", cemented), "particles of surface 'dusty' lie on one side")


# ---- which way the surface is brushed ----

BRUSHED = """raymap: 1
units: mm
spectrum: {wavelengths: [550]}
media: {air: {index: 1}}
surfaces: {brushed: {type: scatter, reflectance: 1, reflect: {model: ggx, alpha: [0.02, 0.3]}, frame: %s}}
geometries: {plate: %s, screen: {type: rectangle, size: [200, 200]}}
objects:
  - {name: plate, geometry: plate, surface: brushed, front: air, back: air, rotate: [0, 0, %s]}
  - {name: screen, geometry: screen, at: [0, 0, 50], surface: absorber, front: air, back: air}
sources: [{name: s, type: collimated, shape: {disc: 0.1}, at: [%s, 20], direction: [0, 0, -1], flux: 1 W}]
detectors: [{name: sensor, type: plane, at: [0, 0, 49.9], direction: [0, 0, -1], size: [200, 200], cells: 1}]
"""
CORNERS = [(-10, -10), (10, -10), (10, 10), (-10, 10)]


def texture(x, y):
    """u grows towards 30 degrees; v three times as fast, and the other way around."""
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    return x * c + y * s, -3 * (-x * s + y * c)


def write_plates():
    """One plate in three formats, and without a texture."""
    points, uv = [(x, y, 0) for x, y in CORNERS], [texture(x, y) for x, y in CORNERS]
    vertices = "".join("v %g %g %g\n" % p for p in points)
    write("plate.obj", vertices + "".join("vt %.9g %.9g\n" % t for t in uv) + "f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n")
    write("bare.obj", vertices + "f 1 2 3\nf 1 3 4\n")
    write("plate.ply", "ply\nformat ascii 1.0\nelement vertex 4\n" + "".join(f"property float {name}\n" for name in "xyzst")
          + "element face 2\nproperty list uchar int vertex_indices\nend_header\n"
          + "".join("%g %g %g %.9g %.9g\n" % (*p, *t) for p, t in zip(points, uv)) + "3 0 1 2\n3 0 2 3\n")
    data = b"".join([*(struct.pack("<3f", *p) for p in points), *(struct.pack("<2f", *t) for t in uv), struct.pack("<6H", 0, 1, 2, 0, 2, 3)])
    write("plate.gltf", json.dumps({
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2}]}],
        "accessors": [{"bufferView": k, "componentType": c, "count": n, "type": t}
                      for k, (c, n, t) in enumerate([(5126, 4, "VEC3"), (5126, 4, "VEC2"), (5123, 6, "SCALAR")])],
        "bufferViews": [{"buffer": 0, "byteOffset": at, "byteLength": n} for at, n in ((0, 48), (48, 32), (80, 12))],
        "buffers": [{"byteLength": len(data), "uri": "data:application/octet-stream;base64," + base64.b64encode(data).decode()}]}))


def strip(degrees, x, y):
    """A narrow part of the screen about (x, y), along this direction; its x is the world's -x."""
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    corners = [(x + a * c - b * s, y + a * s + b * c) for a, b in ((-80, -8), (80, -8), (80, 8), (-80, 8))]
    return "registered(sensor, polygon(%s, world))" % ", ".join("%.9g, %.9g" % corner for corner in corners)


def brushed(name, frame, geometry, along, turn=0, x=0, y=0):
    """Light leaves across the grain, which is along these degrees. The digest; check_brushed compares it with a plain map's."""
    text = BRUSHED % (frame, geometry, turn, f"{x}, {y}")
    write(f"{name}.yaml", text)
    SERVER.edit(text=text)
    SERVER.trace(4000)
    across, by = (SERVER.query(strip(degrees, x, y))["rays"]["matched"] for degrees in (along + 90, along))
    if not (across > 0.85 * 4000 and by < 0.35 * 4000):
        fail(f"{name}: {across} across the grain, {by} along it")
    return SERVER.status()["digest"]


def check_brushed():
    write_plates()
    meshes = {brushed(f"{form} mesh", "uv", "{type: mesh, file: plate.%s}" % form, 30) for form in ("obj", "ply", "gltf")}
    if len(meshes) != 1:
        fail(f"one plate in three formats: {meshes}")
    want = brushed("turned mesh", "uv", "{type: mesh, file: plate.obj}", 75, turn=45)
    plate = "{type: rectangle, size: [20, 20]}"
    if brushed("rectangle", "uv", plate, 20, turn=20) != brushed("rectangle by the object", "object", plate, 20, turn=20):
        fail("a rectangle's u is its x")
    for degrees in (0, 200):  # as a lathe leaves it
        x, y = 6 * math.cos(math.radians(degrees)), 6 * math.sin(math.radians(degrees))
        brushed(f"disc at {degrees}", "uv", "{type: disc, radius: 10}", degrees + 90, x=x, y=y)
    brushed("disc, by the object", "object", "{type: disc, radius: 10}", 0, x=3, y=5)
    for geometry in ("{type: mesh, file: bare.obj}", "{type: box, size: [1, 1, 1]}"):
        refused(write("bare.yaml", BRUSHED % ("uv", geometry, 0, "0, 0")), "has no texture coordinates", surface=geometry)
    run("trace", "turned mesh.yaml", "-o", "moved.raymap", "-n", 4000, "--quiet", "--force")
    os.remove("plate.obj")
    run("convert", "moved.raymap", "-o", "again.raymap", "--encoding", "plain", "--force")
    if json.loads(run("info", "again.raymap", "--json").stdout)["digest"] != want:
        fail("a map without its mesh file")
    shutil.rmtree("moved.raymap")
    shutil.rmtree("again.raymap")


# ---- Klems ----

RINGS = [(0, 10, 1), (10, 30, 6), (30, 55, 10), (55, 90, 8)]


def patches():
    """(area, theta, phi) of each."""
    found = []
    for low, high, n in RINGS:
        area = math.pi * (math.sin(math.radians(high)) ** 2 - math.sin(math.radians(low)) ** 2) / n
        found += [(area, (low + high) / 2 if low else 0, 360 * k / n) for k in range(n)]
    return found


def klems(data):
    """data: {"Transmission Back": matrix[line][column], ...}"""
    basis = "".join(f"<AngleBasisBlock><Theta>{(a + b) / 2}</Theta><nPhis>{n}</nPhis><ThetaBounds><LowerTheta>{a}</LowerTheta>"
                    f"<UpperTheta>{b}</UpperTheta></ThetaBounds></AngleBasisBlock>\n" for a, b, n in RINGS)
    blocks = "".join(f"""<WavelengthData><Wavelength unit="Integral">Visible</Wavelength><WavelengthDataBlock>
<WavelengthDataDirection>{name}</WavelengthDataDirection><ScatteringDataType>BTDF</ScatteringDataType>
<ScatteringData>{chr(10).join(', '.join(repr(x) for x in line) for line in matrix)}</ScatteringData>
</WavelengthDataBlock></WavelengthData>""" for name, matrix in data.items())
    return f"""<?xml version="1.0"?><WindowElement xmlns="http://windows.lbl.gov"><Optical><Layer><DataDefinition>
<IncidentDataStructure>Columns</IncidentDataStructure><AngleBasis>{basis}</AngleBasis></DataDefinition>{blocks}</Layer></Optical></WindowElement>"""


def check_klems():
    dice, at = random.Random(4), patches()
    data = {f"{way} {side}": [[dice.random() * (0.25 if way == "Transmission" else 0.05) for _ in at] for _ in at]
            for way in ("Transmission", "Reflection") for side in ("Front", "Back")}
    write("matrix.xml", klems(data))
    surface = "{type: scatter, reflect: {model: klems, file: matrix.xml}, transmit: {model: klems, file: matrix.xml}}"
    asked = [(j, front) for j in (0, 3, 9, 20) for front in (True, False)]
    sources = ", ".join(beam(k, at[j][1], at[j][2], front) for k, (j, front) in enumerate(asked))
    path = scene(surface, sources=sources)
    run("trace", path, "-o", "klems.raymap", "-n", 40000, "--quiet", "--force")
    os.remove("matrix.xml")  # the map has it
    cases = [(k, j, "Back" if front else "Front", way) for k, (j, front) in enumerate(asked) for way in ("Transmission", "Reflection")]
    event = {"Transmission": "transmit_diffuse", "Reflection": "reflect_diffuse"}
    answers = run("query", "klems.raymap", *(f"source(s{k}) and hit(plate, {event[way]})" for k, _, _, way in cases), "--count", "--json")
    for (_, j, side, way), answer in zip(cases, json.loads(answers.stdout)):
        want = sum(line[j] * a for line, (a, _, _) in zip(data[f"{way} {side}"], at))
        got, n = answer["rays"]["matched"], 40000 / len(asked)
        if abs(got - n * want) > 4 * math.sqrt(n * want * (1 - want)):
            fail(f"{way} {side} of patch {j}: {got / n}, not {want}")
    if run("verify", "klems.raymap").returncode != 0:
        fail("verify of a map with a matrix")
    shutil.rmtree("klems.raymap")
    good = klems(data)
    for text, complaint in [
            ("<a>", "it is no XML"), ("<a/>", "holds no Klems matrix"),
            (good.replace(">Columns<", ">TensorTree4<"), "IncidentDataStructure is 'TensorTree4'"),
            (good.replace("Visible", "Infrared"), "no Reflection data of the Visible band"),
            (good.replace("<ScatteringData>", "<ScatteringData>nan, "), "is nan"),
            (good.replace("<ScatteringData>", "<ScatteringData>-1, "), "is -1"),
            (good.replace("<ScatteringData>0.", "<ScatteringData> ]0."), "numbers"),
            (good.replace("<UpperTheta>30<", "<UpperTheta>31<"), "an AngleBasisBlock"),
            (good.replace("<ScatteringData>0.", "<ScatteringData>1000.", 4), "more than 1")]:
        write("matrix.xml", text)
        refused(scene(surface), complaint, "matrix.xml")
    write("matrix.xml", klems({name: matrix for name, matrix in data.items() if "Back" in name}))
    its, said = told(scene(surface))
    if its["errors"]:
        fail(f"blocks of one side: {said}")
    for words in ("has no Reflection Front: light that meets the object's back is not reflected there",
                  "has no Transmission Front: light that meets the object's back does not pass there"):
        if words not in said:
            fail(f"a block that is missing: {said}")


# ---- CSV ----

def table(f, theta_i=(0, 30, 60, 85), theta_s=tuple(range(0, 91, 5)), phi_s=tuple(range(0, 181, 15)), nm=(0,)):
    rows = ["# wavelength, theta_i, phi_i, theta_s, phi_s, value", "wavelength,theta_i,phi_i,theta_s,phi_s,value"]
    rows += [f"{w},{i},0,{s},{p},{f(w, i, s, p)!r}" for w in nm for i in theta_i for s in theta_s for p in phi_s]
    return "\n".join(rows) + "\n"


def forward(_, i, s, p):
    """About the specular direction, at phi_s = 180 of light from phi_i = 0."""
    t, u = math.radians(s), math.radians(p)
    x = math.sin(t) * math.cos(u) + math.sin(math.radians(i))
    return 0.05 + 0.3 * math.exp(-(x * x + (math.sin(t) * math.sin(u)) ** 2) / 0.08)


def check_table():
    surface = "{type: scatter, reflect: {model: table, file: data.csv}}"
    write("data.csv", table(forward))
    its = checked(scene(surface))
    bsdf = its["sides"][0]["bsdf"][1]  # from 30 degrees
    for angle in (-60, -30, 0, 30, 60):
        want = forward(0, 30, abs(angle), 180 if angle > 0 else 0)
        close(f"table at {angle}", bsdf["reflected"][bsdf["angle"].index(angle)], want, 1e-12)
    if not 0 < its["scatter"]["asymmetry"]["reflect"] < 0.2:  # the law is reciprocal, between its angles a table is not
        fail(f"asymmetry: {its['scatter']}")
    # light goes forward, whatever azimuth it comes from, and a quarter of a turn of the object changes nothing
    for phi in (0, 77):
        run("trace", scene(surface, sources=beam(0, 60, phi)), "-o", "table.raymap", "-n", 30000, "--quiet", "--force")
        c, s = math.cos(math.radians(phi)), math.sin(math.radians(phi))
        mean = json.loads(run("query", "table.raymap", "scatter(table)", "--count", "--json").stdout)["rays"]["matched"] / 30000
        k = its["sides"][0]["by_angle"]["angle"].index(60)
        close(f"share from azimuth {phi}", mean, its["sides"][0]["by_angle"]["reflect_diffuse"][k], 4 * math.sqrt(mean / 30000))
    if run("verify", "table.raymap").returncode != 0:
        fail("verify of a map with a table")
    shutil.rmtree("table.raymap")
    write("data.csv", table(lambda w, *at: forward(w, *at) * (1 if w < 600 else 0.5), nm=(500, 700)))
    if told(scene(surface, "500, 600, 700"))[0]["errors"]:
        fail("a table of two wavelengths")
    lines = table(forward).splitlines()
    swapped = lines[:4] + [lines[5], lines[4]] + lines[6:]
    for text, nm, complaint in [
            (table(forward, nm=(500, 550)), "587.56", "covers 500 to 550 nm, and the scene has light from 587.56 to 587.56 nm"),
            ("\n".join(swapped), "500", "line 5: phi_s 45 is out of order"),
            ("\n".join(lines[:-1]), "500", "rows"),
            (table(forward).replace("0,30,0,45,15,", "0,30,0,45,15,-"), "500", "it is not negative"),
            (table(forward).replace("0,30,0,45,15,", "0,30,0,45,15,nan"), "500", "a row has six numbers"),
            (table(forward, theta_s=(0, 45, 95)), "500", "theta is from 0 to 90"),
            (table(forward, phi_s=(0, 10, 30, 180)), "500", "not in equal steps"),
            (table(forward, phi_s=(0, 30, 60)), "500", "goes from 0 to 180, or all around"),
            (table(lambda *_: 1.0), "500", "scatters 3.14159 of the light at 0 degrees: more than 1"),
            ("# nothing\n", "500", "it has no rows")]:
        write("data.csv", text)
        refused(scene(surface, nm), complaint)


# ---- Zemax ----

def zemax(f, radial=tuple(range(0, 181, 5)), azimuth=tuple(range(0, 181, 15)), incidence=(0, 20, 40, 60), kind="BRDF"):
    lines = ["# made for a test", "Source  Measured", "Symmetry  PlaneSymmetrical", "SpectralContent  Monochrome", f"ScatterType  {kind}",
             "SampleRotation  1", "0", f"AngleOfIncidence  {len(incidence)}", "\t".join(map(str, incidence)),
             f"ScatterAzimuth {len(azimuth)}", " ".join(map(str, azimuth)), f"ScatterRadial {len(radial)}", " ".join(map(str, radial)),
             "", "Monochrome", "DataBegin"]
    for i in incidence:
        lines.append("TIS 0.1")
        lines += ["\t".join(f"{f(i, a, r):.6E}" for r in radial) for a in azimuth]
    return "\n".join(lines + ["DataEnd", ""])


def lobe(_, azimuth, radial):
    """Broader towards the normal (azimuth 0) than away from it."""
    width = 20 if azimuth < 90 else 10
    return 0.02 + 0.8 * math.exp(-(radial / width) ** 2)


def check_zemax():
    surface = "{type: scatter, specular: 0.1, reflect: {model: table, file: vinyl.BSDF}}"
    write("vinyl.BSDF", zemax(lobe))
    its = checked(scene(surface))
    bsdf = its["sides"][0]["bsdf"][1]  # from 30 degrees: between 20 and 40
    for angle, want in ((30, lobe(0, 0, 0)), (20, lobe(0, 0, 10)), (40, lobe(0, 180, 10)), (0, lobe(0, 0, 30)), (-30, lobe(0, 0, 60))):
        close(f"Zemax at {angle}", bsdf["reflected"][bsdf["angle"].index(angle)], want, 0.01 * want)
    run("trace", scene(surface, sources=beam(0, 30, 50)), "-o", "zemax.raymap", "-n", 30000, "--quiet", "--force")
    share = json.loads(run("query", "zemax.raymap", "scatter(table)", "--count", "--json").stdout)["rays"]["matched"] / 30000
    close("Zemax share", share, its["sides"][0]["by_angle"]["reflect_diffuse"][6], 4 * math.sqrt(share / 30000))
    if run("verify", "zemax.raymap").returncode != 0:
        fail("verify of a map with a tabular BSDF")
    shutil.rmtree("zemax.raymap")
    good = zemax(lobe)
    for text, complaint in [
            (good.replace("BRDF", "BTDF"), "it is a BTDF, of transmitted light"),
            (good.replace("SampleRotation  1\n0", "SampleRotation  2\n0 90"), "SampleRotation 90, of 2, stands where 180 was due"),
            (good.replace("SampleRotation  1\n0", "SampleRotation  3\n10 130 250"), "SampleRotation 10, of 3, stands where 0 was due"),
            (good.replace("SampleRotation  1\n0", "SampleRotation  2\n0 180"), "'DataEnd': TIS was due"),
            (good.replace("ScatterRadial 37", "ScatterRadial 38"), "a number from 0 to 180 was due"),
            (good.replace("20\t40", "40\t20"), "AngleOfIncidence 20 is out of order"),
            (good.replace("DataEnd", ""), "DataEnd was due"),
            (good.replace("TIS 0.1", "TIS nan", 1), "a number from 0"),
            (good.replace("PlaneSymmetrical", "Asymmetrical"), "ScatterAzimuth is not in equal steps"),
            (zemax(lambda *_: 1.0), "more than 1"),
            ("Source Measured", "it has no SampleRotation")]:
        write("vinyl.BSDF", text)
        refused(scene(surface), complaint)


# ---- mistakes ----

def check_mistakes():
    for name, first in (("below.csv", -5), ("mixed.csv", 0)):
        write(name, "".join(f"{nm} 0 0 {theta} {phi} 0.1\n" for nm in (first, 600) for theta in (0, 90) for phi in (0, 180)))
    if not os.path.exists("waiting"):
        os.mkfifo("waiting")
    for surface, complaint in [
            ("{type: scatter, reflectance: 0.5, reflect: {model: phong}}", "known: lambert, gaussian"),
            ("{type: scatter, reflectance: 0.5}", "a scattering surface has a model"),
            ("{type: scatter, reflectance: 0.5, reflect: {model: gaussian}}", "'sigma' is missing"),
            ("{type: scatter, reflect: {model: gaussian, sigma: 0.1}}", "how much of the light?"),
            ("{type: scatter, reflectance: 0.9, specular: 0.1, reflect: {model: gaussian, sigma: 0.1}}", "not both"),
            ("{type: scatter, reflectance: 0.5, reflect: {model: abg, A: 0.1, B: 0.1, g: 3}}",
             "abg scatters 1.02341 of the light at 0 degrees and 587.56 nm, and its reflectance is 0.5"),
            ("{type: scatter, reflectance: 0.5, reflect: {model: gaussian, sigma: 0.1, tis: 0.6}}", "its reflectance is 0.5"),
            ("{type: scatter, specular: 0.5, reflect: {model: gaussian, sigma: 0.1, tis: 0.6}}", "beside the specular share is 0.5"),
            ("{type: mirror, reflectance: 0.9, scatter: {model: harvey, b0: 1, l: 0.1}}", "'s' is missing"),
            ("{type: mirror, reflectance: 0.9, scatter: {model: harvey, b0: 1, l: 0.1, s: 1}}", "'s' must be negative"),
            ("{type: mirror, reflectance: 0.9, scatter: {model: harvey, roughness: 2, correlation: 1}}", "write its unit"),
            ("{type: mirror, reflectance: 0.9, scatter: {model: harvey, roughness: 2 nm}}", "the correlation of its roughness"),
            ("{type: fresnel, scatter: {model: abg, A: 0.1, B: 0.1, g: 2}}", "not how much passes"),
            ("{type: fresnel, scatter: {model: unified, lobe: 1}}", "'sigma_alpha' is missing"),
            ("{type: scatter, reflect: {model: unified, sigma_alpha: 3, lobe: 0.7, spike: 0.4}}", "sum to 1.1"),
            ("{type: scatter, transmittance: 0.5, transmit: {model: ggx, alpha: 0.3}}", "type fresnel"),
            ("{type: scatter, reflectance: 0.6, reflect: {model: lambert}, transmittance: 0.6, transmit: {model: lambert}}",
             "reflects and lets pass 1.2 of the light, at 587.56 nm, most of it at 0 and 0 degrees"),
            ("{type: scatter, reflect: {model: table, file: below.csv}}", "a wavelength of -5 nm is none"),
            ("{type: scatter, reflect: {model: table, file: mixed.csv}}", "wavelength 0 stands for any, and there are others"),
            ("{type: scatter, reflect: {model: table, file: a.anisotropicbsdf}}", "has not made public"),
            ("{type: scatter, reflect: {model: table, file: nowhere.csv}}", "nowhere.csv"),
            ("{type: scatter, reflect: {model: table, file: /dev/zero}}", "/dev/zero"),
            ("{type: scatter, reflect: {model: klems, file: .}}", "./.: "),
            ("{type: scatter, reflect: {model: klems, file: waiting}}", "waiting"),
            ("{type: mirror, reflectance: 0.9, contamination: {level: 2}}", "a cleanliness level"),
            ("{type: mirror, reflectance: 0.9, contamination: {level: 400, area: 3 mm}}", "'1 ft2' or '0.1 m2'"),
            ("{type: mirror, reflectance: 0.9, scatter: {model: ggx, alpha: 0.1}, contamination: {level: 400}}", "not on facets"),
            ("{type: mirror, reflectance: 0.9, frame: grain, scatter: {model: ggx, alpha: [0.1, 0.2]}}", "known: object, uv")]:
        refused(scene(surface), complaint, surface=surface)


def check_finishes():
    """Every published surface can be read, at the wavelengths that it is known at, and is found in any case."""
    import yaml
    with open(os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..", "io", "scene", "finishes.yaml"), encoding="utf-8") as file:
        finishes = yaml.safe_load(file)
    if len(finishes) < 15:
        fail("the library is short")
    for name, its in finishes.items():
        total = its.get("reflectance", {})
        nm = f"{total['wavelength'][0]}, {total['wavelength'][-1]}" if isinstance(total, dict) and total else "550"
        text = SCENE % (nm, "{type: absorber}", "air", beam(0, 0, 0))
        its, said = told(write("scene.yaml", text.replace("surface: face", "surface: " + name.lower())), surface=name)
        if its["diagnostics"] or its["surface"]["name"] != name:
            fail(f"{name}: {said}")
    refused(write("scene.yaml", text.replace("surface: face", "surface: acktar metal velvt")), "did you mean 'Acktar Metal Velvet'?")


with raymap.serve.start(scene("{type: absorber}")) as SERVER:
    check_numbers()
    check_finishes()
    check_contamination()
    check_brushed()
    check_klems()
    check_table()
    check_zemax()
    check_mistakes()
print(f"scatter models: {len(failures)} failures")
raise SystemExit(1 if failures else 0)
