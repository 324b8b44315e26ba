#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: `raymap glass` finds materials by pattern, by name with and without a maker, and by nd and vd; its indices are those of
their formulas; a scene traces with the catalogue's absorption as published."""
import json
import math
import os
import re
import subprocess
import sys

PROGRAM = os.environ["RAYMAP"]
failures = []


def check(good, what):
    if not good:
        failures.append(what)
        print("FAILED:", what)


def run(*words, status=0):
    done = subprocess.run([PROGRAM, *words], capture_output=True, text=True, check=False)
    check(done.returncode == status, f"{words}: status {done.returncode}, not {status}: {done.stderr}")
    return done


def glasses(*words):
    return json.loads(run("glass", *words, "--json").stdout)["glasses"]


def names(*words):
    return [f"{one['group']} {one['name']}" for one in glasses(*words)]


# Names and patterns
everything = glasses()
check(len(everything) > 1700, "some 1,700 materials")
check(len({(one["group"], one["name"].lower()) for one in everything}) == len(everything), "each name is there once in its group")
lak = names("n-lak*")
check("SCHOTT N-LAK8" in lak and all(re.fullmatch(r"SCHOTT N-LAK\w+", name) for name in lak), f"N-LAK*: {lak}")
for spelling in ("SCHOTT N-LAK8", "schott:n-lak8", "N-LAK8"):
    check(names(spelling) == ["SCHOTT N-LAK8"], spelling)
check(names("E-F2") == ["HOYA E-F2", "HIKARI E-F2"], "E-F2 is listed with all its makers")
check(names("metal:a?") == ["metal Ag", "metal Al", "metal Au"], "groups")
check(names("zz*") == [], "a pattern may match nothing")
check("N-SK10" in run("glass", "N-SK17", status=3).stderr, "the nearest names of an unknown one")

# Sellmeier's equation of N-LAK8, from SCHOTT's data sheet
B, C = (1.33183167, 0.546623206, 1.19084015), (0.00620023871, 0.0216465439, 82.5827736)
for nm in (486.1, 587.6, 656.3):
    index = math.sqrt(1 + sum(b * (nm * 1e-3) ** 2 / ((nm * 1e-3) ** 2 - c) for b, c in zip(B, C)))
    told = glasses("N-LAK8", "--at", str(nm))[0]["at"][0]
    check(abs(told["n"] - index) < 1e-14, f"index at {nm}: {told['n']} and {index}")
    check(f"{index:.6f}" in run("glass", "N-LAK8", "--at", str(nm)).stdout, f"index at {nm} in the table")
check(abs(glasses("N-BK7", "--at", "400")[0]["at"][0]["transmittance"] - 0.992 ** 0.4) < 1e-12, "transmittance of 10 mm")
check(glasses("N-BK7", "--at", "5000")[0]["at"][0]["n"] is None, "nothing is told outside the range")

# By nd and vd
near = glasses("--near", "1.6204,60.3", "--top", "3")
check(len(near) == 3 and all("16" in one["name"] for one in near), f"near SK16: {near}")
check(near[0]["distance"] <= near[1]["distance"] <= near[2]["distance"] < 0.1, "nearest first")
check(names("LZOS *", "--near", "1.5168,64.2", "--top", "1") == ["LZOS K8"], "of a maker")

# Wrong usage, and a picture
for words in (["--near", "1.5"], ["--at", "x"], ["--at", "-5"], ["--top", "3"], ["--near", "1.5,60", "--top", "0"], ["-o", "a.pdf"]):
    run("glass", *words, status=2)
run("glass", "N-*", "-o", "many.svg", status=3)
run("glass", "N-LAK8", "-o", "one.svg", "--force")
with open("one.svg", encoding="utf-8") as file:
    picture = file.read()
check("SCHOTT N-LAK8" in picture and "transmittance of 10 mm" in picture and picture.count("<path") + picture.count("<polyline") >= 2, "the picture")
run("glass", "N-LAK8", "-o", "one.svg", status=2)

# 20 mm of N-SF6 at 400 nm let through what is published for 25, to the power of 20/25.
SCENE = """\
raymap: 1
units: mm
spectrum: {mode: spectral, wavelengths: [400]}
media:
  air: {index: 1}
  sf6: {glass: n-sf6%s}
surfaces:
  clear: {type: fresnel, coat: ideal}
geometries:
  face: {type: rectangle, size: [90, 90]}
objects:
  - {name: one, geometry: face, surface: clear, front: sf6, back: air}
  - {name: two, geometry: face, at: [0, 0, 20], surface: clear, front: air, back: sf6}
sources:
  - {name: beam, type: collimated, shape: {disc: 3}, at: [0, 0, -9], direction: [0, 0, 1], flux: 1 W, medium: air}
"""
for said, share in (("", 1.0), (", absorption: catalogue", glasses("N-SF6", "--at", "400")[0]["at"][0]["transmittance"] ** 2)):
    with open("plate.yaml", "w", encoding="utf-8") as file:
        file.write(SCENE % said)
    run("trace", "plate.yaml", "-o", "plate.raymap", "-n", "100000", "--force", "--quiet")
    left = json.loads(run("query", "plate.raymap", "ended(left)", "--json").stdout)
    part = left["rays"]["matched"] / 100000
    check(abs(part - share) <= 4 * math.sqrt(share * (1 - share) / 100000), f"{part} of {share} goes through{said}")

print("failures:", len(failures))
sys.exit(bool(failures))
