#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Colour of light on detectors (CIE 15, CIE 13.3-1995, Ohno 2014): XYZ, x y, u' v', CCT, Duv and CRI of illuminants, of light that a coloured plate sends
back, of cells and in lm, against sums over the tables here; x and y are those that are published, by sums over 1 nm. The tables are the program's, the sums are not."""
import csv
import json
import math
import os
import re
import subprocess

import numpy

from raymap import Checks, run, write_scene

checks = Checks()
SOURCE = os.environ["SOURCE_DIR"]
NM = numpy.arange(380, 781, 5)


def table(name, of, columns):
    """Numbers of a table in the sources."""
    text = open(os.path.join(SOURCE, "src/optics", of), encoding="utf-8").read()
    body = re.search(re.escape(name) + r" = \{(.*?)\};", text, re.S)
    return numpy.array([float(x) for x in re.findall(r"(?<!\w)-?\d+\.?\d*(?:e[+-]\d+)?", body[1])]).reshape(-1, columns)


BAR = table("cmf[CMF_N][3]", "spectrum.c", 3)[4:85]
ALL_BAR, ALL_NM = table("cmf[CMF_N][3]", "spectrum.c", 3), numpy.arange(360, 831, 5)


def cubic(t):
    """What four values one step apart count at t in 0 to 1 between the middle two (Lagrange)."""
    return numpy.array([-t * (t - 1) * (t - 2) / 6, (t + 1) * (t - 1) * (t - 2) / 2, -(t + 1) * t * (t - 2) / 2, (t + 1) * t * (t - 1) / 6])


def summed(power):
    """XYZ as the CIE sums it: over 1 nm, the spectrum straight between 5 nm, the observer smooth."""
    total = numpy.zeros(3)
    for row in range(80):
        for k in range(5):
            bar = cubic(k / 5) @ ALL_BAR[row + 3:row + 7]
            total += 0.2 * (power[row] + k / 5 * (power[row + 1] - power[row])) * bar
    return total


SAMPLES = table("sample[RMAP_CRI_SAMPLES][SAMPLE_N]", "colour_rendering.c", 81) / 1000
DAY = table("daylight[3][RMAP_ILLUMINANT_N]", "illuminant.c", 107)[:, 16:97]
LAMPS = table("f2[LAMP_N]", "illuminant.c", 81)


def planck(kelvin, nm):
    return nm ** -5.0 / numpy.expm1(1.438776877e7 / (nm * kelvin))


def daylight(kelvin):
    t = 1000 / kelvin
    x = 0.244063 + t * (0.09911 + t * (2.9678 - 4.607 * t)) if kelvin <= 7000 else 0.23704 + t * (0.24748 + t * (1.9018 - 2.0064 * t))
    y = -3 * x * x + 2.87 * x - 0.275
    m = 0.0241 + 0.2562 * x - 0.7341 * y
    return DAY[0] + (-1.3515 - 1.7703 * x + 5.9114 * y) / m * DAY[1] + (0.03 - 31.4424 * x + 30.0717 * y) / m * DAY[2]


def power_of(name):
    if name == "A":
        return planck(2855.5, NM.astype(float))
    if name == "D65":
        return daylight(6504)
    return LAMPS[int(name == "F11")]


def uv(xyz):
    return numpy.array([4 * xyz[0], 6 * xyz[1]]) / (xyz[0] + 15 * xyz[1] + 3 * xyz[2])


def temperature(xyz):
    """By trying: the nearest of Planck's radiators."""
    at = uv(xyz)

    def away(mired):
        return at - uv(planck(1e6 / mired, ALL_NM.astype(float)) @ ALL_BAR)

    low, high = 20.0, 900.0
    for _ in range(60):
        a, b = high - (high - low) / 1.618033988749895, low + (high - low) / 1.618033988749895
        if math.hypot(*away(a)) < math.hypot(*away(b)):
            high = b
        else:
            low = a
    off = away(low)
    return 1e6 / low, math.copysign(math.hypot(*off), off[1])


