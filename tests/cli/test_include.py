#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: a scene that includes its parts is the scene in one file; its maps keep the parts; mistakes are told by the part's file and line."""
import json
import os
import shutil
import subprocess
import sys
import tempfile

os.chdir(tempfile.mkdtemp(dir="."))
failures = []
MATERIALS = "media: {air: {index: 1}}\nsurfaces:\n  paint: {type: lambert, reflectance: 0.6}\n"
LAMP = "sources:\n  - {name: lamp, type: point, at: [0, 0, 1], flux: 30 lm, medium: air}"
HEAD = "raymap: 1\nunits: m\nspectrum: {mode: rgb}\n"
ROOM = ("geometries: {room: {type: box, size: [6, 4, 2.8]}}\n"
        "objects:\n  - {name: room, geometry: room, surface: paint, inside: air, outside: air}\n"
        "detectors:\n  - {name: desk, type: plane, at: [0, 0, 0.5], direction: [0, 0, 1], size: 2, cells: 9}\n")


def put(name, text):
    with open(name, "w", encoding="utf-8") as file:
        file.write(text)


def run(*words, status=0):
    done = subprocess.run([os.environ["RAYMAP"], *map(str, words)], capture_output=True, text=True, check=False)
    if done.returncode != status:
        failures.append(f"{words}: status {done.returncode}\n{done.stderr}")
    return done


def check(holds, what):
    if not holds:
        failures.append(what)


os.mkdir("parts")
put("parts/materials.yaml", "\ufeff---\nraymap: 1\n" + MATERIALS)
put("parts/lamp.yaml", LAMP)
put("whole.yaml", HEAD + MATERIALS + LAMP + "\n" + ROOM)
put("scene.yaml", HEAD + "include: [parts/materials.yaml, parts/lamp.yaml]\nsources:\n" + ROOM)
for scene in ("whole", "scene"):
    run("trace", f"{scene}.yaml", "-o", f"{scene}.raymap", "-n", 2000, "-q")
images = [json.loads(run("detector", f"{scene}.raymap", "desk", "--json").stdout) for scene in ("whole", "scene")]
check(images[0] == images[1] and images[0]["registrations"] > 0, "the same light")
run("trace", "scene.yaml", "-o", "scene.raymap", "-n", 100, "--append", "-q")
shutil.move("parts", "gone")
check(json.loads(run("detector", "scene.raymap", "desk", "--json").stdout)["rays_traced"] == 2100, "the map keeps the parts")
told = run("trace", "scene.yaml", "-o", "x.raymap", status=3).stderr
check("scene.yaml:4:11: error: cannot open parts/materials.yaml" in told and "unknown surface" not in told, told)
shutil.move("gone", "parts")
put("parts/lamp.yaml", LAMP.replace("medium: air", "medium: ari"))
told = run("check", "scene.yaml", status=3).stderr
check("parts/lamp.yaml:2:67: error: unknown medium 'ari'" in told, told)
place, = json.loads(run("check", "scene.yaml", "--json", status=3).stdout)["diagnostics"]
check((place["file"], place["line"]) == ("parts/lamp.yaml", 2), str(place))
put("parts/lamp.yaml", "sources:\n - {name: lamp\n")
check("parts/lamp.yaml:" in run("check", "scene.yaml", status=3).stderr, "syntax of a part")
for text, word in ((MATERIALS, "parts/lamp.yaml:1:9: error: duplicate key 'air'"), ("units: mm\n", "'units' stands in the scene, too"),
                   ("include: scene.yaml\n", "includes no other"), ("[1]\n", "must be a mapping")):
    put("parts/lamp.yaml", text)
    told = run("check", "scene.yaml", status=3).stderr
    check(word in told, told)
put("two.yaml", HEAD + MATERIALS + LAMP + "\n---\n" + ROOM)
check("a second document" in run("check", "two.yaml", status=3).stderr, "documents are not parts")
print("\n".join(failures) or "as promised")
sys.exit(bool(failures))
