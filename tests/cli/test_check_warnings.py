#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: `check` warns of light that is sent in vain, detectors that none reaches, two stops of a lens and a background that
nobody sees; and of none of these in the examples."""
import glob
import os
import subprocess
import sys
import tempfile

EXAMPLES = os.path.join(os.environ["SOURCE_DIR"], "examples")
failures = []
os.chdir(tempfile.mkdtemp(dir="."))
WALL = """raymap: 1
media: {air: {index: 1}, dye: {index: 1.4, absorption: 0.25}}
surfaces: {black: {type: absorber}, clear: {type: fresnel}}
geometries:
  wall: {type: rectangle, size: 2}
  ball: {type: sphere, radius: 0.2}
  lens: {type: lens, surface: clear, surfaces: [{radius: 9, thickness: 1, medium: dye, aperture: 0.4%s}, {curvature: 0, medium: air, aperture: 0.4%s}]}
objects:
  - {name: wall, geometry: wall, at: [0, 0, 5], surface: black}
  - {name: lens, geometry: lens, at: [0, 0, 2], outside: air}
"""
SOURCE = "sources: [{name: s, type: %s, medium: air}]\n"
STRAIGHT = "collimated, shape: {disc: 0.3}"


def check(name, more, *wanted, stops=("", "")):
    with open(f"{name}.yaml", "w", encoding="utf-8") as file:
        file.write(WALL % stops + more)
    done = subprocess.run([os.environ["RAYMAP"], "check", f"{name}.yaml"], capture_output=True, text=True, check=False)
    said = [line for line in done.stderr.splitlines() if "warning" in line]
    if done.returncode != 0 or len(said) != len(wanted) or not all(any(w in line for line in said) for w in wanted):
        failures.append(f"{name}: status {done.returncode}, {done.stderr}")
    return done.stdout


text = check("good", SOURCE % STRAIGHT)
if "absorption 0.25 / m" not in text or "1/e in 4 m" not in text:
    failures.append(text)
check("away", SOURCE % (STRAIGHT + ", direction: [0, 0, -1]"), "source 's' hits nothing")
check("aside", SOURCE % "point", "of source 's' leaves the scene without meeting")
check("behind", SOURCE % STRAIGHT + "detectors: [{name: d, type: plane, at: [0, 0, 8], size: 2, cells: 4}]\n", "registered on detector 'd'")
check("far", SOURCE % "point" + "detectors: [{name: d, type: intensity, cells: 4}]\n")
check("stops", SOURCE % STRAIGHT, "a second 'stop: true'", stops=(", stop: true", ", stop: true"))
check("sky", SOURCE % STRAIGHT + "background: {radiance: 1}\n", "'background' is light for `raymap render` alone")
for scene in glob.glob(os.path.join(EXAMPLES, "*", "scene.yaml")):
    done = subprocess.run([os.environ["RAYMAP"], "check", scene], capture_output=True, text=True, check=False)
    if "warning" in done.stderr:
        failures.append(done.stderr)
print("\n".join(failures) or "as promised")
sys.exit(bool(failures))
