#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The event of a ray, by the numbers of its source's file: criteria, statistics, tables, CSV and reports know it, in either encoding, on
any number of ranks. Rays fly straight through air at two plates, so that all readings are worked out here from the file's rows."""
import csv
import json
import pathlib

import asking
import h5py
import numpy as np
import ray_files
from asking import check, run

N = 3000
ROWS = 5000  # more rays than rows
dice = np.random.default_rng(29)
place = dice.uniform(-1, 1, (N, 3))  # mm
right = dice.random(N) < 0.6
way = np.column_stack([*dice.uniform(-0.3, 0.3, (2, N)), np.where(right, 1.0, -1.0)])
way /= np.linalg.norm(way, axis=1)[:, None]
nm = dice.choice([450.0, 550.0, 650.0], N)
time = dice.uniform(0, 20, N)  # ns
event = np.sort(dice.choice(np.array([3, 4, 10, 11, 12, 500, 2**40]), N))
dice.shuffle(event)
row = np.arange(ROWS) % N
SCENE = """raymap: 1
units: mm
time: on
spectrum: {wavelengths: [450, 550, 650]}
media: {air: {index: 1}}
geometries: {plate: {type: rectangle, size: [400, 400]}}
objects:
  - {name: plate_r, geometry: plate, at: [0, 0, 100], surface: absorber}
  - {name: plate_l, geometry: plate, at: [0, 0, -200], surface: absorber}
sources: [{name: led, type: ray_file, file: rays.csv, medium: air, flux: FLUX}MORE]
detectors:
  - {name: right, type: plane, on: plate_r, cells: 4 RIGHT}
  - {name: left, type: plane, on: plate_l, cells: 4, direction: [0, 0, 1] LEFT}
"""


def scene(name, flux=f"{ROWS} W", more="", right_more="", left_more=""):
    text = SCENE.replace("FLUX", flux).replace("MORE", more).replace("RIGHT", right_more).replace("LEFT", left_more)
    pathlib.Path(name).write_text(text, encoding="utf-8")
    return name


def matched(target, what):
    return json.loads(run("query", target, what, "--count", "--json"))["rays"]["matched"]


def check_number():
    ray_files.csv("rays.csv", "x (mm),y (mm),z (mm),dx,dy,dz,wavelength,time (ns),event", *place.T, *way.T, nm, time, event)
    of = event[row]
    for target, encoding, ranks in (("p.raymap", "plain", 1), ("c.raymap", "compact", 2)):
        run("trace", scene("a.yaml"), "-o", target, "-n", ROWS, "--quiet", "--force", "--encoding", encoding, ranks=ranks)
        for what, rows in (("event == 10", of == 10), ("event != 10", of != 10), ("event in 4..11", (of >= 4) & (of <= 11)), ("event > 12", of > 12),
                           (f"event == {2**40}", of == 2**40), ("event < 3", of < 3), ("event <= 3.5", of <= 3),
                           ("event == 10 and registered(right)", (of == 10) & right[row]), ("event(absorb) and event == 4", of == 4)):
            check(matched(target, what) == rows.sum(), f"{target}: {what}: {matched(target, what)} not {rows.sum()}")
        told = json.loads(run("stats", target, "--of", "event", "--json", "--where", "event < 1000"))
        check(abs(told["mean"]["value"] - of[of < 1000].mean()) < 1e-9, f"stats: {told}")
        run("query", target, "all", "-o", "t.h5", "--force", "--columns", "ray/id,ray/event,registration/event")
        with h5py.File("t.h5") as file:
            check(np.array_equal(file["ray/event"], of.astype(float)), f"{target}: column of rays")
            check(np.array_equal(file["registration/event"], of.astype(float)), f"{target}: column of registrations")
        run("query", target, "ray in 5..9", "-o", "t.csv", "--force")
        with open("t.csv", encoding="utf-8", newline="") as file:
            check([int(line["event"]) for line in csv.DictReader(file)] == list(of[5:10]), "CSV")
        check(json.loads(run("report", target, 4321, "--json"))["event"] == of[4321], "report")
    check(json.loads(run("report", "a.yaml", "--ray", 4321, "--json"))["event"] == of[4321], "traced again")
    said = run("query", "p.raymap", "registered(right where event == 3)", status=3)
    check("is of the whole ray, not of a registration" in said, said)


def check_none():
    ray_files.csv("rays.csv", "x (mm),y (mm),z (mm),dx,dy,dz", *place.T, *way.T)
    run("trace", scene("n.yaml"), "-o", "n.raymap", "-n", 100, "--quiet", "--force")
    check("no source of this map numbers events" in run("query", "n.raymap", "event == 3", status=3), "no events")
    check("no source of this map numbers events" in run("stats", "n.raymap", "--of", "event", status=3), "no events in stats")
    ray_files.csv("rays.csv", "x (mm),y (mm),z (mm),dx,dy,dz,wavelength,time (ns),event", *place.T, *way.T, nm, time, event)
    lamp = ", {name: lamp, type: point, medium: air, flux: 1 W}"
    run("trace", scene("m.yaml", more=lamp), "-o", "m.raymap", "-n", 100, "--quiet", "--force")
    check(matched("m.raymap", "event >= 0") == matched("m.raymap", "source(led)") == 50, "a lamp's rays have none")
    check(matched("m.raymap", "event != 3 and source(lamp)") == 0, "which holds for no comparison")


check_number()
check_none()
asking.finish()
