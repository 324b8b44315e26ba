#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: a variant of `raymap sweep` has the numbers, to the last bit, of a map that is traced with the same --set; for any number
of ranks and threads, and after being cut off; drawn values have the moments asked for; mistakes are told with their lines."""
import csv
import json
import math
import os
import pathlib
import shutil
import statistics
import sys

import h5py
import numpy

sys.dont_write_bytecode = True
from asking import SOURCE, check, finish, run  # noqa: E402

SCENE = os.path.join(SOURCE, "examples/double-gauss/scene.yaml")
SWEEP = f"""scene: {SCENE}
simulation: star_only
rays: 3000
seed: 5
parameters:
  defocus: {{keys: [objects.sensor_surface.at.3, detectors.sensor.at.3], plus: true, values: [-0.3, 0.25]}}
  black: {{key: surfaces.black.reflectance, values: [0.05, 0.5]}}
answers:
  spot: {{detector: sensor, of: rms_radius, where: registered(sensor where ghost_order == 0)}}
  light: {{flux: registered(sensor)}}
  peak: {{detector: sensor, of: peak}}
  path: {{statistic: path_length, where: hit(lens.3)}}
"""


def write(name, text):
    with open(name, "w", encoding="utf-8") as out:
        out.write(text)


def rows(folder):
    with open(f"{folder}/table.csv", encoding="utf-8") as table:
        return list(csv.DictReader(line for line in table if line[0] != "#"))


for old in ("one", "mended", "box", "box-maps", "box.raymap", "maps", "random", "m.raymap", "n.raymap", "ranks-2", "ranks-3", "failing"):
    shutil.rmtree(old, ignore_errors=True)
write("s.yaml", SWEEP)
run("sweep", "s.yaml", "-o", "one", "--quiet")
table = rows("one")
check(len(table) == 5, "the nominal variant and four")
z = 139.5658 - 0.3
run("trace", SCENE, "--simulation", "star_only", "-n", "3000", "--seed", "5", "-o", "m.raymap", "--quiet", "--set",
    f"objects.sensor_surface.at.3={z!r}", "--set", f"detectors.sensor.at.3={z!r}", "--set", "surfaces.black.reflectance=0.5")
spot = json.loads(run("detector", "m.raymap", "sensor", "--spot", "--where", "registered(sensor where ghost_order == 0)", "--json"))
image = json.loads(run("detector", "m.raymap", "sensor", "--json"))
light = json.loads(run("query", "m.raymap", "registered(sensor)", "--json"))
path = json.loads(run("stats", "m.raymap", "--of", "path_length", "--where", "hit(lens.3)", "--json"))
for name, told in (("spot", spot["spot"]["rms"]["radius"]), ("path", path["mean"])):
    check(float(table[2][name]) == told["value"] and float(table[2][name + "_error"]) == told["standard_error"], f"{name}: {table[2]} {told}")
check(float(table[2]["light"]) == light["flux"]["matched"], f"light: {table[2]} {light['flux']}")
peak = image["peak"]["value"] if isinstance(image["peak"], dict) else image["peak"]
check(float(table[2]["peak"]) == peak, f"peak: {table[2]} {image['peak']}")

for n in (2, 3):
    run("sweep", "s.yaml", "-o", f"ranks-{n}", "--quiet", ranks=n)
    check(rows(f"ranks-{n}") == table, f"{n} ranks")
with open("one/rows-00000.jsonl", "r+", encoding="utf-8") as journal:
    journal.truncate(500)
run("sweep", "s.yaml", "-o", "one", "--resume", "--quiet")
check(rows("one") == table, "resumed")
# The error of a difference: by 32 blocks of rays, asked of two maps; smaller than the errors of both; and as large as it says.
run("trace", SCENE, "--simulation", "star_only", "-n", "3000", "--seed", "5", "-o", "n.raymap", "--quiet")
parts = [f"registered(sensor) and ray >= {3000 * k / 32} and ray < {3000 * (k + 1) / 32}" for k in range(32)]
flux = [[one["flux"]["matched"] for one in json.loads(run("query", name, *parts, "--json"))] for name in ("m.raymap", "n.raymap")]
blocks = numpy.subtract(*flux)
difference = math.sqrt(32 * numpy.var(blocks, ddof=1))
check(math.isclose(float(table[2]["light_difference"]), sum(blocks), rel_tol=1e-9), f"{table[2]['light_difference']}, by blocks {sum(blocks)}")
check(math.isclose(float(table[2]["light_difference_error"]), difference, rel_tol=1e-9), f"{table[2]['light_difference_error']}, by blocks {difference}")
for name in ("light", "path"):
    check(float(table[2][name + "_difference_error"]) < 0.5 * float(table[2][name + "_error"]), f"{name}: {table[2]}")
check(table[2]["peak_difference_error"] == "", "extremes have no parts")
seen = []
for seed in range(12):
    write("seed.yaml", SWEEP.replace("seed: 5", f"seed: {100 + seed}").replace("[-0.3, 0.25]", "[-0.05]").replace("[0.05, 0.5]", "[0.5]"))
    run("sweep", "seed.yaml", "-o", "one-seed", "--quiet", "--force")
    seen.append(rows("one-seed")[1])
for name in ("spot", "light", "path"):
    scatter = statistics.stdev(float(row[name + "_difference"]) for row in seen)
    told = statistics.mean(float(row[name + "_difference_error"]) for row in seen)
    check(0.5 < scatter / told < 1.8, f"{name}: differences of 12 seeds scatter by {scatter}, and say {told}")

with h5py.File("one/table.h5") as h5:
    check(list(h5["sweep/variant"]) == list(range(5)), "variants in HDF5")
    for group, suffix in (("answer", ""), ("standard_error", "_error"), ("difference", "_difference"), ("difference_error", "_difference_error")):
        for name in ("spot", "light", "peak", "path"):
            want = [float(row[name + suffix] or "nan") for row in table]
            check(numpy.array_equal(h5[f"{group}/{name}"][:], want, equal_nan=True), f"{group}/{name}")
    check([float(row["defocus"]) for row in table] == list(h5["parameter/defocus"]), "a parameter in HDF5")
with open("one/plot.svg", encoding="utf-8") as picture:
    check("defocus" in picture.read(), "the picture names its axis")

# Rays that the variant before has, too, are taken over from it: with the same answers.
write("box.yaml", f"""scene: {os.path.join(SOURCE, "examples/room/scene.yaml")}
rays: 5000
parameters:
  ball: {{key: objects.ball_1.at.3, plus: true, values: [0.01, 0.02]}}
  wall: {{key: surfaces.white.reflectance, values: [0.8, 0.8]}}
