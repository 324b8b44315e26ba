#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""`raymap import` and `update` of STEP: places are written as a person would, and are those of the file to 1e-9 mm; attributes outlive
another name of the root; chord and angle are remembered; a converter that crashes or hangs is an error with the file's name."""
import json
import os
import pathlib
import re
import shutil
import stat
import subprocess
import time

from cad_tools import MAKER, STEP, check, finish  # skips where there is no converter
import numpy as np
import yaml


def run(*words, status=0, program=os.environ["RAYMAP"]):
    done = subprocess.run([program, *map(str, words)], text=True, capture_output=True, check=False, timeout=120)
    check(done.returncode == status, f"{words}: {done.returncode} {done.stderr}")
    return done


def text(name):
    return pathlib.Path(name).read_text(encoding="utf-8")


def turned(x, y, z):
    """About x, then y, then z."""
    (cx, cy, cz), (sx, sy, sz) = np.cos(np.radians([x, y, z])), np.sin(np.radians([x, y, z]))
    return np.array([[cz, -sz, 0], [sz, cz, 0], [0, 0, 1]]) @ [[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]] @ [[1, 0, 0], [0, cx, -sx], [0, sx, cx]]


def place(node):
    m = np.eye(4)
    if "matrix" in node:
        m[:3] = np.reshape(node["matrix"], (3, 4))
    else:
        m[:3, :3] = turned(*node.get("rotate", [0, 0, 0])) * node.get("scale", 1)
        m[:3, 3] = node.get("at", [0, 0, 0])
    return m


def leaves(nodes, above=np.eye(4)):
    for node in nodes:
        world = above @ (place(node) if "objects" in node or "geometry" in node else
                         np.vstack([np.reshape(node["matrix"], (3, 4)), [0, 0, 0, 1]]))
        below = node.get("objects", node.get("parts"))
        if below is None:
            yield node, world
        else:
            yield from leaves(below, world)


def check_places():
    for name in ("luminaire-inch", "copies", "doublet", "luminaire"):
        shutil.rmtree("places", ignore_errors=True)
        run("import", f"cad/{name}.step", "-o", "places", "--quiet")
        written = text("places/parts.yaml")
        long = [n for at in re.findall(r"at: \[(.*?)\]", written) for n in at.split(", ") if len(n.replace(".", "").strip("-0")) > 9]
        check(not long, f"{name}: numbers of places that nobody would write: {long}")
        stored = json.loads(text("places/meshes/assembly.json"))
        box = {s["id"]: np.array(s["bounds"]) for s in stored["shapes"]}
        off = [np.abs((w - v) @ np.append(corner, 1)).max() for (_, w), (part, v) in
               zip(leaves(yaml.safe_load(written)["objects"]), leaves(stored["parts"]), strict=True) for corner in box[part["shape"]]]
        check(max(off) < 1e-9, f"{name}: parts are {max(off)} mm off")
        print(f"{name}: places as written are {max(off):.1e} mm off those of the file")
    check("at: [60, 0, 0], rotate: [0, 0, 68.75" in written, written)


def check_root():
    shutil.rmtree("lamp", ignore_errors=True)
    run("import", "cad/luminaire.step", "-o", "lamp", "--quiet", "--chord", 0.5, "--angle", 30)
    ids = re.findall(r"name: (\S+?)[,\s].*?id: (0x\w+)", text("lamp/parts.yaml"), re.S)
    rule = "surfaces: {black: {type: absorber}}\nattributes:\n  - {match: {id: %s}, set: {surface: fresnel, inside: N-SF5}}\n  - {match: {group: optics, face: 0}, set: " \
           "{surface: black}}\n" % dict(ids)["lens"]
    pathlib.Path("lamp/attributes.yaml").write_text(rule, encoding="utf-8")
    said = text("cad/luminaire-revised.step")  # of the group below it the use has a name of its own
    for word, other in (("luminaire", "lamp 7"), ("optics", "head")):
        said = said.replace(f"PRODUCT('{word}','{word}'", f"PRODUCT('{other}','{other}'")
    pathlib.Path("lamp7.step").write_text(said, encoding="utf-8")
    done = run("update", "lamp", "lamp7.step", "--json")
    told = json.loads(done.stdout)
    change = {p["name"]: p["change"] for p in told["parts"]}
    check(change == {"luminaire": ["renamed"], "lens": ["renamed"], "bolt_right": ["moved"]}, f"{change}")
    check(told["meshes"] == {"kept": 4, "written": 0, "removed": 0}, f"chord and angle are those of the import: {told['meshes']}")
    check(re.findall(r"name: (\S+?)[,\s].*?id: (0x\w+)", text("lamp/parts.yaml"), re.S) == ids, "ids")
    check(not done.stderr and "N-SF5" in run("check", "lamp/scene.yaml").stdout, f"the rule fits: {done.stderr}")


