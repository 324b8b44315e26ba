#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Lux tables as lighting programs print them: the grid of EN 12464-1, values as text, CSV and JSON, labelled isolines; sources dimmed
after the trace and the maintenance factor, against each source asked alone; the daylight factor against an open sky."""
import csv
import json
import math
import pathlib

import served
from asking import check, finish, run

SCENE = """raymap: 1
units: cm
spectrum: {mode: rgb}
media: {air: {index: 1}}
surfaces: {grey: {type: lambert, reflectance: 0.5}}
geometries: {wall: {type: rectangle, size: [400, 300]}}
objects: [{name: wall, geometry: wall, at: [-200, 0, 150], rotate: [0, 90, 0], surface: grey, front: air, back: air}]
sources:
  - {name: lamp, type: area, shape: {rectangle: [60, 30]}, at: [50, 0, 200], direction: [0, 0, -1], flux: 3000 lm, medium: air}
  - {name: spot, type: point, at: [-100, 50, 180], direction: [0, 0, -1], distribution: {cone: 40}, flux: 700 lm, medium: air}
  - {name: sky, type: sky, kind: 1, horizontal: 8 klx, medium: air, toward: [plane, north]}
  - {name: sun, type: sun, irradiance: 50 klx, sun: [180, 40], medium: air, toward: [plane, north]}
detectors:
  - {name: plane, type: plane, at: [0, 0, 0], direction: [0, 0, 1], size: [300, 200], cells: [30, 20], side: front}
  - {name: north, type: plane, at: [0, 9000, 0], direction: [0, -1, 0], size: [300, 300], cells: 1, side: front}