answers: {{seen: {{rays: hit(ball_1)}}, long: {{statistic: path_length}}}}
""")
told = json.loads(run("sweep", "box.yaml", "-o", "box", "--json", "--quiet", "--force"))
check(told["rays_taken_over"] > 12000, f"taken over: {told['rays_taken_over']} of 25000")
run("trace", os.path.join(SOURCE, "examples/room/scene.yaml"), "-n", "5000", "-o", "box.raymap", "--quiet", "--force", "--set", "surfaces.white.reflectance=0.8",
    "--set", f"objects.ball_1.at.3={0.331 + 0.02!r}")
path = json.loads(run("stats", "box.raymap", "--of", "path_length", "--json"))
check(float(rows("box")[4]["long"]) == path["mean"]["value"], f"{rows('box')[4]} {path['mean']}")

write("box.yaml", open("box.yaml", encoding="utf-8").read() + "keep: maps\n")
told = json.loads(run("sweep", "box.yaml", "-o", "box-maps", "--json", "--quiet", "--force"))
check(told["rays_taken_over"] > 12000 and rows("box-maps") == rows("box"), f"maps, taken over: {told['rays_taken_over']}")
digests = [json.loads(run("info", name, "--json"))["digest"] for name in ("box.raymap", "box-maps/variant-000004.raymap")]
check(digests[0] == digests[1], f"a map made from another: {digests}")

# The scene's simulations as values.
write("sims.yaml", f"""scene: {SCENE}
rays: 2000
parameters: {{light: {{key: simulation, values: [quick, star_only]}}, black: {{key: surfaces.black.reflectance, values: [0.05, 0.5]}}}}
answers: {{star: {{rays: source(star)}}, all: {{flux: registered(sensor)}}}}
""")
run("sweep", "sims.yaml", "-o", "sims", "--quiet", "--force")
check([(row["light"], row["star"]) for row in rows("sims")] == [("", "500"), ("quick", "500"), ("quick", "500"), ("star_only", "2000"), ("star_only", "2000")], f"{rows('sims')}")
write("sims.yaml", open("sims.yaml", encoding="utf-8").read().replace("star_only]", "star_onyl]"))
error = run("sweep", "sims.yaml", "-o", "sims", "--force", status=3)
check("sims.yaml:3:" in error and "did you mean 'star_only'" in error, error)

# A variant that is no scene has a row that says so, and the others go on.
write("failing.yaml", f"""scene: {SCENE}
rays: 500
parameters: {{n: {{key: surfaces.black.reflectance, values: [0.1, -3, 0.7]}}}}
answers: {{all: {{flux: registered(sensor)}}}}
require: all > 0
""")
for ranks, more in ((1, ()), (2, ("--force",)), (1, ("--resume",))):
    told = json.loads(run("sweep", "failing.yaml", "-o", "failing", "--json", "--quiet", *more, ranks=ranks))
    table_of = rows("failing")
    check([row["all"] != "" for row in table_of] == [True, True, False, True] and "must be between" in table_of[2]["mistake"], f"{table_of}")
    check([("mistake" in row, row["met"]) for row in told["rows"]] == [(False, True), (False, True), (True, False), (False, True)], f"{told['rows']}")
    check(table_of[2]["mistake"].count("--set") == 1, f"{table_of[2]}")
    check(told["yield"]["met"] == 2 and told["yield"]["of"] == 3, f"{told['yield']}")

check("; 1 has no answers" in run("sweep", "failing.yaml", "-o", "failing", "--resume", "--quiet"), "one of three fails")
write("failing.yaml", open("failing.yaml", encoding="utf-8").read().replace("[0.1, -3, 0.7]", "[-1, -3, 7]"))
for ranks, more in ((1, ()), (2, ()), (1, ("--resume",))):
    error = run("sweep", "failing.yaml", "-o", "failing", "--quiet", *(more or ("--force",)), ranks=ranks, status=3)
    check("no variant has answers" in error and "must be between" in error, error)

error = run("sweep", "s.yaml", "-o", "one", status=2)
check("--resume" in error and "--force" in error, f"a folder that holds a sweep: {error}")
os.rename("one/sweep.txt", "sweep.txt")
for more in ((), ("--resume",)):
    error = run("sweep", "s.yaml", "-o", "one", *more, status=2)
    check("no sweep.txt" in error and os.listdir("one") and not os.path.exists("one/sweep.txt"), f"rows of who knows what: {error}")
os.rename("sweep.txt", "one/sweep.txt")
told = json.loads(run("sweep", "s.yaml", "-o", "one", "--force", "--json", "--quiet", "--plot", "p.png", "--force"))
check(rows("one") == table and 0 < told["seconds"]["tracing"] < told["seconds"]["all"], f"begun anew: {told['seconds']}")

write("maps.yaml", SWEEP + "keep: maps\n")
run("sweep", "maps.yaml", "-o", "maps", "--quiet")
check(rows("maps") == table, "answers of maps are those of rays in memory")
check(os.path.isdir("maps/variant-000004.raymap"), "maps are kept")

write("random.yaml", f"""scene: {SCENE}
rays: 1
samples: 1500
parameters:
  a: {{key: objects.cover.at.1, plus: true, distribution: {{normal: {{sigma: 0.01, mean: 0.02}}}}}}
  b: {{key: objects.cover.at.2, plus: true, distribution: {{uniform: {{from: -1.0e-3, to: 3.0e-3}}}}}}
