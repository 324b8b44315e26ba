#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Films in scene files: what is wrong with one is told where it stands; maps of several colours keep their rays through
films bit by bit in either encoding, on any number of ranks; `check` lists films and shows surfaces."""
import json
import os
import pathlib
import re
import shutil
import subprocess

from asking import told_of  # knows where the package is
import raymap.serve

PROGRAM = os.environ["RAYMAP"]
SCENE = """raymap: 1
units: mm
spectrum: {{wavelengths: [450, 550, 650]}}
media: {{air: {{index: 1}}, glass: {{glass: N-BK7}}, flint: {{glass: N-SF6}}}}
films:
  ar: {film}
surfaces:
  coated: {{type: fresnel, coat: {coat}}}
  silver: {{type: mirror, metal: Ag, coat: {{film: ar}}}}
  white: {{type: mixture, reflect_specular: 0.1, reflect_diffuse: 0.6}}
geometries:
  lens: {{type: lens, surface: coated, surfaces: [{{radius: 50, thickness: 6, medium: glass, aperture: 10}}, {{radius: -40, thickness: 3, medium: {second}, aperture: 10}}, {{radius: -90, medium: air, aperture: 10}}]}}
  plate: {{type: rectangle, size: [30, 30]}}
objects:
  - {{name: lens, geometry: lens, outside: air, edge: absorber}}
  - {{name: wall, geometry: plate, at: [0, 0, 40], rotate: [180, 0, 0], surface: white}}
  - {{name: mirror, geometry: plate, at: [0, 0, -40], surface: silver}}
sources:
  - {{name: s, type: collimated, shape: {{disc: 9}}, at: [0, 0, -20], direction: [0, 0, 1], medium: air, flux: 1 W}}
detectors:
  - {{name: film, type: plane, on: wall, cells: [4, 4]}}
