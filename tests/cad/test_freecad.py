#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""STEP files that FreeCAD wrote, if it is here: names, tree, places, true surfaces of the lens; attributes outlive the revision."""
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

from cad_tools import check, finish  # skips where there is no converter

FREECAD = shutil.which("freecadcmd") or shutil.which("FreeCADCmd")
if not FREECAD:
    print("SKIP: no freecadcmd here, no file of FreeCAD is read: apt-get install --no-install-recommends freecad")
    sys.exit(77)
import cad_mesh  # noqa: E402


def run(*words):
    done = subprocess.run([os.environ["RAYMAP"], *words], text=True, capture_output=True, check=False)
    check(done.returncode == 0, f"{words}: {done.stderr}")
    return done.stdout


def text(name):
    return pathlib.Path(name).read_text(encoding="utf-8")


for name in ("lamp.step", "lamp-b.step"):
    pathlib.Path(name).unlink(missing_ok=True)
made = subprocess.run([FREECAD, pathlib.Path(__file__).with_name("freecad_model.py")], stdin=subprocess.DEVNULL, text=True, capture_output=True,
                      check=False, timeout=300)
check(os.path.exists("lamp.step") and os.path.exists("lamp-b.step"), f"freecadcmd: {made.stdout} {made.stderr}")
shutil.rmtree("lamp", ignore_errors=True)
told = json.loads(run("import", "lamp.step", "-o", "lamp", "--json"))
parts = text("lamp/parts.yaml")
check((told["parts"], told["groups"], told["closed"]) == (5, 2, 5) and told["shapes"] in (3, 5), f"{told}")
for words in ("name: lamp", "name: optics", "name: front_lens", "# front lens", "at: [0, 0, 40], rotate: [180, 0, 0]", "at: [45, 0, 12.7], rotate: [0, 30, 0]"):
    check(words in parts, f"'{words}' in\n{parts}")
stored = json.loads(text("lamp/meshes/assembly.json"))
lens = next(s for s in stored["shapes"] if "lens" in s["name"] or "lens" in s["file"])
mesh = cad_mesh.Mesh(pathlib.Path("lamp/meshes", lens["file"]))
spheres = [(row["r1"], row["ox"], row["oy"], row["oz"]) for row in mesh.surfaces if row["kind"] == 4]
check(len(spheres) == 1 and max(abs(a - b) for a, b in zip(spheres[0], (51.68, 0, 0, 51.68))) < 1e-9, f"the sphere of the lens: {spheres}")
check(not mesh.open_edges() and mesh.off() < 1e-9, "vertices lie on it")
number = re.search(r"name: front_lens, id: (\w+)", parts).group(1)
rules = "attributes:\n  - {match: {id: %s}, set: {surface: fresnel, inside: N-BK7}}\n  - {match: {name: bolt1}, set: {surface: absorber}}\n" % number
pathlib.Path("lamp/attributes.yaml").write_text(rules, encoding="utf-8")
told = json.loads(run("update", "lamp", "lamp-b.step", "--json"))
change = {p["name"]: p["change"] for p in told["parts"]}
check(change == {"front_lens": ["renamed"], "bolt1": ["moved"], "bolt0": ["gone"]} and told["kept"] == 2, f"the revision: {told}")
says = run("check", "lamp/scene.yaml")
check("N-BK7" in says and f"name: front_lens, id: {number}" in text("lamp/parts.yaml"), f"rules fit: {says}")
finish()