def check_counted():
    """Bodies without names are counted by the converter: the first is gone, no attribute shifts, and its copies stay in its frame."""
    shutil.rmtree("copies", ignore_errors=True)
    run("import", "cad/copies.step", "-o", "copies", "--quiet")
    ids = dict(re.findall(r"name: (copies_\d), id: (0x\w+)", text("copies/parts.yaml")))
    check(sorted(ids) == [f"copies_{k}" for k in range(1, 7)], f"{ids}")
    told = json.loads(run("update", "copies", "cad/copies-revised.step", "--json").stdout)
    change = {p["name"]: p["change"] for p in told["parts"]}
    check(change == {"copies_1": ["gone"]} and told["meshes"]["written"] == 0, f"the others are as they were, though the first gave their shape its frame: {told}")
    check(dict(re.findall(r"name: (copies_\d), id: (0x\w+)", text("copies/parts.yaml"))) == {n: i for n, i in ids.items() if n != "copies_1"}, "ids")
    stands = {n.replace("copies_", ""): at for n, at in re.findall(r"name: (copies_[256]).*?at: \[(.*?)\]", text("copies/parts.yaml"))}
    check(stands.get("5") == "0, 60, 7", f"each stands where it stood: {stands}")


def put_converter(script):
    """A copy of the program with another raymap-step beside it."""
    shutil.rmtree("other", ignore_errors=True)
    os.mkdir("other")
    shutil.copy(os.environ.get("RAYMAP_PROGRAM", os.environ["RAYMAP"]), "other/raymap")
    pathlib.Path("other/raymap-step").write_text(f"#!/bin/sh\n{script}\n", encoding="utf-8")
    os.chmod("other/raymap-step", stat.S_IRWXU)


def check_converter():
    for script, words in (("kill -s SEGV $$", "ended by signal 11: the file is damaged"), ("exit 3", "ended with status 3"),
                          ("echo 'raymap-step: cad/box.step: no' >&2; exit 3", "raymap-step: cad/box.step: no")):
        put_converter(script)
        shutil.rmtree("none", ignore_errors=True)
        done = run("import", "cad/box.step", "-o", "none", status=3, program="other/raymap")
        check(words in done.stderr and "cad/box.step" in done.stderr and not os.path.exists("none"), f"{script}: {done.stderr}")
    for words, least in ((("--chord", "1e-9"), "from 1e-6"), (("--angle", "0"), "from 0.1 to 90"), (("--angle", "0.1"), None)):
        shutil.rmtree("none", ignore_errors=True)
        done = run("import", "cad/box.step", "-o", "none", *words, status=2 if least else 0)
        check(least is None or least in done.stderr, f"{words}: {done.stderr}")
    done = run("import", "cad/sheet.step", "-o", "sheet", "--strict", status=3)
    check("1 thing is not as the file has it" in done.stderr, done.stderr)
    shutil.rmtree("glued", ignore_errors=True)
    check("1 pair of parts touches: crown and flint" in run("import", "cad/doublet.step", "-o", "glued").stdout, "those that touch")
    subprocess.run([MAKER, ".", "150"], check=True)
    shutil.rmtree("out", ignore_errors=True)
    start = time.monotonic()
    done = run("many.step", "out", "--quiet", "--seconds", 1, status=3, program=STEP)
    check(re.fullmatch(r"raymap-step: many.step: given up while .*time limit \(--seconds\)\n", done.stderr), f"the limit: {done.stderr}")
    check(time.monotonic() - start < 20, "soon")


os.makedirs("cad", exist_ok=True)
subprocess.run([MAKER, "cad"], check=True)
check_places()
check_root()
check_counted()
check_converter()
finish()
