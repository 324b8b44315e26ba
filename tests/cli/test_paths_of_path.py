#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: `paths` of a criterion that is one path("...") alone, which it finds out by the steps that it
keys, says to the last digit what it says where columns decide: the same criterion, and one that holds
for every ray. Whether every ray, most, some, few or none match; for any view, limit, number of ranks and
threads."""
import itertools
import json
import os
import shutil
import subprocess

import served
from odd_scene import ODD

PROGRAM = os.environ["RAYMAP"]
EXAMPLES = os.path.join(os.environ["SOURCE_DIR"], "examples")

# With a source behind the things that scatter, so that any share of rays may match.
SCENE = ODD.replace("torch, type: point, at: [5, 0, -20]", "torch, type: point, at: [5, 0, 65]")
ALL = 'path("([TRIDdSFOAXKE]|V)*")'
# More cells see light than are remembered at once, but not of rays that go on behind the pane.
GATES = """
raymap: 1
units: mm
media:
  air: {index: 1}
surfaces:
  tinted: {type: mixture, reflect_specular: 0.1, transmit_specular: 0.6, transmit_diffuse: 0.1}
geometries:
  plate: {type: rectangle, size: [60, 60]}
objects:
  - {name: pane, geometry: plate, at: [0, 0, 40], surface: tinted, front: air, back: air}
sources:
  - {name: lamp, type: collimated, shape: {rectangle: [50, 50]}, direction: [0, 0, 1], medium: air}
detectors:
""" + "".join(f"  - {{name: gate{z}, type: plane, at: [0, 0, {z}], size: [50, 50], cells: [1000, 1000]}}\n"
              for z in (10, 15, 20, 25, 30))
VIEWS = [["--no-peaks", "--top", "all"], ["--no-peaks"], ["--top", "7"], ["--no-peaks", "--exact", "40"],
         ["--no-peaks", "--by", "object"], ["--no-peaks", "--no-events"], ["--no-peaks", "--collapse"],
         ["--no-peaks", "--sort", "length", "--matrix", "ghosts"]]


def run(*arguments, ranks=1):
    start = ["mpirun", "-np", str(ranks)] if ranks > 1 else []
    done = subprocess.run([*start, PROGRAM, *arguments], capture_output=True, text=True)
    assert done.returncode == 0, (arguments, done.returncode, done.stderr)
    return done.stdout


def trace(scene, name, *options):
    shutil.rmtree(name, ignore_errors=True)
    run("trace", scene, "-o", name, "--quiet", "--encoding", "plain", *options)
    return name


def paths(name, criterion, *options, ranks=1):
    if ranks > 1 or "--threads" in options:
        document = json.loads(run("paths", name, "--where", criterion, "--json", "--quiet", *options, ranks=ranks))
    else:
        document = served.ask("paths", name, "--where", criterion, *options)
    said = json.dumps(document).replace(json.dumps(criterion)[1:-1], "CRITERION")
    return document["rays"]["matched"], said


def check(name, n_ray, criteria):
    """Every view with the first criterion, the others with some of the views. Returns the shares of rays that
    matched."""
    shares = set()
    turn = itertools.count()
    for i, criterion in enumerate(criteria):
        for view in VIEWS if i == 0 else VIEWS[i % 3::3]:
            k = next(turn)
            n, want = paths(name, f"{criterion} and ray >= 0", *view)
            how = ["--threads", "2"] if k % 4 == 1 else []
            got = paths(name, criterion, *view, *how, ranks=2 if k % 16 == 5 else 1)
            assert got == (n, want), (name, criterion, view)
        shares.add(n / n_ray)
    return shares


def check_odd():
    with open("odd.yaml", "w") as file:
        file.write(SCENE)
    odd = trace("odd.yaml", "odd.raymap", "-n", "60000")
    shares = check(odd, 60000, [ALL, 'path("(.|V) (.|V)*")', 'path(".* X@glass") == 0',
                                'path(".* S .*") == 0', 'path("V@gate X") == 0', 'path(".* V@eye .*")',
                                'path(".* D@wall .*")', 'path("V@gate .*")', 'path(".* S .*")',
                                'path(".* D .* D .* D .*")', 'path("(.|V@gate)*") == 0'])
    assert min(shares) == 0 and max(shares) == 1, shares
    for least, most in ((0, 0.06), (0.06, 0.5), (0.5, 0.75), (0.75, 1)):
        assert any(least < share < most for share in shares), (least, most, shares)


def check_room():
    room = trace(os.path.join(EXAMPLES, "room", "scene.yaml"), "room.raymap", "-n", "40000")
    check(room, 40000, [ALL, 'path(".* D@floor .*")', 'path("D@floor .*") == 0'])


def check_peaks():
    """Rays that do not match take no room from cells of those that do."""
    with open("gates.yaml", "w") as file:
        file.write(GATES)
    gates = trace("gates.yaml", "gates.raymap", "-n", "180000")
    criterion = 'path(".* [RTd] .*")'
    n, want = paths(gates, f"{criterion} and ray >= 0")
    assert 0.75 < n / 180000 < 0.85 and want.count('"peak": {') == 3, (n, want)
    for threads in "1", "2":
        assert paths(gates, criterion, "--threads", threads) == (n, want), threads


check_odd()
check_room()
check_peaks()
print("all as expected")