"""
GOOD = "{reference: 550, substrate: back, layers: [{material: MgF2, quarter: 1}, {n: 2.4, k: 0.4, thickness: 9 nm}]}"


def run(*arguments, status=0, ranks=0):
    start = ["mpirun", "-np", str(ranks)] if ranks else []
    done = subprocess.run([*start, PROGRAM, *map(str, arguments)], capture_output=True, text=True, check=False)
    assert done.returncode == status, (arguments, done.returncode, done.stdout, done.stderr)
    return done.stdout, done.stderr


def scene(film=GOOD, coat="{film: ar}", second="flint"):
    pathlib.Path("scene.yaml").write_text(SCENE.format(film=film, coat=coat, second=second), encoding="utf-8")
    return "scene.yaml"


pathlib.Path("bad.csv").write_text("wavelength,angle,Rs,Rp,Ts,Tp\n0,0,0.7,0.1,0.4,0.4\n", encoding="utf-8")
pathlib.Path("other.csv").write_text("500 0 0.1 0.1 0.8 0.8\n500 60 0.3 0.2 0.6 0.7\n", encoding="utf-8")
SERVER = raymap.serve.start(scene())
for film, coat, said in (
        ("{layers: [{quarter: 1}]}", "{film: ar}", "6:17: error: a layer has one of material, n (and k), table"),
        ("{layers: [{n: 1.4, table: {wavelength: [400], n: [1]}, quarter: 1}]}", "{film: ar}", "a layer has one of"),
        ("{layers: [{n: 1.4}]}", "{film: ar}", "as in 'thickness: 130 nm'"),
        ("{layers: [{n: 1.4, quarter: 1}]}", "{film: ar}", "as in 'reference: 550'"),
        ("{layers: [{n: 1.4, thickness: 130}]}", "{film: ar}", "a film of 130 mm is none"),
        ("{layers: [{n: 1.4, thickness: -1 nm}]}", "{film: ar}", "'thickness' must be"),
        ("{layers: [{n: -1.4, thickness: 1 nm}]}", "{film: ar}", "'n' must be a refractive index"),
        ("{layers: [{material: MgF22, thickness: 1 nm}]}", "{film: ar}", "did you mean 'MgF2'?"),
        ("{layers: {n: 1.4}}", "{film: ar}", "'layers' must be a list"),
        ("{reference: 550}", "{film: ar}", "'layers' is missing"),
        ("{table: {file: nowhere.csv}}", "{film: ar}", "nowhere.csv"),
        ("{table: {file: bad.csv}}", "{film: ar}", "bad.csv: line 2: Rs 0.7 and Ts 0.4 are no shares"),
        ("{table: {file: other.csv}}", "{film: ar}", "other.csv: it covers 500 to 500 nm, and the scene has light from 450 to 650 nm"),
        ("{table: {file: bad.csv}, layers: []}", "{film: ar}", "a film is measured, by its 'table', or has layers"),
        ("{layers: [], colour: 3}", "{film: ar}", "unknown key in a film: 'colour'"),
        (GOOD, "{film: at}", "unknown film 'at' (did you mean 'ar'?)"),
        (GOOD, "{film: ar, reflectance: 0.1}", "not both"),
        (GOOD, "ar", "a film is named so: 'coat: {film: ar}'"),
        (GOOD.replace("substrate: back, ", ""), "{film: ar}",
         "neither side of 'lens.2' is the medium around it: say in film 'ar' on which side its last layer lies, as in 'substrate: back'"),
        (GOOD.replace("[{", "[" + 1001 * "{n: 1.3, thickness: 1 nm}, " + "{"), "{film: ar}", "1000 layers at most")):
    text = pathlib.Path(scene(film, coat)).read_text("utf-8")
    told = run("check", "scene.yaml", status=3)[1] if "6:17" in said else told_of(SERVER, text)[1]
    assert said in told, (film, coat, told)
SERVER.close()
for metal, said in (("reflectance: 0.9, coat: {film: ar}", "the films of a mirror lie on a metal"), ("metal: Ag, coat: ideal", "the coat of a metal is a film")):
    assert said in run("check", scene(), "--set", f"surfaces.silver={{type: mirror, {metal}}}", status=3)[1], metal
assert "both sides of 'lens.3' are the medium around it" in \
    run("check", scene(GOOD.replace("substrate: back, ", ""), second="air"), status=3)[1]

path = scene()
told = json.loads(run("check", path, "--surface", "coated", "--json")[0])
layers = told["scene"]["films"][0]["layers"]
assert told["scene"]["films"][0]["substrate"] == "back" and len(layers) == 2 and layers[1]["k"] == 0.4, layers
assert abs(layers[0]["thickness_nm"] * layers[0]["n"] - 137.5) < 1e-9, layers
side = told["surface"]["sides"][0]
assert (told["surface"]["object"], side["from"], side["into"]) == ("lens.1", "air", "glass"), told["surface"]
for curves in (side["by_angle"], side["by_wavelength"]):
    for numbers in zip(*(curves[key] for key in ("reflect_specular", "transmit_specular", "absorb"))):
        assert abs(sum(numbers) - 1) < 1e-12 and min(numbers) >= 0, numbers
text = run("check", path, "--surface", "silver", "--plot", "silver.svg", "--force")[0]
assert "film ar: 2 layers: " in text and "surface silver: mirror, film ar, on mirror, at 550 nm" in text, text
assert pathlib.Path("silver.svg").read_text(encoding="utf-8").startswith("<?xml")

def drawn(*arguments, surface="coated"):
    """Lengths of the curves of a picture, their points, and its dots."""
    said = run("check", *arguments, "--surface", surface, "--plot", "curves.svg", "--force", "--quiet")[1]
    assert not said, said
    text = pathlib.Path("curves.svg").read_text(encoding="utf-8")
    curves = [[tuple(map(float, point.split())) for point in curve.split("L")] for curve in re.findall('<path d="M([^"]*)"', text)]
    return [len(curve) for curve in curves], curves, {tuple(map(float, dot)) for dot in re.findall('<circle cx="([^"]*)" cy="([^"]*)"', text)}


# Three wavelengths, and 62 between each two of them; the three are dots on the curves, and alone in the JSON.
BOTH, ANGLES, WAVELENGTHS = 6, 181, 127  # shares of two sides
n, curves, dots = drawn(path)
assert n == BOTH * [ANGLES] + BOTH * [WAVELENGTHS] and len(dots) >= 9, (n, dots)
assert len({x for x, y in dots}) == 3 and all(any(dot in curve for curve in curves[BOTH:]) for dot in dots), dots
assert all(len(one["by_wavelength"]["wavelength"]) == 3 for one in told["surface"]["sides"])
# A layer that reflects least between two of them.
reflected = drawn(scene("{reference: 500, substrate: back, layers: [{n: 1.23, quarter: 3}]}"))[1][BOTH]
assert max(reflected[0][1], reflected[63][1]) < 645 and max(y for x, y in reflected[:63]) > 700, reflected
scene()
# One has others beside it as far as the data of all media go, a measured coat at one wavelength none; rgb has no wavelengths.
BK7 = ["--set", "media.flint.glass=N-BK7"]  # from 300 nm
for nm in (550, 340):
    assert drawn(path, *BK7, "--set", f"spectrum.wavelengths={nm}")[0] == BOTH * [ANGLES] + BOTH * [WAVELENGTHS], nm
for few in ([*BK7, "--set", "spectrum.wavelengths=310"], ["--color", "rgb"],
            ["--set", "spectrum.wavelengths=500", "--set", "films.ar={substrate: back, table: {file: other.csv}}"]):
    n, _, dots = drawn(path, *few)
    assert n == BOTH * [ANGLES] and not dots, (few, n, dots)
n, _, dots = drawn(path, "--set", "spectrum.wavelengths={from: 400, to: 700, step: 3}")  # many as they are
assert n == BOTH * [ANGLES] + BOTH * [101] and not dots, (n, dots)
assert "no such surface" in run("check", path, "--surface", "gold", status=3)[1]
assert "no object has it" in run("check", path, "--set", "surfaces.spare={type: fresnel}", "--surface", "spare", status=3)[1]

for name in ("a", "b", "c"):
    shutil.rmtree(f"{name}.raymap", ignore_errors=True)
run("trace", path, "-o", "a.raymap", "-n", 30000, "--quiet")
run("trace", path, "-o", "b.raymap", "-n", 30000, "--encoding", "plain", "--quiet", ranks=3)
run("convert", "a.raymap", "-o", "c.raymap", "--encoding", "plain", "--quiet")
digests = {json.loads(run("info", f"{name}.raymap", "--json")[0])["digest"] for name in ("a", "b", "c")}
assert len(digests) == 1, digests
counts = [[part["rays"]["matched"] for part in json.loads(run("query", f"{name}.raymap", "hit(lens.*, absorb)", "hit(lens.*, reflect_specular)",
                                                             "registered(film)", "--count", "--json")[0])] for name in ("a", "b")]
assert counts[0] == counts[1] and all(counts[0]), counts
assert json.loads(run("verify", "a.raymap", "--json")[0])["ok"]
step = json.loads(run("report", "a.raymap", 7, "--json")[0])["steps"][0]
assert step["object"] == "lens.1" and 0.001 < step["reflectance"] < 0.2, step

# A row of a lens has a coat of its own, or none.
rows = SCENE.format(film=GOOD.replace("substrate: back, ", ""), coat="{film: ar}", second="flint").replace(
    "medium: flint, aperture: 10", "medium: flint, aperture: 10, surface: fresnel")
pathlib.Path("rows.yaml").write_text(rows, encoding="utf-8")
run("check", "rows.yaml")
run("trace", "rows.yaml", "-o", "rows.raymap", "-n", 20000, "--force", "--quiet")
absorbed = [part["rays"]["matched"] for part in json.loads(
    run("query", "rows.raymap", *(f"ended(absorbed, lens.{k})" for k in (1, 2, 3)), "--count", "--json")[0])]
assert absorbed[0] > 0 and absorbed[1] == 0 and absorbed[2] > 0, absorbed

# A mirror of coated metal: as the same layers on a micrometre of it, in front of anything; and no layers are the bare metal.
def mirror(layers, surface):
    pathlib.Path("metal.yaml").write_text(f"""raymap: 1
