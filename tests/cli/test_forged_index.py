# SPDX-License-Identifier: MIT
"""The promise: verify tells where an index whose seal holds says something else than the scene and the
rays do, and repair makes an index that says what is there."""
import json
import os
import shutil
import subprocess

import h5py
import numpy as np
from sealed_map import checksum, edit, put

PROGRAM = os.environ["RAYMAP"]
HERE = os.path.dirname(os.path.abspath(__file__))


def run(*arguments, status=0):
    done = subprocess.run([PROGRAM, *arguments, "--quiet"], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True, timeout=120, check=False)
    assert done.returncode == status, (arguments, done.returncode, done.stdout, done.stderr)
    return done.stdout


def change_text(file):
    text = file["scene/text"]
    now = np.array([text[0].replace(b"size: [40, 40]", b"size: [40, 41]")], dtype=text.dtype)
    assert now[0] != text[0]
    text[...] = now
    if "checksum" in text.attrs:
        text.attrs.modify("checksum", np.uint64(checksum(now.tobytes())))


def change_scene(file):
    """Another scene, in which all that the index says of it and of the rays is as true."""
    change_text(file)
    bundle = file["scene/bundle"]
    now = bundle[()].tobytes().replace(b"size: [40, 40]", b"size: [40, 41]")
    assert now != bundle[()].tobytes()
    put(bundle, None, np.frombuffer(now, dtype=np.uint8))


subprocess.run(["bash", "-c", '. "$0"; write_scene scene.yaml', f"{HERE}/../cli/expect.bash"],
               check=True)
shutil.rmtree("a.raymap", ignore_errors=True)
run("trace", "scene.yaml", "-o", "a.raymap", "-n", "20000")
run("trace", "scene.yaml", "-o", "a.raymap", "-n", "5000", "--append", "--color", "rgb")
run("verify", "a.raymap")
for name, dataset, change, lost in (
        ("map.h5", "/run/n_ray", lambda file: put(file["run/n_ray"], 1, 9000), [25000, 28999]),
        ("map.h5", "/scene/text", change_text, None),
        ("map-start.h5", "/scene/bundle", change_scene, None),
        ("map.h5", "/scene/bundle", change_scene, None)):
    shutil.rmtree("forged.raymap", ignore_errors=True)
    shutil.copytree("a.raymap", "forged.raymap")
    edit(f"forged.raymap/{name}", change)
    found = json.loads(run("verify", "forged.raymap", "--json", status=4))["findings"]
    assert [(one["file"], one["dataset"]) for one in found] == [(name, dataset)], found
    assert found[0]["ray_ranges"] == ([lost] if lost else []), found
    run("repair", "forged.raymap")
    run("verify", "forged.raymap")
    assert json.loads(run("info", "forged.raymap", "--json"))["complete"] is (lost is None)
with h5py.File("forged.raymap/map.h5") as file:
    assert b"size: [40, 40]" in file["scene/text"][0]
for name in ("map.h5", "map-start.h5"):
    edit(f"forged.raymap/{name}", change_scene)
run("repair", "forged.raymap", status=3)  # nobody knows the scene

# Squares of weights beyond 1024: an older program's map has none of the rest; too much of it is a lie.
with open("dye.yaml", "w", encoding="utf-8") as file:
    file.write("""raymap: 1
units: mm
spectrum: {wavelengths: [430, 555]}
media: {dye: {index: 1, species: {dye: {absorption: {wavelength: [430, 555], value: [1, 0]}, emission: {lines: {555: 1}}}}}}
geometries: {globe: {type: sphere, radius: 1000}}
objects: [{name: globe, geometry: globe, surface: absorber, front: dye, back: dye}]
sources: [{name: lamp, type: point, at: [0, 0, 0], flux: 1 lm, spectrum: {lines: {430: 1}}, medium: dye}]
detectors: [{name: round, type: plane, on: globe, size: 3000, cells: 1, side: both}]
""")
REST = "/detector/round/image_squared_rest"
run("trace", "dye.yaml", "-o", "dye.raymap", "-n", "3000", "--force")
edit("dye.raymap/map.h5", lambda file: put(file[REST], 0, 1e9))
found = json.loads(run("verify", "dye.raymap", "--json", status=4))["findings"]
assert [one["dataset"] for one in found] == [REST], found
run("repair", "dye.raymap")
run("verify", "dye.raymap")
edit("dye.raymap/map.h5", lambda file: file.__delitem__(REST))
run("verify", "dye.raymap")
run("detector", "dye.raymap", "round", "--tally")
print("all as expected")
