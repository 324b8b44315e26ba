#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: what arrived on a detector that lies on an object and what was absorbed there can be
told apart, a table's top from its legs, by a criterion or by a detector on some faces alone; ghosts
are counted up to their registration. Plain and compact maps, receivers and ranks say the same."""
import json
import os
import pathlib
import subprocess
import sys

sys.dont_write_bytecode = True
from asking import check, finish  # noqa: E402

PROGRAM = os.environ["RAYMAP"]
TABLE = """v -5 -5 0
v 5 -5 0
v 5 5 0
v -5 5 0
v -5 -5 -4
v 5 -5 -4
v 5 5 -4
v -5 5 -4
g top
f 1 2 3 4
g legs
f 1 5 6 2
f 2 6 7 3
f 3 7 8 4
f 4 8 5 1
g foot
f 5 8 7 6
"""
SCENE = """raymap: 1
units: mm
media: {air: {index: 1}}
surfaces:
  grey: {type: lambert, reflectance: 0.5}
  cathode: {type: mixture, reflect_specular: 0.5, reflect_diffuse: 0.25}
  gauze: {type: mixture, reflect_specular: 0.5, transmit_specular: 0.5}
geometries:
  table: {type: mesh, file: table.obj}
  bulb: {type: sphere, radius: 60}
  pane: {type: disc, radius: 30}
objects:
  - {name: table, geometry: table, at: [0, 0, -20], surface: grey, inside: air, outside: air}
  - {name: tube, geometry: bulb, surface: cathode, inside: air, outside: air}
  - {name: gauze, geometry: pane, at: [0, 0, 20], surface: gauze, front: air, back: air}
sources: [{name: lamp, type: point, medium: air}]
detectors:
  - {name: cathode, type: plane, on: tube, cells: 4}
  - {name: whole, type: plane, on: table, cells: 4, direction: [0, 0, 1]}
  - {name: gate, type: plane, at: [0, 0, 10], size: 40, cells: 4, side: both}