units: mm
spectrum: {{wavelengths: [450, 550]}}
media: {{air: {{index: 1}}, glass: {{index: 1.52}}}}
films: {{over: {{reference: 550, substrate: back, layers: [{layers}]}}}}
surfaces: {{face: {surface}}}
geometries: {{plate: {{type: rectangle, size: [100, 100]}}}}
objects: [{{name: plate, geometry: plate, surface: face, outside: air, back: glass}}]
sources: [{{name: s, type: point, at: [0, 0, 5], flux: 1 W, medium: air}}]
""", encoding="utf-8")
    return json.loads(run("check", "metal.yaml", "--surface", "face", "--json")[0])["surface"]["sides"][0]


ON_METAL, PAIR = "{type: mirror, metal: Al, coat: {film: over}}", "{n: 1.38, quarter: 1}, {n: 2.35, quarter: 1}"
for one, other in ((mirror("", ON_METAL), mirror("", "{type: mirror, metal: Al}")),
                   (mirror(PAIR, ON_METAL), mirror(PAIR + ", {material: Al, thickness: 1 um}", "{type: fresnel, coat: {film: over}}"))):
    for curve in ("by_angle", "by_wavelength"):
        for key in ("reflect_specular", "transmit_specular", "absorb"):
            assert max(abs(a - b) for a, b in zip(one[curve][key], other[curve][key])) < 1e-12, (curve, key)

# A measured coat: the numbers of a film of layers as a table give the same, from either side, and travel with the map.
def shares(film):
    pathlib.Path("coat.yaml").write_text(f"""raymap: 1