answers: {{n: {{rays: all}}}}
require: n > 0
""")
told = json.loads(run("sweep", "random.yaml", "-o", "random", "--json", "--quiet"))
a = [float(row["a"]) for row in rows("random")[1:]]
b = [float(row["b"]) for row in rows("random")[1:]]
check(abs(statistics.mean(a) - 0.02) < 5 * 0.01 / 1500**0.5, "mean of a normal distribution")
check(abs(statistics.pstdev(a) / 0.01 - 1) < 5 / 3000**0.5, "its sigma")
check(min(b) >= -1e-3 and max(b) <= 3e-3 and abs(statistics.mean(b) - 1e-3) < 5 * 4e-3 / (12 * 1500) ** 0.5, "a uniform one")
check(told["yield"]["value"] == 1 and told["yield"]["of"] == 1500, f"yield {told['yield']}")

for old, new, words in (("objects.sensor_surface.at.3", "objects.sensor_surfce.at.3", ("s.yaml:6:", "did you mean 'sensor_surface'")),
                        ("rays: 3000", "rais: 3000", ("s.yaml:3:", "did you mean 'rays'")),
                        ("of: peak", "of: peek", ("s.yaml:11:", "peek")),
                        ("key: surfaces.black.reflectance", "key: detectors.sensor.at.3", ("s.yaml:7:10:", "'detectors.sensor.at.3' has values of 'defocus' already (line 6)")),
                        ("[objects.sensor_surface.at.3, d", "[detectors.1.at.3, d", ("s.yaml:6:12:", "'detectors.sensor.at.3' has values of 'defocus' already")),
                        ("values: [-0.3, 0.25]", "values: [x]", ("s.yaml:6:", "no number"))):
    write("s.yaml", SWEEP.replace(old, new))
    error = run("sweep", "s.yaml", "-o", "bad", status=3)
    check(all(word in error for word in words), f"{new}: {error}")
for old, new, words in (("registered(sensor)}", "registered(sensr)}", ("s.yaml:10: answer 'light'", "did you mean 'sensor'")),
                        ("{detector: sensor, of: peak}", "{detector: sensr, of: peak}", ("variant 0: s.yaml:11: answer 'peak'", "did you mean 'sensor'"))):
    write("s.yaml", SWEEP.replace(old, new))
    error = run("sweep", "s.yaml", "-o", "mended", "--quiet", status=3)
    check(all(word in error for word in words), f"{new}: {error}")
write("s.yaml", SWEEP)
run("sweep", "s.yaml", "-o", "mended", "--quiet")
write("s.yaml", SWEEP.replace("0.25", "0.26"))
error = run("sweep", "s.yaml", "-o", "one", "--resume", status=3)
check("line 6 of s.yaml was '..." in error and " 0.25]}'" in error and " 0.26]}'" in error, f"another sweep: {error}")

# A number of the scene that has a unit: row 0 and the values are in the parameter's unit, or row 0 has it as it stands.
def places(more, unit=", unit: mm"):
    write("units.yaml", f"""scene: {SCENE}