def rendering(power, kelvin):
    reference = planck(kelvin, NM.astype(float)) if kelvin < 5000 else daylight(kelvin)

    def seen(light):
        xyz = (SAMPLES * light) @ BAR
        return uv(light @ BAR), [uv(s) for s in xyz], 100 * xyz[:, 1] / (light @ BAR)[1]

    def cd(at):
        return (4 - at[0] - 10 * at[1]) / at[1], (1.708 * at[1] + 0.404 - 1.481 * at[0]) / at[1]

    (white, there, y_there), (grey, here, y_here) = seen(reference), seen(power)
    values = []
    for k in range(14):
        c, d = (cd(white)[i] / cd(grey)[i] * cd(here[k])[i] for i in range(2))
        adapted = numpy.array([10.872 + 0.404 * c - 4 * d, 5.520]) / (16.518 + 1.481 * c - d)
        w = [25 * y ** (1 / 3) - 17 for y in (y_there[k], y_here[k])]
        a, b = 13 * w[0] * (there[k] - white), 13 * w[1] * (adapted - white)
        values.append(100 - 4.6 * math.sqrt((w[0] - w[1]) ** 2 + (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2))
    return values


def ask(*arguments, ranks=1):
    if ranks == 1:
        return json.loads(run(*arguments, "--json", "--quiet"))
    return json.loads(subprocess.run(["mpirun", "-np", str(ranks), os.environ["RAYMAP"], *map(str, arguments), "--json", "--quiet"],
                                     capture_output=True, text=True, check=True).stdout)


def judge(what, colour, power, flux, area, luminous=False):
    """Of light with this power on the wavelengths; flux in W, or in lm."""
    xyz = summed(power)
    xyz *= flux / area * (1 if luminous else 683 * (power @ BAR)[1] / power.sum()) / xyz[1]
    kelvin, duv = temperature(xyz)
    coarse = 6 if luminous else 1  # a map keeps shares of lm in steps of 1/65535: blue has few of them
    checks.close(what + " XYZ", colour["XYZ"], list(xyz), rel=4e-4 * coarse)
    checks.close(what + " xy", colour["xy"], list(xyz[:2] / xyz.sum()), abs=1e-4 * coarse)
    checks.close(what + " uv", colour["uv"], [uv(xyz)[0], 1.5 * uv(xyz)[1]], abs=1e-4 * coarse)
    checks.close(what + " CCT", colour["cct"], kelvin, rel=5e-4 * coarse)
    checks.close(what + " Duv", colour["duv"], duv, abs=5e-5 * coarse)
    special = rendering(power, kelvin)
    checks.close(what + " R", colour["cri"]["R"], special, abs=0.3 * coarse)
    checks.close(what + " Ra", colour["cri"]["Ra"], sum(special[:8]) / 8, abs=0.1 * coarse)


HEAD = """raymap: 1
units: m
spectrum: {{mode: {mode}, wavelengths: {nm}}}
media: {{air: {{index: 1}}}}
"""
LAMP = "  - {{name: {name}, type: collimated, at: [{x}, 0, 0], direction: [0, 0, 1], shape: {{disc: 0.1}}, flux: {flux}, medium: air{more}}}\n"
SCREEN = "  - {{name: {name}, type: plane, at: [0, 0, {z}], size: [4, 1], cells: [4, 1]{more}}}\n"
FINE = "{from: 380, to: 780, step: 5}"


def trace(name, lamps, mode="spectral", nm=FINE, rays=4000, more="", side=""):
    text = HEAD.format(mode=mode, nm=nm) + more + "sources:\n" + "".join(LAMP.format(**lamp) for lamp in lamps)
    text += "detectors:\n" + SCREEN.format(name="eye", z=1, more=", response: xyz" + side) + SCREEN.format(name="plain", z=2, more="")
    run("trace", write_scene(name, text), "-o", name + ".raymap", "-n", rays, "--force", "--quiet")
    return name + ".raymap"


PUBLISHED = {"A": (0.44757, 0.40745, 2856, 100), "D65": (0.31272, 0.32903, 6504, 100), "F2": (0.37208, 0.37529, 4230, 64),
             "F11": (0.38052, 0.37713, 4000, 83)}
lamps = [{"name": name, "x": k - 1.5, "flux": f"{k + 1} W", "more": f", spectrum: {name}"} for k, name in enumerate(PUBLISHED)]
each = trace("each", lamps)
for k, (name, (x, y, kelvin, general)) in enumerate(PUBLISHED.items()):
    found = ask("detector", each, "plain", "--xyz", "--where", f"source({name})")["colour"]
    checks.close(f"published xy of {name}", found["xy"], [x, y], abs=1e-4)
    checks.close(f"published CCT of {name}", found["cct"], kelvin, abs=8)
    checks.close(f"published Ra of {name}", found["cri"]["Ra"], general, abs=0.5)
    checks.true(f"unit of {name}", found["unit"] == "lx" and found["reason"] == {})
    judge(name, found, power_of(name), k + 1, 4)

d50 = trace("d50", [{"name": "D50", "x": 0, "flux": "1 W", "more": ", spectrum: D50"}], rays=100)
checks.close("published xy of D50", ask("detector", d50, "plain", "--xyz")["colour"]["xy"], [0.34567, 0.35851], abs=1e-4)

# what the detector makes of it by itself, of all and of each cell; the same for any ranks; Y is the illuminance
total = sum((power_of(name) / power_of(name).sum() * (k + 1) for k, name in enumerate(PUBLISHED)), numpy.zeros(81))
answer = ask("detector", each, "eye")
judge("all", answer["colour"], total, 10, 4)
checks.close("Y", answer["colour"]["XYZ"][1], answer["mean"]["value"], rel=1e-6)
checks.close("Y's error", answer["colour"]["standard_error"]["XYZ"][1], answer["mean"]["standard_error"], abs=3e-4)
for ranks in (2, 3):
    checks.true(f"{ranks} ranks", ask("detector", each, "eye", ranks=ranks) == answer)
checks.true("no colour unless asked for", "colour" not in ask("detector", each, "plain"))
run("detector", each, "eye", "--quantity", "spectral", "-o", "cells.csv", "-o", "cells.h5", "-o", "cells.npz", "--quiet", "--force")
cells = list(csv.DictReader(line for line in open("cells.csv", encoding="utf-8") if line[0] != "#"))
data = numpy.load("cells.npz")
for k, (name, (x, y, kelvin, general)) in enumerate(PUBLISHED.items()):
    checks.close(f"cell of {name}", [float(cells[k]["chromaticity_x"]), float(cells[k]["chromaticity_y"])], [x, y], abs=1e-4)
    checks.close(f"Ra in the cell of {name}", float(cells[k]["Ra"]), general, abs=0.5)
    checks.close(f"CCT in the cell of {name}", data["CCT"][0][k], kelvin, abs=8)
    checks.close(f"Y in the cell of {name}", data["Y"][0][k], data["value"][0][k], rel=1e-5)
    checks.close(f"spectrum of the cell of {name}", data["spectral"][:, 0, k].sum(), data["value"][0][k], rel=1e-4)


def refused(text, *arguments):
    done = subprocess.run([os.environ["RAYMAP"], *map(str, arguments)], capture_output=True, text=True, check=False)
    checks.true(f"{arguments}: {done.stderr}", done.returncode and text in done.stderr)


# in true colour a value is white, in the unit of the values; D65 of so many lx is the white of sRGB
y65 = data["Y"][0][1]
run("detector", each, "eye", "--color", "true", "--white", y65, "--unit", "lx", "-o", "white.svg", "-o", "rgb.npz", "--quiet", "--force")
checks.true("white", f"white at {y65:.3g} lx" in open("white.svg", encoding="utf-8").read())
checks.close("linear sRGB of D65", list(numpy.load("rgb.npz")["rgb"][0][1] / y65), [1, 1, 1], abs=1e-3)
refused("give --color true", "detector", each, "eye", "-o", "x.svg", "--color", "false", "--white", "3")

# sources in lm: the same light
lumens = trace("lumens", [{**lamp, "flux": lamp["flux"].replace("W", "lm")} for lamp in lamps])
for k, name in enumerate(PUBLISHED):
    judge(name + " in lm", ask("detector", lumens, "plain", "--xyz", "--where", f"source({name})")["colour"], power_of(name), k + 1, 4, True)

# errors: of two kinds of light by turns, x and CCT vary as the shares do
mixed = trace("mixed", [{**lamps[0], "flux": "1 W", "x": 0}, {**lamps[1], "flux": "1 W", "x": 0}], rays=400)
answer = ask("detector", mixed, "eye", "--region=-0.05,-0.05,0.05,0.05")
error = answer["colour"]["standard_error"]
a, d = (683 * (power_of(n) / power_of(n).sum()) @ BAR for n in ("A", "D65"))
hits = {n: ask("detector", mixed, "eye", "--region=-0.05,-0.05,0.05,0.05", "--where", f"source({n})")["registrations"] for n in ("A", "D65")}
both = a * hits["A"] + d * hits["D65"]
spread = {n: hits[n] * (200 - hits[n]) / 199 for n in hits}  # variance of how many of 200 fall there
slope = {n: (v[0] - both[0] / both.sum() * v.sum()) / both.sum() for n, v in (("A", a), ("D65", d))}
checks.close("error of x", error["xy"][0], math.sqrt(sum(spread[n] * slope[n] ** 2 for n in slope)), rel=0.02)
checks.true("error of CCT", 0 < error["cct"] < 1000)

# red, green and blue have XYZ and a colour temperature, and no spectrum; in W they have no lm
more = """surfaces:
  green: {type: mirror, reflectance: {rgb: [0, 1, 0]}}
geometries:
  plate: {type: rectangle, size: [2, 2]}
objects:
  - {name: plate, geometry: plate, surface: green, at: [0, 0, 1.5], front: air, back: air}
"""
white = {"name": "white", "x": 0, "flux": "100 lm", "more": ", spectrum: {rgb: [1, 1, 1]}"}
rgb = trace("rgb", [white], mode="rgb")
found = ask("detector", rgb, "eye")["colour"]
checks.close("rgb white", found["XYZ"], [25 * 0.3127 / 0.3290, 25, 25 * 0.3583 / 0.3290], rel=1e-3)
checks.close("rgb CCT", found["cct"], 6504, abs=10)
checks.true("rgb CRI", found["cri"] is None and "no spectrum" in found["reason"]["cri"])
checks.true("rgb white is shown as white", min(found["sRGB"]) >= 254)
back = trace("back", [white], mode="rgb", more=more, side=", side: back")
found = ask("detector", back, "eye", "--where", "registered(eye)")
checks.close("green left of white", found["colour"]["XYZ"], [25 * 0.7152 * 0.3 / 0.6, 25 * 0.7152, 25 * 0.7152 * 0.1 / 0.6], rel=1e-2)
checks.close("illuminance of it", found["mean"]["value"], 25 * 0.7152, rel=2e-2)

# one wavelength; three; none that is seen; a response of its own; a spectrum that is not said
laser = trace("laser", [{"name": "hene", "x": 0, "flux": "1 W", "more": ", spectrum: {lines: {555: 1}}"}], nm="[555]", rays=100)
found = ask("detector", laser, "plain", "--xyz")["colour"]
checks.close("a watt of 555 nm", found["XYZ"][1], 683 / 4, rel=1e-6)
checks.true("a line has no CCT", found["cct"] is None and found["duv"] is None and "one wavelength" in found["reason"]["cct"])
checks.true("a line has no CRI", found["cri"] is None and "20 nm apart" in found["reason"]["cri"])
heat = trace("heat", [{"name": "ir", "x": 0, "flux": "1 W", "more": ", spectrum: {lines: {1064: 1}}"}], nm="[1064]", rays=100)
found = ask("detector", heat, "plain", "--xyz")["colour"]
checks.true("no light", found["XYZ"] == [0, 0, 0] and found["xy"] == [None, None] and "no light" in found["reason"]["cct"])


lines = trace("lines", [{"name": "three", "x": 0, "flux": "1 W", "more": ", spectrum: {lines: {486.13: 1, 587.56: 1, 656.27: 1}}"}], nm="[486.13, 587.56, 656.27]", rays=100)
done = subprocess.run([os.environ["RAYMAP"], "detector", lines, "plain", "--xyz"], capture_output=True, text=True, check=True)
checks.true("three lines", "do not carry V(lambda)" in done.stderr and "CRI            none: it takes wavelengths" in done.stdout)
guess = trace("guess", [{"name": "lamp", "x": 0, "flux": "1 lm", "more": ""}], rays=100)
refused("does not say the spectrum of source 'lamp'", "detector", guess, "plain", "--xyz")
checks.true("guessed spectra have no colour", "colour" not in ask("detector", guess, "eye"))
refused("--tally", "detector", each, "plain", "--xyz", "--tally")
checks.finish()