units: mm
spectrum: {{wavelengths: [550]}}
media: {{air: {{index: 1}}, glass: {{index: 1.52}}}}
films: {{ar: {film}}}
surfaces: {{face: {{type: fresnel, coat: {{film: ar}}}}}}
geometries: {{plate: {{type: rectangle, size: [100, 100]}}}}
objects: [{{name: plate, geometry: plate, surface: face, outside: air, back: glass}}]
sources: [{{name: s, type: point, at: [0, 0, 5], flux: 1 W, medium: air}}]
""", encoding="utf-8")
    return [side["by_angle"] for side in json.loads(run("check", "coat.yaml", "--surface", "face", "--json")[0])["surface"]["sides"]]


layers = shares("{reference: 550, layers: [{n: 1.38, quarter: 1}, {n: 2, k: 0.1, thickness: 5 nm}]}")
rows = [f"0,{angle},{r!r},{r!r},{t!r},{t!r}" for angle, r, t in
        zip(layers[0]["angle"], layers[0]["reflect_specular"], layers[0]["transmit_specular"])]
pathlib.Path("coat.csv").write_text("\n".join(rows), encoding="utf-8")
table = shares("{table: {file: coat.csv}}")
for key in ("reflect_specular", "transmit_specular", "absorb"):
    assert max(abs(a - b) for a, b in zip(layers[0][key], table[0][key])) < 1e-12, key
assert max(abs(a - b) for a, b in zip(layers[1]["transmit_specular"], table[1]["transmit_specular"])) < 0.02  # between its angles
run("trace", "coat.yaml", "-o", "coat.raymap", "-n", 20000, "--force", "--quiet")
pathlib.Path("coat.csv").unlink()
assert json.loads(run("verify", "coat.raymap", "--json")[0])["ok"]

# The example: two designs, of which the better one makes fewer ghosts.
example = pathlib.Path(os.environ["SOURCE_DIR"], "examples/double-gauss/coated.yaml")
ghosts = []
for coat in ("{reflectance: 0.04}", "{film: single}", "{film: triple}"):
    run("trace", example, "-o", "design.raymap", "-n", 100000, "--force", "--quiet", "--set", f"surfaces.polished.coat={coat}")
    found = json.loads(run("query", "design.raymap", "registered(sensor where ghost_order >= 1)", "--count", "--json")[0])
    ghosts.append(found["rays"]["matched"])
assert ghosts[0] > 2 * ghosts[1] > 4 * ghosts[2] > 0, ghosts
