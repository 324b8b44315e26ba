#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: `detector` tells least, percentiles and uniformities whose errors hold for fewer rays, each source's part, writes
several files at once, and leaves digits without meaning out of CSV; `trace` ends with each detector's registrations and flux; without a map also with -q."""
import csv
import json
import os
import subprocess
import sys
import tempfile

ROOM = os.path.join(os.environ["SOURCE_DIR"], "examples", "room", "scene.yaml")
GAUSS = os.path.join(os.environ["SOURCE_DIR"], "examples", "double-gauss", "scene.yaml")
failures = []
os.chdir(tempfile.mkdtemp(dir="."))


def check(holds, what):
    if not holds:
        failures.append(what)


def run(*words, status=0):
    done = subprocess.run([os.environ["RAYMAP"], *map(str, words)], capture_output=True, text=True, check=False)
    check(done.returncode == status, f"{words}: status {done.returncode}, not {status}: {done.stderr}")
    return done.stdout


run("trace", GAUSS, "-n", "20000", "-o", "lens.raymap", "-q")
text = run("trace", GAUSS, "-n", "20000", "--no-record", "-q")
document = json.loads(run("trace", GAUSS, "-n", "20000", "--no-record", "--json"))
image = json.loads(run("detector", "lens.raymap", "sensor", "--json"))
caught, = document["detectors"]
check("detectors\n  sensor" in text, "trace without a map ends with the detectors, also -q")
check(caught["name"] == "sensor" and caught["registrations"] == image["registrations"], f"registrations {caught}")
check(abs(caught["flux"]["total"] / image["flux"]["total"] - 1) < 1e-12, f"flux {caught}")
check(abs(sum(s["flux"] for s in image["sources"]) / image["flux"]["total"] - 1) < 1e-12, f"sources {image['sources']}")
check(sum(s["registrations"] for s in image["sources"]) == image["registrations"], "registrations of the sources")
alone = json.loads(run("detector", "lens.raymap", "sensor", "--where", "source(star)", "--json"))
star, = [s for s in image["sources"] if s["source"] == "star"]
check(star["flux"] == alone["flux"]["total"] and star["standard_error"] == alone["flux"]["standard_error"], f"{star} {alone['flux']}")
table = run("detector", "lens.raymap", "sensor", "--by", "source", "--cells", "6x4", "-o", "a.csv", "-o", "a.png", "-o", "a.npy")
check("star " in table and "share" in table, table)
check(all(os.path.getsize(name) > 0 for name in ("a.csv", "a.png", "a.npy")), "three files")
run("detector", "lens.raymap", "sensor", "--by", "colour", status=2)

image = json.loads(run("detector", "lens.raymap", "sensor", "--cells", "6x4", "--json"))
with open("a.csv", encoding="utf-8") as file:
    rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
total = sum(float(row["value"]) for row in rows) / len(rows)
check(abs(total - image["mean"]["value"]) < 1e-6 * image["mean"]["standard_error"], f"sum of CSV {total} {image['mean']}")
check(all(len(row["value"]) <= 12 for row in rows), f"digits: {[row['value'] for row in rows]}")

# in other units, and in the world: the sensor looks along -z, with its x axis along that of the world
other = json.loads(run("detector", "lens.raymap", "sensor", "--cells", "6x4", "--unit", "mW/cm2", "--frame", "world", "--json"))
check(other["unit"] == "mW/cm2" and abs(other["mean"]["value"] / image["mean"]["value"] - 0.1) < 1e-9, f"{other['mean']} {image['mean']}")
check(other["frame"] == "world" and abs(other["peak"]["z"] - 139.5658) < 1e-4 and other["peak"]["x"] == image["peak"]["x"], f"{other['peak']}")
run("detector", "lens.raymap", "sensor", "--unit", "lx", status=2)
run("detector", "lens.raymap", "sensor", "--frame", "wolrd", status=2)
# fewer cells where they hold few registrations, whatever their number before; the flux stays
even = """raymap: 1
sources: [{name: s, type: point, distribution: {cone: 33}, flux: 9 lm}]
detectors: [{name: d, type: plane, at: [0, 0, 9], direction: [0, 0, -1], size: 8, cells: 200}, {name: far, type: intensity, cells: [180, 36]}]
"""
with open("even.yaml", "w", encoding="utf-8") as file:
    file.write(even)
run("trace", "even.yaml", "-n", "4000", "-o", "even.raymap", "-q")
noisy = json.loads(run("detector", "even.raymap", "d", "--json"))
joined = json.loads(run("detector", "even.raymap", "d", "--json", "--cells", "auto"))
check(10 <= joined["cells"][0] == joined["cells"][1] <= 14 and joined["flux"] == noisy["flux"], f"{joined['cells']} {joined['flux']} {noisy['flux']}")
run("detector", "even.raymap", "d", "--cells", "automatic", status=2)
run("detector", "even.raymap", "far", "-o", "far.svg")
with open("far.svg", encoding="utf-8") as file:
    check(">40</text>" in (far := file.read()) and ">50</text>" not in far, "theta from 0 to 40 degrees")