"""
TOP = "  - {name: NAME, type: plane, on: {object: table, faces: FACES}, cells: [2, 3]}\n"
N = 3000


def program(*arguments, status=0, ranks=1):
    command = [PROGRAM, *arguments]
    if ranks > 1:
        command = ["mpirun", "-np", str(ranks), *command]
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != status:
        sys.exit(f"{' '.join(command)}: status {done.returncode}\n{done.stderr}")
    return done.stdout if status == 0 else done.stderr


def trace(name, text, *options, ranks=1):
    pathlib.Path("scene.yaml").write_text(text, encoding="utf-8")
    program("trace", "scene.yaml", "-o", name, "-n", str(N), "--quiet", "--force", *options, ranks=ranks)
    return json.loads(program("info", name, "--json"))["digest"]


def rays(target, *texts, ranks=1):
    out = json.loads(program("query", target, *texts, "--count", "--json", "--quiet", ranks=ranks))
    return [answer["rays"]["matched"] for answer in out]


def check_arrivals(target, ranks):
    """Registrations by how often a ray has them; what ends there was absorbed there."""
    arrived, taken, ended, both, neither = rays(
        target, "registered(cathode)", "registered(cathode where at(absorb))", "ended(absorbed, tube)",
        "registered(cathode where at(absorb) and at(reflect))", "registered(cathode where not at(*))", ranks=ranks)
    check(0 < taken == ended < arrived and both == neither == 0,
          f"{target}: {arrived} arrived, {taken} absorbed, {ended} ended")
    for n in range(1, 5):
        some, gone, back = rays(target, f"registered(cathode) == {n}",
                                f"registered(cathode) == {n} and registered(cathode where at(tube, absorb)) == 1",
                                f"registered(cathode) == {n} and registered(cathode where at(reflect)) == {n}")
        check(some == gone + back > 0, f"{target}: of {some} with {n} arrivals {gone} absorbed, {back} not")


def check_which(target):
    """A condition and its opposite choose two parts of an image; rays that end there are one of them."""
    for condition in ("at(absorb)", "at(face 0)", 'path(".* V@gate .*")'):
        name = "whole" if "face" in condition else "cathode"
        found = [json.loads(program("detector", target, name, "--json", *options))["registrations"]
                 for options in ((), ("--which", condition), ("--which", f"not {condition}"))]
        check(found[0] == found[1] + found[2] and min(found) > 0, f"{target}: {condition}: {found}")


def check_faces(target, ranks, *options):
    pairs = [("registered(top) == 2", "registered(whole where at(face 0)) == 2"),
             ("registered(top, rect(0, 0, 0.5, 1, rel))", "registered(whole where at(side front, face 0) and x <= 0)"),
             ("registered(rest where at(absorb))", "registered(whole where at(face 1..2, absorb))"),
             ("registered(top where at(face 1..2))", "ray < 0")]
    found = rays(target, *[text for pair in pairs for text in pair], *options, ranks=ranks)
    check(found[0::2] == found[1::2] and min(found[:6]) > 0, f"{target} {options}: {found}")


def check_history(target, ranks):
    """The gate stands before the gauze, which sends light back through it."""
    direct, back, again, counted = rays(
        target, "registered(gate where path(\"V\"))", "registered(gate where path(\"V R@gauze V\"))",
        "registered(gate where path(\".* V@gate .* V@gate\"))", "registered(gate) >= 2", ranks=ranks)
    check(0 < back <= again == counted < direct, f"{target}: {direct} {back} {again} {counted}")
    for begin in (".* R@gauze .*", ".* [RD]@tube V@cathode", ".* T@gauze .* R@tube .*"):
        upto, whole = rays(target, f'registered(gate where path("{begin} V@gate"))', f'path("{begin} V@gate .*")', ranks=ranks)
        check(upto == whole > 0, f"{target}: {begin}: {upto} up to the gate, {whole} whole histories")
    plain, ordered = rays(target, "registered(gate where ghost_order == 0)", "registered(gate where not path(\".* R@gauze .*\"))")
    check(plain >= ordered > 0, f"{target}: {plain} without ghosts, {ordered} without the gauze")


def check_mistakes():
    for faces, told in (("3", "there is no face 3: the mesh has 0 to 2"), ("2..1", "the range 2..1 runs backwards"),
                        ("[top, lid]", "the mesh has no face named 'lid'"), ("[]", "'faces' names none")):
        text = SCENE + TOP.replace("NAME", "top").replace("FACES", faces)
        pathlib.Path("wrong.yaml").write_text(text, encoding="utf-8")
        check(told in program("check", "wrong.yaml", status=3), f"{faces}: not told")
    pathlib.Path("wrong.yaml").write_text(SCENE.replace("on: tube", "on: {object: tube, faces: 0}"), encoding="utf-8")
    check("'faces' are of an object that is a mesh" in program("check", "wrong.yaml", status=3), "a sphere: not told")
    told = program("query", "plain.raymap", "registered(gate where at(absorb))", status=3)
    check("criterion:1:23: error: 'at' is of detectors that lie on an object" in told, told)


def main():
    pathlib.Path("table.obj").write_text(TABLE, encoding="utf-8")
    more = TOP.replace("NAME", "top").replace("FACES", "top") + \
        TOP.replace("NAME", "rest").replace("FACES", "[1, 2..2]").replace("cells", "direction: [0, 0, 1], cells")
    plain = trace("plain.raymap", SCENE + more, "--encoding", "plain")
    compact = trace("compact.raymap", SCENE + more, ranks=2)
    check(plain == compact, "encodings and ranks give other rays")
    trace("without.raymap", SCENE)
    pathlib.Path("more.yaml").write_text(more, encoding="utf-8")
    for target, ranks in (("plain.raymap", 2), ("compact.raymap", 1)):
        check_arrivals(target, ranks)
        check_faces(target, ranks)
        check_history(target, ranks)
        check_which(target)
    check_faces("without.raymap", 1, "--receivers", "more.yaml")
    check_mistakes()
    finish()


main()