rays: 500
parameters: {{z: {{key: objects.sensor_surface.at.3, {more}{unit}}}}}
answers: {{spot: {{detector: sensor, of: rms_radius}}, light: {{rays: hit(sensor_surface)}}}}
""")
    run("sweep", "units.yaml", "-o", "units", "--quiet", "--force", "--set", "objects.sensor_surface.at.3=13.9 cm")
    return rows("units")


plain, added, own = places("values: [138, 139]"), places("plus: true, values: [-1, 0]"), places("values: [138, 139]", "")
check([row["z"] for row in plain] == ["139", "138", "139"] and [row["z"] for row in own] == ["13.9 cm", "138", "139"], f"{plain}\n{own}")
check([row["z"] for row in added] == ["0", "-1", "0"] and [(row["spot"], row["light"]) for row in added] == [(row["spot"], row["light"]) for row in plain], f"{plain}\n{added}")

# Rows of one scene: neither its files nor the tracer may have changed. Earlier programs did not say which they were.
PLATE = "v 0 0 {0}\nv 1 0 {0}\nv 0 1 {0}\nf 1 2 3\n"
write("plate.obj", PLATE.format(1))
write("plate.yaml", """raymap: 1
media: {air: {index: 1}}
surfaces: {black: {type: absorber}}
geometries: {plate: {type: mesh, file: plate.obj}}
objects: [{name: plate, geometry: plate, surface: black, front: air, at: [0, 0, 0]}]
include: [lamp.yaml]
""")
write("lamp.yaml", "# A lamp\nsources: [{name: lamp, type: point, direction: [0, 0, 1], distribution: {cone: 60}, flux: 1 W, medium: air}]\n")
write("files.yaml", "scene: plate.yaml\nrays: 500\nparameters: {x: {key: objects.plate.at.1, values: [0.1, 0.2, 0.3]}}\nanswers: {n: {rays: hit(plate)}}\n")
told = run("sweep", "files.yaml", "-o", "files", "--quiet", "--force")
check("slope" in told and "nan" not in told, f"three values leave no error of a slope: {told}")
state = pathlib.Path("files/sweep.txt").read_text(encoding="utf-8")
write("plate.obj", PLATE.format(2))
error = run("sweep", "files.yaml", "-o", "files", "--resume", status=3)
check("files holds another sweep: meshes or other files" in error, error)
write("plate.obj", PLATE.format(1))
write("files/sweep.txt", state.replace(" tracer ", " tracer 9"))
error = run("sweep", "files.yaml", "-o", "files", "--resume", status=3)
check("another revision of the tracer" in error, error)
write("files/sweep.txt", state.replace("cone: 60", "cone: 61").replace(" tracer ", " tracer 9"))
error = run("sweep", "files.yaml", "-o", "files", "--resume", status=3)
check("line 2 of lamp.yaml was '..." in error and "cone: 61" in error and "cone: 60" in error, error)
error = run("sweep", "files.yaml", "-o", "files", "--resume", "--set", "limits.steps=9", status=3)
check("line 1 of --set was '' and is '--set limits.steps=9'" in error, error)
write("other.obj", PLATE.format(1))
write("meshes.yaml", "scene: plate.yaml\nrays: 500\nparameters: {mesh: {key: geometries.plate.file, values: [plate.obj, other.obj]}}\nanswers: {n: {rays: hit(plate)}}\n")
run("sweep", "meshes.yaml", "-o", "meshes", "--quiet", "--force")
run("sweep", "meshes.yaml", "-o", "meshes", "--quiet", "--resume")
write("other.obj", PLATE.format(2))
error = run("sweep", "meshes.yaml", "-o", "meshes", "--resume", status=3)
check("meshes holds another sweep: meshes or other files" in error, error)
for text in (state, state.split("\n", 1)[1]):
    write("files/sweep.txt", text)
    run("sweep", "files.yaml", "-o", "files", "--resume", "--quiet", ranks=2)
finish()