"""
pathlib.Path("room.yaml").write_text(SCENE, encoding="utf-8")
run("trace", "room.yaml", "-o", "room.raymap", "-n", 60000, "--quiet", "--force")


def ask(*words, detector="plane", ranks=1):
    if ranks > 1 or "--receivers" in words:
        return json.loads(run("detector", "room.raymap", detector, "--json", *words, ranks=ranks))
    return served.ask("detector", "room.raymap", detector, *words)


def values(*words):
    return [v for row in ask("--cells", "6x4", "--table", *words)["table"]["value"] for v in row]


def check_dimming():
    alone = {name: values("--where", f"source({name})") for name in ("lamp", "spot", "sky", "sun")}
    for dim, factor in (("lamp=0.5,sky=0,sun=0", (0.5, 1, 0, 0)), ("s*=0.25,spot=2", (1, 2, 0.25, 0.25)), ("l?mp=0", (0, 1, 1, 1))):
        for maintenance in 1, 0.8:
            found = values("--dim", dim, "--maintenance", maintenance)
            want = [maintenance * sum(f * v for f, v in zip(factor, parts)) for parts in zip(*alone.values())]
            check(all(abs(a - b) <= 1e-9 * max(want) for a, b in zip(found, want)), f"--dim {dim} x {maintenance}: {found} {want}")
    full, off = ask(), ask("--dim", "spot=0,sky=0,sun=0", "--maintenance", 0.5)
    lamp = next(s for s in full["sources"] if s["source"] == "lamp")
    check(off["registrations"] == lamp["registrations"] and abs(off["flux"]["total"] / lamp["flux"] - 0.5) < 1e-12, f"{off['flux']} {lamp}")
    check(abs(off["flux"]["standard_error"] / lamp["standard_error"] - 0.5) < 1e-9, f"{off['flux']} {lamp}")
    check((off["maintenance"], off["dim"]) == (0.5, {"spot": 0, "sky": 0, "sun": 0}) and "dim" not in full, f"{off}")
    check(ask("--tally", "--dim", "spot=0,sky=0,sun=0", "--maintenance", 0.5)["flux"]["total"] == off["flux"]["total"], "--tally")
    check(ask("--dim", "lamp=0.5", ranks=3)["mean"] == ask("--dim", "lamp=0.5")["mean"], "one answer on any number of ranks")

    def mean(*words):
        return served.ask("stats", "room.raymap", "--of", "x(plane)", *words)

    lamp, spot = mean("--where", "source(lamp)"), mean("--where", "source(spot)")
    both = mean("--dim", "lamp=0.5,sky=0,sun=0")
    flux = 0.5 * lamp["flux"]["value"], spot["flux"]["value"]
    want = (flux[0] * lamp["mean"]["value"] + flux[1] * spot["mean"]["value"]) / sum(flux)
    check(abs(both["mean"]["value"] - want) < 1e-6 and abs(both["flux"]["value"] / sum(flux) - 1) < 1e-9, f"stats: {both['mean']} {want}")
    box = "voxels", "room.raymap", "--cells", 2, "--region", "0,0,0,99,99,99", "--json"
    light = [json.loads(run(*box, *more))["fluence_rate"]["total"]["value"] for more in ((), ("--maintenance", 0.8))]
    check(abs(light[1] / light[0] - 0.8) < 1e-9, f"voxels {light}")
    def wall(*words, ranks=1):
        return json.loads(run("irradiance", "room.raymap", "wall", "--cells", "100", "--json", *words, ranks=ranks))

    alone = {name: wall("--where", f"source({name})") for name in ("lamp", "spot", "sky", "sun")}
    dimmed = wall("--dim", "lamp=0.5,sky=0,s?n=2", "--maintenance", 0.8)
    for key in "flux", "absorbed":
        parts = [(f, alone[name][key]["value"]) for name, f in (("lamp", 0.4), ("spot", 0.8), ("sun", 1.6))]
        check(abs(dimmed[key]["value"] / sum(f * v for f, v in parts) - 1) < 1e-9, f"irradiance, {key}: {dimmed[key]} {parts}")
    error = math.hypot(*(f * alone[name]["flux"]["standard_error"] for name, f in (("lamp", 0.4), ("spot", 0.8), ("sun", 1.6))))
    check(abs(dimmed["flux"]["standard_error"] / error - 1) < 1e-6, f"irradiance: {dimmed['flux']} +- {error}")
    check((dimmed["maintenance"], dimmed["dim"]) == (0.8, {"lamp": 0.5, "sky": 0, "sun": 2}), f"{dimmed}")
    check(wall("--dim", "lamp=0.5,sky=0,s?n=2", "--maintenance", 0.8, ranks=2) == dimmed, "irradiance on two ranks")
    check("dimmed         maintenance factor 0.8; without lamp" in
          run("irradiance", "room.raymap", "wall", "--dim", "lamp=0", "--maintenance", 0.8), "irradiance says so")
    for words, status, said in ((("--dim", "lmp=0"), 3, "no source named 'lmp' in this map (did you mean 'lamp'?)"),
                                (("--dim", "nothing=0"), 3, "it has 'lamp'"), (("--dim", "lamp"), 2, "as lamp=0.5"),
                                (("--dim", "lamp=-1"), 2, "as lamp=0.5"), (("--maintenance", "1.2"), 2, "above 0 and up to 1")):
        told = run("detector", "room.raymap", "plane", *words, status=status)
        check(said in told, f"{words}: {told}")


def grid(a, b):
    """EN 12464-1:2021, 4.4, of an area of these sides in metres."""
    d = min(a, b) if max(a, b) >= 2 * min(a, b) else max(a, b)
    n = max(1, round(d / min(0.2 * 5 ** math.log10(d), 10)))
    across = max(1, round((a + b - d) / (d / n)))
    return (n, across) if d == a else (across, n)


def check_grids():
    sizes = ((1, 1), (2, 1.8), (5, 4), (10, 9), (3, 8), (40, 6), (100, 90), (2000, 1500))
    receivers = "".join(f" - {{name: g{k}, type: plane, at: [0, 0, -5], direction: [0, 0, 1], size: [{100 * a}, {100 * b}], cells: 1}}\n"
                        for k, (a, b) in enumerate(sizes))
    pathlib.Path("grids.yaml").write_text("detectors:\n" + receivers, encoding="utf-8")
    for k, (a, b) in enumerate(sizes):
        found = ask("--receivers", "grids.yaml", "--cells", "en12464", "--table", detector=f"g{k}")
        check(tuple(found["cells"]) == grid(a, b) == tuple(found["grid"]["points"]), f"{a} x {b}: {found['cells']} {found['grid']} {grid(a, b)}")
    # Of table A.1 of the standard.
    check([grid(d, d)[0] for d in (1, 2, 5, 10, 100)] == [5, 6, 8, 10, 20], "points of table A.1")
    found = ask("--cells", "en12464", "--table", "--region", "0,0,150,100")
    check(tuple(found["cells"]) == grid(1.5, 1) and abs(found["grid"]["spacing"][0] - 1.5 / found["cells"][0]) < 1e-12, f"{found['grid']}")
    check("of the area of a plane" in run("detector", "room.raymap", "plane", "--over", "direction", "--table", status=2), "--table of directions")


def check_tables():
    image = ask("--cells", "6x4", "--table", "--dim", "sky=0,sun=0")
    table = image["table"]
    check(table["x"] == [-125, -75, -25, 25, 75, 125] and table["y"] == [75, 25, -25, -75], f"{table}")
    run("detector", "room.raymap", "plane", "--cells", "6x4", "--dim", "sky=0,sun=0", "-o", "cells.csv", "--force")
    with open("cells.csv", encoding="utf-8") as file:
        cells = {(int(r["i"]), int(r["j"])): float(r["value"]) for r in csv.DictReader(line for line in file if not line.startswith("#"))}
    for row in range(4):
        for i in range(6):
            check(abs(table["value"][row][i] - cells[i, 3 - row]) < 1e-6, f"cell {i} {row}")
    text = run("detector", "room.raymap", "plane", "--cells", "6x4", "--table", "--dim", "sky=0,sun=0", "-o", "table.csv", "--force")
    lines = pathlib.Path("table.csv").read_text(encoding="utf-8").splitlines()
    head = dict(line[2:].split(": ") for line in lines if line.startswith("#"))
    rows = [[float(v) for v in line.split(",")] for line in lines if line[0] in "-0123456789"]
    check([r[0] for r in rows] == table["y"] and all(abs(a - b) < 1e-4 for r, t in zip(rows, table["value"]) for a, b in zip(r[1:], t)), f"{lines}")
    flat = [v for row in table["value"] for v in row]
    least, most, average = min(flat), max(flat), sum(flat) / len(flat)
    want = {"average": average, "minimum": least, "maximum": most, "U0": least / average, "Ud": least / most}
    check(all(abs(float(head[k]) / v - 1) < 1e-3 for k, v in want.items()), f"{head} {want}")
    check(f"U0 {least / average:.2f}, Ud {least / most:.2f}" in text and "dimmed         without sky, sun" in text, text)
    world = ask("--cells", "6x4", "--table", "--frame", "world", detector="north")["table"]
    check((world["across"], world["down"]) != ("x", "y") and {world["across"], world["down"]} == {"x", "z"}, f"{world}")
    run("detector", "room.raymap", "plane", "--isolines", "--levels", "150,333", "--dim", "sky=0,sun=0", "-o", "lines.svg", "--force")
    picture = pathlib.Path("lines.svg").read_text(encoding="utf-8")
    check(">150</text>" in picture and ">333</text>" in picture and "without sky, sun" in picture, "labels of the levels")
    check("numbers with commas" in run("detector", "room.raymap", "plane", "-o", "b.svg", "--isolines", "--levels", "1,x", status=2), "--levels")


def check_daylight():
    # Far from the wall the ground sees the whole sky, and what faces the horizon half of it: 0.396 of an overcast one
    # (Moon and Spencer 1942): (1/2 + 4/(3 pi)) / (7/3).
    shaded = ask("--quantity", "daylight_factor")
    check((shaded["quantity"], shaded["unit"]) == ("daylight factor", "%") and 50 < shaded["mean"]["value"] < 100, f"{shaded['mean']}")
    sky = ask("--where", "source(sky)", "--cells", 1)
    check(abs(shaded["mean"]["value"] - sky["mean"]["value"] / 80) < 1e-9 and shaded["registrations"] == sky["registrations"], f"{shaded} {sky}")
    north = ask("--quantity", "daylight_factor", detector="north")["mean"]
    want = 100 * (0.5 + 4 / (3 * math.pi)) / (7 / 3)
    check(abs(north["value"] - want) < 4 * north["standard_error"] < 3, f"facing the horizon: {north}, not {want}")
    check("leave --unit out" in run("detector", "room.raymap", "plane", "--quantity", "daylight_factor", "--unit", "fc", status=2), "--unit")
    pathlib.Path("dark.yaml").write_text("".join(line for line in SCENE.splitlines(True) if "klx" not in line), encoding="utf-8")
    run("trace", "dark.yaml", "-o", "dark.raymap", "-n", 100, "--quiet", "--force")
    told = run("detector", "dark.raymap", "plane", "--quantity", "daylight_factor", status=3)
    check("no light of a sky" in told and "type: sky" in told, told)


check_dimming()
check_grids()
check_tables()
check_daylight()
finish()