for region, words in (("0,40,20,90", ["--rotate", "30"]), ("0,300,20,350", ["--rotate", "40"]), ("10,-30,30,20", []), ("10,0,30,360", ["--rotate", "10"])):
    part = json.loads(run("detector", "even.raymap", "far", "--region", region, *words, "--json"))
    place = json.loads(run("query", "even.raymap", part["region"]["criterion"], "--json"))
    check(part["registrations"] > 100 and abs(place["rays"]["matched"] - part["registrations"]) <= 2, f"{part['region']}: {place['rays']}")
with open("wall.yaml", "w", encoding="utf-8") as file:
    file.write("raymap: 1\nmedia: {air: {index: 1}}\nsurfaces: {black: {type: absorber}}\ngeometries: {wall: {type: rectangle, size: [4, 2]}}\n"
               "objects: [{name: wall, geometry: wall, at: [10, 0, 5], surface: black}]\n"
               "sources: [{name: s, type: collimated, at: [10.5, 0.3, 4], shape: {disc: 0.1}, medium: air}]\ndetectors:\n"
               " - {name: d, type: plane, on: wall, at: [10, 0, 5], rotate: [180, 180, 0], size: [4, 2], cells: [40, 20]}\n")
run("trace", "wall.yaml", "-n", "2000", "-o", "wall.raymap", "-q")
run("detector", "wall.raymap", "d", "--frame", "world", "-o", "wall.csv", "-o", "wall.svg", "-o", "wall.npz")
with open("wall.csv", encoding="utf-8") as file:
    lit = [row for row in csv.DictReader(line for line in file if not line.startswith("#")) if float(row["value"]) > 0]
check(lit and all(10.3 < float(r["x"]) < 10.7 and 0.1 < float(r["y"]) < 0.5 and float(r["z"]) == 5 for r in lit), f"{lit[:3]}")
place = json.loads(run("query", "wall.raymap", "registered(d where world_x in 10.35..10.65 and world_y in 0.15..0.45) and start_x > 10.35 and start_z == 4", "--json"))
check(place["rays"]["matched"] == 2000, f"{place['rays']}")
for criterion, n in (("rect(10.35, 0.15, 10.65, 0.45, world)", 2000), ("ellipse(10.5, 0.3, 0.11, 0.11, world)", 2000), ("rect(9.35, 0.15, 9.65, 0.45, world)", 0)):
    place = json.loads(run("query", "wall.raymap", f"registered(d, {criterion})", "--json"))
    check(place["rays"]["matched"] == n, f"{criterion}: {place['rays']}")
part = json.loads(run("detector", "wall.raymap", "d", "--frame", "world", "--region", "10.35,0.15,10.5,0.45", "--json"))
check(900 < part["registrations"] < 1100 and 10.35 < part["peak"]["x"] < 10.5, f"{part['registrations']} {part['peak']}")
place = json.loads(run("query", "wall.raymap", part["region"]["criterion"], "--json"))
check(place["rays"]["matched"] == part["registrations"], f"{part['region']}: {place['rays']}")
run("detector", "wall.raymap", "d", "--frame", "world", "--rotate", "20", "--region", "10,0,11,1", status=2)

run("detector", "wall.raymap", "d", "--over", "direction", "--plot", "polar.svg")
with open("polar.svg", encoding="utf-8") as file:
    check("C90" in file.read(), "the polar diagram has its planes")
run("detector", "wall.raymap", "d", "--plot", "p.svg", status=2)
run("detector", "wall.raymap", "d", "--over", "direction", "--plot", "p.csv", status=2)

run("detector", "wall.raymap", "d", "--cells", "4x2", "--values", "--unit", "mW/mm2", "--isolines", "-o", "plan.svg")
with open("plan.svg", encoding="utf-8") as file:
    plan = file.read()
cells = json.loads(run("detector", "wall.raymap", "d", "--cells", "4x2", "--unit", "mW/mm2", "--json"))
check(cells["peak"]["value"] >= 1000 and f">{cells['peak']['value']:.0f}</text>" in plan and plan.count(">0</text>") >= 4, "values of cells")
run("detector", "wall.raymap", "d", "--cells", "200x100", "--values", "-o", "p.svg", status=2)

# of few rays and of many: within the errors, once the noise is taken off
found = []
for rays in (25000, 400000):
    run("trace", ROOM, "-n", rays, "-o", f"{rays}.raymap", "-q")
    found.append(json.loads(run("detector", f"{rays}.raymap", "floor_map", "--cells", "12x8", "--json")))
for name in ("U0", "Ud"):
    few, many = (f["uniformity"][name] for f in found)
    distance = abs((few["value"] - few["bias"]) - (many["value"] - many["bias"]))
    check(distance < 3 * (few["standard_error"] ** 2 + many["standard_error"] ** 2) ** 0.5, f"{name}: {few} {many}")
    check(few["bias"] < many["bias"] < 0.3 * few["standard_error"] and many["standard_error"] < few["standard_error"] / 2, f"{name}: {few} {many}")
order = [p["value"] for p in found[1]["percentiles"]]
check(order == sorted(order) and found[1]["least"]["value"] <= order[0] and order[-1] <= found[1]["greatest"]["value"], str(order))
print("\n".join(failures) or "as promised")
sys.exit(bool(failures))
