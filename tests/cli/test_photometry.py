#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Data sheets of luminaires and glare: beam and field angle and cd/klm of a file of cos^n and of its traced far field; UGR of an observer
by hand, with a luminaire half hidden, and with the background of an integrating sphere; the table of a Lambertian luminaire."""
import json
import math
import pathlib
import re
import sys

import asking
from asking import check, finish, run

sys.path.insert(0, str(asking.SOURCE / "tests" / "physics"))
import lamp_files  # noqa: E402
from lamp_files import steps  # noqa: E402


def lamp(power_x, power_y=None):
    """cos^n in the plane C 0, another n in C 90, of 1000 cd on the axis."""
    power_y = power_y or power_x

    def function(d):
        turn = d[0] ** 2 / max(d[0] ** 2 + d[1] ** 2, 1e-30)
        return 1000 * max(d[2], 0) ** (power_x * turn + power_y * (1 - turn))
    return function


def write(name, text):
    pathlib.Path(name).write_text(text, encoding="latin-1")
    return name


def ies(function, size=(0, 0, 0)):
    return lamp_files.ies(function, "C", steps(0, 360, 15), steps(0, 180, 1), size=size)


HEAD = "raymap: 1\nunits: m\nspectrum: {mode: rgb}\nmedia: {air: {index: 1}}\n"


def scene(name, sources, more=""):
    return write(name, HEAD + "sources:\n" + "".join(f"  - {{{s}, medium: air}}\n" for s in sources) + more)


def check_sheets():
    write("narrow.ies", ies(lamp(20)))
    write("oval.ldt", lamp_files.eulumdat(lamp(8, 2), 0, planes=24, gammas=181))
    write("aside.ies", ies(lambda d: 500 * max(0, (d[0] + d[2]) / math.sqrt(2)) ** 40))
    write("up.ies", ies(lambda d: lamp(5)((d[0], d[1], -d[2]))))
    scene("lamps.yaml", [f"name: {f.split('.')[0]}, type: lamp, file: {f}" for f in ("narrow.ies", "oval.ldt", "aside.ies", "up.ies")])
    document = json.loads(run("check", "lamps.yaml", "--json", "--lamp", "narrow", "--planes", "0,37.5,90,200", "--gammas", "0,10.5,45"))
    found = {s["source"]: s for s in document["scene"]["lamps"]}

    def width(n, part):
        return 2 * math.degrees(math.acos(part ** (1 / n)))

    for name, n in (("narrow", (20, 20)), ("oval", (8, 2)), ("up", (5, 5))):
        for plane, power in zip(found[name]["planes"], n):
            want = width(power, 0.5), width(power, 0.1)
            check(all(abs(plane[k] - w) < 0.05 for k, w in zip(("beam_angle", "field_angle"), want)), f"{name}: {plane} {want}")
            check(abs(plane["peak_gamma"] - (180 if name == "up" else 0)) < 0.11, f"{name}: {plane}")
    tilted = found["aside"]["planes"][0]  # about 45 degrees towards C 0: all of the beam on that side
    check(abs(tilted["beam_angle"] - width(40, 0.5)) < 0.1 and abs(tilted["peak_gamma"] - 45) < 0.11 and tilted["peak_C"] == 0, f"{tilted}")
    sheet = document["lamp"]
    check(sheet["C"] == [0, 37.5, 90, 200] and sheet["gamma"] == [0, 10.5, 45], f"{sheet}")
    for gamma, row, per_klm in zip(sheet["gamma"], sheet["intensity"], sheet["per_klm"]):
        want = math.cos(math.radians(gamma)) ** 20
        check(all(abs(v / (1000 * want) - 1) < 2e-3 for v in row), f"cd at {gamma}: {row}")
        check(all(abs(v / (1000 * 21 / (2 * math.pi) * want) - 1) < 3e-3 for v in per_klm), f"cd/klm at {gamma}: {per_klm}")
    check("ugr" not in sheet, "a point has no table of glare")
    text = run("check", "lamps.yaml", "--lamp", "oval")
    check("C90-C270" in text and "/klm" in text and "UGR: none" in text and "beam angle (50 %) 47.0" in text, text)
    check("did you mean 'narrow'" in run("check", "lamps.yaml", "--lamp", "narow", status=3), "nearest lamp")
    scene("other.yaml", ["name: bulb, type: point, flux: 9 lm", "name: narrow, type: lamp, file: narrow.ies, at: [9, 0, 0]"])
    told = run("check", "other.yaml", "--lamp", "bulb", status=3)
    where = re.search(r"other.yaml:(\d+):\d+: source 'bulb' is not by a lamp maker's file \(did you mean 'narrow'", told)
    check(where and "name: bulb" in open("other.yaml", encoding="utf-8").read().splitlines()[int(where[1]) - 1], told)
    scene("other.yaml", ["name: bulb, type: point"])
    check("other.yaml: no lamp named 'narow' by" in (told := run("check", "other.yaml", "--lamp", "narow", status=3)) and "type: lamp, file" in told, told)
    check("--gammas: 200" in run("check", "lamps.yaml", "--lamp", "oval", "--gammas", "200", status=2), "gamma")

    grid = "detectors: [{name: far, type: intensity, cells: [30, 8]}, {name: near, type: plane, at: [0, 0, 1], size: 1, cells: 2}]\n"
    scene("far.yaml", ["name: oval, type: lamp, file: oval.ldt"], grid)
    run("trace", "far.yaml", "-o", "far.raymap", "-n", 400000, "-q", "--force")
    sheets = [json.loads(run("detector", "far.raymap", "far", "--photometry", "--gammas", "0,20,40", "--json", ranks=r)) for r in (1, 2)]
    check(sheets[0] == sheets[1], "one answer on any number of ranks")
    far = sheets[0]["photometry"]
    for plane, power in zip(far["planes"], (8, 2)):
        check(abs(plane["beam_angle"] - width(power, 0.5)) < 4, f"traced: {plane}")
    for k, n in enumerate((8, 2, 8, 2)):
        check(abs(far["intensity"][1][k] / (1000 * math.cos(math.radians(20)) ** n) - 1) < 0.15, f"traced cd at 20 degrees: {far['intensity']}")
    check(abs(far["flux"]["total"] / found["oval"]["flux"]["total"] - 1) < 0.01, f"{far['flux']}")
    check(abs(far["per_klm"][0][0] / far["intensity"][0][0] * far["flux"]["total"] / 1000 - 1) < 1e-9, "cd/klm of the detector")
    told = run("detector", "far.raymap", "near", "--photometry", status=2)
    check("no intensity grid" in told, told)


def check_narrow():
    """Beams that the angles do not resolve keep their flux, and are told; those that they resolve keep it angle by angle."""
    beams = {"cone": "type: point, direction: [0, 0, 1], cone: 3", "aside": "type: point, direction: [0.6, 0.3, 0.8], cone: 2",
             "wide": "type: point, direction: [0, 0, 1], cone: 90"}
    for name, beam in beams.items():
        scene("beam.yaml", [f"name: beam, {beam}, flux: 100 lm"], "detectors: [{name: far, type: intensity, cells: [18, 12]}]\n")
        run("trace", "beam.yaml", "-o", "beam.raymap", "-n", 20000, "-q", "--force")
        for cells in "18x1", "18x12", "90x36":
            for file in "beam.ies", "beam.ldt":
                told = run("detector", "beam.raymap", "far", "--cells", cells, "-o", file, "--force", both=True)
                check(("beams come out too wide" in told) == (name != "wide"), f"{name} in {cells}: {told}")
                scene("again.yaml", [f"name: beam, type: lamp, file: {file}"])
                flux = json.loads(run("check", "again.yaml", "--json", "--lamp", "beam"))["lamp"]["flux"]["total"]
                check(abs(flux - 100) < 1e-4, f"{name} in {cells}: {flux} of 100 lm in {file}")


A = 0.09  # of the luminaire's opening, m2
LAMBERT = ies(lamp(1), size=(0.3, 0.3, 0))  # L = 1000 cd / A, whatever the direction


def rating(background, luminaires):
    """luminaires: luminance, gamma, distance, p."""
    return 8 * math.log10(0.25 / background * sum(
        L ** 2 * A * math.cos(math.radians(g)) / r ** 2 / p ** 2 for L, g, r, p in luminaires))


def check_observer():
    write("panel.ies", LAMBERT)
    plate = ("geometries: {plate: {type: rectangle, size: [4, 4]}}\n"
             "objects: [{name: plate, geometry: plate, at: [1, 2, 0.5], rotate: [0, 90, 0], surface: absorber, front: air, back: air}]\n")
    hang = "type: lamp, file: panel.ies, rotate: [180, 0, 0]"
    sources = [f"name: ahead, {hang}, at: [2, 0, 1]", f"name: aside, {hang}, at: [2, -2, 1]", f"name: behind, {hang}, at: [-2, 0, 1]",
               "name: bulb, type: point, at: [2, 0, 1], flux: 100 lm",
               "name: area, type: area, shape: {rectangle: [0.3, 0.3]}, at: [4, 0, 2], direction: [0, 0, -1], flux: 3141.5926535897933 lm",
               f"name: wall, {hang}, at: [2, 2, 1]"]
    scene("open.yaml", sources)
    scene("shut.yaml", sources, plate)
    L = 1000 / A
    for path in "open", "shut":
        run("trace", f"{path}.yaml", "-o", f"{path}.raymap", "-n", 100, "-q", "--force")

    def ask(path, *more):
        return json.loads(run("glare", f"{path}.raymap", "--at", "0,0,0", "--look", "1,0,0", "--background", 40, "--json", *more))

    gamma, side = math.degrees(math.atan(2)), math.degrees(math.atan(math.sqrt(8)))
    ahead, far = (L, gamma, math.sqrt(5), 2.86), (L, gamma, math.sqrt(20), 2.86)
    aside = (L, side, 3, 3.91)
    found = ask("open")
    want = rating(40, [ahead, far, aside, aside])
    check(abs(found["ugr"]["value"] - want) < 0.01, f"open: {found['ugr']}, not {want}")
    role = {l["source"]: l["role"] for l in found["luminaires"]}
    check(role == {"ahead": "counts", "aside": "counts", "behind": "out of view", "bulb": "no opening", "area": "counts", "wall": "counts"}, f"{role}")
    first = found["luminaires"][0]
    check(abs(first["position_index"] - 2.86) < 1e-6 and abs(first["luminance"] / L - 1) < 2e-3, f"{first}")
    dimmed = ask("open", "--dim", "a*=0.5,wall=0")
    want = rating(40, [(0.5 * v[0], *v[1:]) for v in (ahead, far, aside)])
    check(abs(dimmed["ugr"]["value"] - want) < 0.01 and dimmed["luminaires"][5]["role"] == "off", f"dimmed: {dimmed['ugr']}, not {want}")
    half = ask("shut")  # half of what is straight ahead, nothing of what hangs behind the plate
    light = {l["source"]: l for l in half["luminaires"]}
    check(light["wall"]["role"] == "hidden" and light["ahead"]["visible"] == 0.5, f"{light}")
    check(abs(half["sum"] - (found["sum"] / 2)) < 0.01 * found["sum"], f"{half['sum']} {found['sum']}")
    for words, said in ((("--at", "0,0,0"), "say who looks"), (("--at", "0,0", "--look", "1,0,0"), "three numbers"),
                        (("--at", "0,0,0", "--look", "0,0,1"), "straight up"), (("--at", "0,0,0", "--look", "0,0,0"), "no direction")):
        told = run("glare", "open.raymap", *words, status=2)
        check(said in told, f"{words}: {told}")


def check_background():
    """In an integrating sphere with an even light in its middle every wall has the same luminance, so a plane anywhere in it gets
    phi / A rho / (1 - rho) indirectly."""
    ball = ("geometries: {ball: {type: sphere, radius: 3}}\nsurfaces: {white: {type: lambert, reflectance: 0.6}}\n"
            "objects: [{name: ball, geometry: ball, surface: white, inside: air, outside: air}]\n")
    scene("ball.yaml", ["name: bulb, type: point, flux: 20000 lm",
                        "name: panel, type: lamp, file: panel.ies, flux: 2 lm, at: [2, 0, 0.5], rotate: [180, 0, 0], rays_share: 0.01"], ball)
    run("trace", "ball.yaml", "-o", "ball.raymap", "-n", 400000, "-q", "--force")
    words = "glare", "ball.raymap", "--at", "1,0,0", "--look", "1,0,0", "--eye", 1
    found = json.loads(run(*words, "--json"))
    indirect = 20000 / (4 * math.pi * 9) * 0.6 / 0.4
    error = found["indirect"]["standard_error"]
    check(abs(found["indirect"]["value"] - indirect) < 4 * error < 0.1 * indirect, f"{found['indirect']}, not {indirect}")
    check(abs(found["background"] - found["indirect"]["value"] / math.pi) < 1e-9, f"{found['background']}")
    L = 2 / math.pi / A  # of 1000 cd there are 1000 pi lm
    want = rating(found["background"], [(L, math.degrees(math.atan(2)), math.hypot(1, 0.5), 2.86)])
    check(abs(found["ugr"]["value"] - want) < 0.02, f"{found['ugr']}, not {want}")
    check(abs(found["ugr"]["standard_error"] - 8 / math.log(10) * error / found["indirect"]["value"]) < 1e-9, f"{found['ugr']}")
    check(json.loads(run(*words, "--json", ranks=2)) == found, "one answer on any number of ranks")
    text = run(*words, "--maintenance", 0.5)
    half = json.loads(run(*words, "--maintenance", 0.5, "--json"))
    check(abs(half["ugr"]["value"] - found["ugr"]["value"] - 8 * math.log10(0.5)) < 1e-9 and "maintenance factor 0.5" in text, f"{half['ugr']}")


def form_factor(x, y):
    """Between opposite x y at distance 1, by numbers: of a point, and over one of them."""
    n, total = 24, 0.0
    for i in range(n):
        for j in range(n):
            px, py = (i + 0.5) * x / n, (j + 0.5) * y / n
            for a in (px, x - px):  # a quarter each (Siegel and Howell, B-3)
                for b in (py, y - py):
                    h, k = math.hypot(1, a), math.hypot(1, b)
                    total += (a / h * math.atan(b / h) + b / k * math.atan(a / k)) / (2 * math.pi)
    return total / n ** 2


def check_table():
    """Of a Lambertian opening: the floor's direct share is the form factor of the ceiling. p by Levin's fit, within 0.4 of the table's."""
    scene("panel.yaml", ["name: panel, type: lamp, file: panel.ies"])
    table = json.loads(run("check", "panel.yaml", "--lamp", "panel", "--json"))["lamp"]["ugr"]
    check(len(table["rooms"]) == 19, "19 rooms")
    check(all(abs(a - b) < 1e-3 for r, s in zip(table["crosswise"], table["endwise"]) for a, b in zip(r, s)), "as seen from all sides alike")
    lumens, L, S, H = 1000 * math.pi, 1000 / A, 0.25, 2.0

    def index(aside, above):
        tau, sigma = math.degrees(math.atan2(aside, above)), math.degrees(math.atan(math.hypot(aside, above)))
        return math.exp((35.2 - 0.31889 * tau - 1.22 * math.exp(-2 * tau / 9)) * 1e-3 * sigma + (21 + 0.26667 * tau - 0.002963 * tau ** 2) * 1e-5 * sigma ** 2)

    for x, y in ((2, 2), (4, 8)):
        floor = form_factor(x, y)
        walls, area = 2 * (x + y), x * y
        back = (1 - floor) * area / walls
        for column, (ceiling, wall, ground) in enumerate(table["reflectances"]):
            first = [floor / area, (1 - floor) / walls, 0]
            light = [0, 0, 0]
            for _ in range(200):
                out = [ground * light[0], wall * light[1], ceiling * light[2]]
                light = [first[0] + (1 - floor) * out[1] + floor * out[2], first[1] + back * (out[0] + out[2]) + (1 - 2 * back) * out[1],
                         first[2] + (1 - floor) * out[1] + floor * out[0]]
            n = round(x / S) * round(y / S)
            background = lumens * n * (light[1] - first[1]) / H ** 2 / math.pi
            total = 0
            for i in range(round(x / S)):
                for j in range(round(y / S)):
                    aside, ahead = abs((i + 0.5) * S - x / 2), (j + 0.5) * S
                    if aside > 3 * ahead or ahead < 1 / 1.9 or math.hypot(aside, ahead) > math.tan(math.radians(85)):
                        continue
                    r2 = (aside ** 2 + ahead ** 2 + 1) * H ** 2
                    total += L ** 2 * A * H / math.sqrt(r2) / r2 / index(aside / ahead, 1 / ahead) ** 2
            want = 8 * math.log10(0.25 / background * total)
            found = table["crosswise"][table["rooms"].index([x, y])][column]
            check(abs(found - want) < 0.4, f"{x}H {y}H, {ceiling, wall, ground}: {found}, not {want}")
    wide = lamp_files.ies(lamp(1), "C", [0], steps(0, 180, 1), size=(0.3, 1.2, 0))
    write("panel.ies", wide)
    wide = json.loads(run("check", "panel.yaml", "--lamp", "panel", "--json"))["lamp"]["ugr"]
    check(abs(wide["crosswise"][0][0] - table["crosswise"][0][0] + 8 * math.log10(4)) < 0.01, "four times the area: a quarter of L^2 omega")
    # Light to one side alone: which of the two opposite lines of sight is the worse does not hang on how the luminaire is turned.
    aside = lamp_files.ies(lambda d: 1000 * max(d[2], 0) * (1 + 0.9 * d[0] - 0.3 * d[1]), "C", steps(0, 360, 15), steps(0, 180, 5), size=(0.3, 0.6, 0))
    write("panel.ies", aside)
    turned = [json.loads(run("check", "panel.yaml", "--lamp", "panel", "--json", "--set", f"sources.panel.spin={spin}"))["lamp"]["ugr"] for spin in (0, 180)]
    write("panel.ies", lamp_files.ies(lambda d: 1000 * max(d[2], 0) * (1 - 0.9 * d[0] + 0.3 * d[1]), "C", steps(0, 360, 15), steps(0, 180, 5), size=(0.3, 0.6, 0)))
    turned.append(json.loads(run("check", "panel.yaml", "--lamp", "panel", "--json"))["lamp"]["ugr"])
    rows = [sum(one["crosswise"] + one["endwise"], []) for one in turned]
    check(max(abs(a - b) for k in (1, 2) for a, b in zip(rows[0], rows[k])) < 0.02, "the worse of C 0 and C 180, of C 90 and C 270")
    check(abs(rows[0][0] - table["crosswise"][0][0]) > 0.5, "which is not that of a symmetric one")


check_sheets()
check_observer()
check_background()
check_table()
finish()
