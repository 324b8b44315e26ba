#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: docs/map.md and docs/encoding.md are enough to read a map of either encoding with h5py and numpy alone, as
`reference` does. For 400 rays (1,000 of the label slow) of each example it reproduces what `raymap report` prints, and every column of a compact map
equals that of a plain one, bit for bit; examples/python has the same bits through the library. A third scene has what the
examples lack."""
import json
import os
import re
import shutil
import subprocess
import sys
import unittest.mock

import h5py
import numpy as np

sys.dont_write_bytecode = True  # the source tree stays as it is
SOURCE = os.environ["SOURCE_DIR"]
PROGRAM = os.environ["RAYMAP"]
sys.path.insert(0, os.path.join(SOURCE, "examples", "python"))
from reference import reader as raymap_reader  # noqa: E402
from reference import compact as raymap_compact  # noqa: E402
import raymap  # noqa: E402

RAYS = 1000 if int(os.environ.get("RAYMAP_TEST_SCALE", "1")) > 1 else 400

# Every kind of source, shape, surface, medium and detector that the examples lack.
ZOO = """raymap: 1
units: mm
spectrum: {mode: spectral, wavelengths: [450, 500, 550, 600, 650]}
media:
  air: {index: 1}
  bk7: {glass: N-BK7, absorption: 0.002}
  ink: {table: {wavelength: [400, 700], n: [1.3, 1.4], k: [1.0e-6, 4.0e-6]}}
films:
  dark: {layers: [{n: 2.4, k: 1.3, thickness: 20 nm}, {n: 1.38, thickness: 90 nm}, {n: 2.1, thickness: 400 nm}]}
  sheet: {substrate: front, layers: [{n: 1.9, k: 0.05, thickness: 300 nm}, {n: 1.4, thickness: 120 nm}]}
surfaces:
  coated: {type: fresnel, coat: {reflectance: {wavelength: [400, 700], value: [0, 0.4]}}}
  metal: {type: mirror, metal: {n: 0.2, k: 3}}
  silvered: {type: mirror, metal: Ag, coat: {film: dark}}
  bloomed: {type: fresnel, coat: {film: dark}}
  pellicle: {type: fresnel, coat: {film: sheet}}
  white: {type: lambert, reflectance: {wavelength: [400, 700], value: [0.9, 0.5]}}
  milk: {type: mixture, reflect_diffuse: 0.4, transmit_diffuse: 0.4}
  black: {type: absorber}
geometries:
  ball: {type: sphere, radius: 5}
  pipe: {type: cone, radius: 12, radius2: 9, length: 20}
  plate: {type: rectangle, size: [30, 30]}
  dish: {type: conic, radius: 40, conic: -1, asphere: {4: 1.0e-6}, aperture: 14, inner: 1}
  ring: {type: disc, radius: 14, inner: 6}
objects:
  - {name: drop, geometry: ball, at: [0, 0, 2], surface: bloomed, inside: bk7, outside: air}
  - {name: bead, geometry: ball, at: [7, 3, -6], rotate: [10, 20, 30], scale: [0.5, 0.4, 0.6],
     surface: coated, inside: ink, outside: air}
  - {name: tube, geometry: pipe, at: [0, 0, 5], surface: metal, front: air, back: air}
  - {name: screen, geometry: plate, at: [0, 0, 30], rotate: [0, 5, 0], surface: white, front: air,
     back: air}
  - {name: pane, geometry: plate, at: [0, 0, 15], rotate: [0, -8, 0], surface: pellicle, front: air, back: air}
  - {name: veil, geometry: plate, at: [0, 0, 40], surface: milk, front: air, back: air}
  - {name: mirror, geometry: dish, at: [0, 0, 55], rotate: [180, 0, 0], surface: silvered, front: air,
     back: air}
  - {name: stop, geometry: ring, at: [0, 0, -10], surface: black, front: air, back: air}
sources:
  - {name: beam, type: collimated, shape: {disc: 6}, at: [0, 0, -20], direction: [0, 0.1, 1],
     flux: 1 W, spectrum: {lines: {500: 1, 600: 2}}, medium: air}
  - {name: lamp, type: point, at: [3, -4, -15], direction: [0, 0, 1], distribution: {cone: 30},
     flux: 1 W, spectrum: D65, medium: air}
  - {name: bulb, type: point, at: [0, 0, 35], distribution: isotropic, flux: 1 W, medium: air}
  - {name: panel, type: area, shape: {rectangle: [4, 6]}, at: [0, 0, -19], direction: [0, 0, 1],
     flux: 1 W, medium: air}
  - {name: led, type: point, at: [0, 9, 20], direction: [0, -1, 0.3],
     distribution: {cosine_power: 3}, flux: 1 W, medium: air}
  - {name: spot, type: point, at: [0, 9, 20], direction: [0, -1, 0.3], flux: 1 W, medium: air,
     distribution: {table: {angle: [0, 5, 25], value: [1, 3, 0]}}}
  - {name: sun, type: collimated, shape: {disc: 6}, at: [0, 0, -20], angular_diameter: 3 deg,
     flux: 1 W, medium: air}
  - {name: list, type: rays, flux: 1 W, medium: air, rays: [
     {origin: [0, 0, -18], direction: [0, 0, 1], wavelength: 500},
     {origin: [1, 2, -18], direction: [0.1, 0, 1]}]}
detectors:
  - {name: film, type: plane, size: [24, 24], cells: [40, 30], at: [0, 0, 25],
     direction: [0, 0, -1], side: both}
  - {name: paper, type: plane, on: screen, size: [30, 30], cells: [20, 10], side: both}
  - {name: sky, type: intensity, cells: [18, 36], axis: [0, 1, 0]}
"""

failures = 0


def check(good, what):
    global failures
    if not good:
        failures += 1
        if failures < 30:
            print("FAIL " + what)


def run(*arguments):
    done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"raymap {' '.join(arguments)}: {done.returncode}\n{done.stderr}")
    return done.stdout


def trace(scene, target, encoding, *options):
    shutil.rmtree(target, ignore_errors=True)
    run("trace", scene, "-o", target, "-n", str(RAYS), "--encoding", encoding, "--quiet", *options)
    return raymap_reader.Map(target)


def close(got, want, tolerance):
    return want is not None and np.allclose(got, want, rtol=tolerance, atol=tolerance)


def check_step(lens, ray, k, said, where):
    s, last = ray.segments, np.float64(ray["start"] if k == 0 else ray.segments["position"][k - 1])
    position = np.float64(s["position"][k])
    check(position.tolist() == said["position"], where + "position")
    check(raymap_reader.event_words(s["event"][k]) == said["events"], where + "events")
    met = int(s["object"][k])
    check((lens.names["object"][met] if met >= 0 else None) == said["object"], where + "object")
    check((int(s["primitive"][k]) if met >= 0 else None) == said["primitive"], where + "primitive")
    check(lens.names["medium"][s["medium"][k]] == said["medium"], where + "medium")
    check((s["colour"][k] / 65535.0).tolist() == said["colour"], where + "colour")
    normal = s["normal"][k] / 32767.0
    if normal.any():
        check(close(normal / np.sqrt((normal * normal).sum()), said["normal"], 1e-15),
              where + "normal")
    else:
        check(said["normal"] is None, where + "no normal")
    if "left" in said["events"]:
        check(said["length"] == 0.0, where + "no length")
        check(np.float64(ray["end_direction"]).tolist() == said["direction"], where + "direction")
    else:
        check(close(np.sqrt(((position - last) ** 2).sum()), said["length"], 1e-15),
              where + "length")


def check_registration(lens, ray, k, said, where):
    r = ray.registrations
    detector = lens.detectors[r["detector"][k]]
    check(detector["name"] == said["detector"], where + "detector")
    check(int(r["segment"][k]) == said["step"], where + "step")
    check(r["cell"][k].tolist() == said["cell"], where + "cell")
    check(bool(r["registered"][k]) == said["registered"], where + "registered")
    check(float(r["optical_path"][k]) == said["optical_path"], where + "optical path")
    relative = r["relative"][k] / 65535.0
    if detector["type"] == "plane":
        check(close((relative - 0.5) * detector["size"], [said["x"], said["y"]], 1e-12),
              where + "place")


def check_report(lens, target):
    """Everything that `raymap report` says of every ray."""
    if os.path.exists("rays.json"):
        os.remove("rays.json")
    run("query", target, "all", "-o", "rays.json", "--quiet")
    with open("rays.json", encoding="utf-8") as file:
        said = {ray["ray"]: ray for ray in json.load(file)}
    for number in (0, RAYS // 2, RAYS - 1):
        of_map = {"complete": True, "rays_asked": RAYS, "rays_traced": RAYS}
        check(json.loads(run("report", target, str(number), "--json")) == said[number] | of_map,
              f"{target}: report of ray {number}")
    n = 0
    for ray in lens.rays():
        about, where = said[int(ray["id"])], f"{target}: ray {ray['id']}: "
        n += 1
        check(lens.names["source"][ray["source"]] == about["source"], where + "source")
        check(raymap_reader.STOPS[ray["stop"]] == about["stop"], where + "stop")
        check(np.float64(ray["start"]).tolist() == about["start"], where + "start")
        for name in ("path_length", "optical_path"):
            check(float(ray[name]) == about[name], where + name)
        wavelength = None if np.isnan(ray["wavelength"]) else float(ray["wavelength"])
        check(wavelength == about["wavelength"], where + "wavelength")
        check(close(lens.flux(ray["source"], ray["weight"]), about["flux"], 1e-15), where + "flux")
        check(len(ray.segments["event"]) == len(about["steps"]), where + "legs")
        check(len(ray.registrations["cell"]) == len(about["registrations"]), where + "crossings")
        for k, step in enumerate(about["steps"]):
            check_step(lens, ray, k, step, f"{where}leg {k}: ")
        for k, registration in enumerate(about["registrations"]):
            check_registration(lens, ray, k, registration, f"{where}registration {k}: ")
    check(n == RAYS == len(said), f"{target}: {n} rays")


def check_package(reference, what):
    """The package, through the library: the same bits, of all rays, of one and of those that match."""
    lens, want = raymap.open(reference.path), reference.columns()
    check(lens.n_portions == reference.n_portions, f"{what}: blocks")
    for name, column in lens.columns().items():
        check(column.dtype == want[name].dtype and column.tobytes() == np.ascontiguousarray(want[name]).tobytes(),
              f"{what}: {name} by the library")
    few = np.concatenate([portion["ray/id"] for portion in lens.portions(["ray/id"], where="segments >= 7")])
    check(0 < len(few) < RAYS and np.array_equal(few, want["ray/id"][want["ray/segment_count"] >= 7]), f"{what}: where")
    one, other = lens.ray(few[-1]), reference.ray(few[-1])
    check(one["id"] == few[-1] and one.segments["position"].tobytes() ==
          np.ascontiguousarray(other.segments["position"]).tobytes(), f"{what}: one ray by the library")


def check_columns(plain, compact, what):
    """Plain and compact: the same bytes in every column."""
    one, other = plain.columns(), compact.columns()
    check(list(one) == list(raymap_reader.COLUMN_NAMES), what + ": columns")
    for name, column in one.items():
        twin = other[name]
        check(column.dtype == twin.dtype and column.shape == twin.shape
              and column.tobytes() == np.ascontiguousarray(twin).tobytes(), f"{what}: {name}")
    told = [name for name in one if name not in raymap_compact.RETRACED]
    with unittest.mock.patch.object(raymap_compact, "_Retrace", None):  # no ray is traced again
        for name, column in compact.columns(*told).items():
            check(column.tobytes() == other[name].tobytes(), f"{what}: {name} alone")
    check(plain.digest == compact.digest, what + ": digest")
    check(plain.encoding(0) == raymap_reader.PLAIN, what + ": plain")
    check(compact.encoding(0) == raymap_reader.COMPACT, what + ": compact")


def check_many_pieces(plain):
    """Pieces that take turns, in both encodings, read twice; picked rays whose portions lie within
    each other; more colour spaces than one. `plain` has the same rays."""
    run("query", plain.path, "hit(*) >= 9", "-o", "many.raymap", "--force", "--quiet")
    run("query", plain.path, "hit(*) < 9", "-o", "few.raymap", "--encoding", "compact", "--force",
        "--quiet")
    run("merge", "many.raymap", "few.raymap", "-o", "mixed.raymap", "--force", "--quiet")
    mixed, want = raymap_reader.Map("mixed.raymap"), plain.columns("ray/id", "ray/path_length")
    check(mixed.n_portions > 1, "portions of both")
    for _ in range(2):
        got = mixed.columns("ray/id", "ray/path_length")
        order = np.argsort(got["ray/id"])
        for name, column in want.items():
            check(got[name][order].tobytes() == column.tobytes(), f"mixed: {name}")
    for number in range(0, RAYS, 97):
        ray, same = mixed.ray(number), plain.ray(number)
        check(ray["id"] == number and ray.segments["position"].tobytes() ==
              same.segments["position"].tobytes(), f"mixed: ray {number}")
    wider = "spectrum.wavelengths=[486.13, 550, 587.56, 656.27]"
    run("trace", os.path.join(SOURCE, "examples", "double-gauss", "scene.yaml"), "-o", plain.path,
        "-n", "50", "--append", "--set", wider, "--quiet")
    spaces = raymap_reader.Map(plain.path)
    for either in (spaces, raymap.open(plain.path)):
        check([len(portion["segment/colour"][0]) for portion in either.portions()] == [3, 4], "spaces")
    run("trace", os.path.join(SOURCE, "examples", "double-gauss", "scene.yaml"), "-o", plain.path,
        "-n", "50", "--append", "--color", "rgb", "--quiet")
    with h5py.File(os.path.join(plain.path, "map.h5")) as index:  # what it says once is of space 0
        check(index["channel/wavelength"][:].tolist() == [486.13, 587.56, 656.27] and
              index["source/colour"].shape[1] == index.attrs["channels"] == 3 and
              index.attrs["space_digest"] == index["space/digest"][0] and
              index.attrs["colour_space"] == b"spectral" and
              b"/segment/colour_spectral" in index["layout/plain"][:], "the first colour space")
    try:
        spaces.columns("segment/colour")
        check(False, "rows of 3 and of 4 channels in one column")
    except raymap_reader.MapError:
        pass


def check_lanes():
    """A lane gives back any numbers whatever was predicted, in every way that it can be stored."""
    random, n = np.random.default_rng(7), 400
    for kind in ("u2", "i2", "i4", "u8", "f4", "f8"):
        width = 8 * int(kind[1])
        truth, guess = (np.frombuffer(random.bytes(n * width // 8), kind) for _ in range(2))
        truth = np.where(random.random(n) < 0.5, guess, truth)
        index = np.flatnonzero(truth.view(f"u{kind[1]}") != guess.view(f"u{kind[1]}"))
        order = [[x ^ (2 ** (width - 1) - 1) if kind[0] == "f" and x >> (width - 1) else x
                  for x in map(int, a.view(f"u{kind[1]}"))] for a in (truth, guess)]
        d = [(a - b) % 2 ** width for a, b in zip(*order)]
        value = np.array([x << 1 & 2 ** width - 1 ^ (2 ** width - 1 if x >> (width - 1) else 0)
                          for x in d], np.uint64)
        for mode in (1, 2, 3):
            lane = raymap_compact.Lane(kind, n)
            lane.mode, lane.dense, lane.dense_bits = mode, truth, value
            lane.at, lane.value = index, value[index]
            got, right = lane.offer(np.arange(n), guess)
            check(got.tobytes() == truth.tobytes() == lane.out.tobytes(), f"lane {kind} {mode}")
            check((~right == np.isin(np.arange(n), index)).all(), f"lane {kind} {mode}: verdict")


def check_features():
    """The package knows what maps may ask a reader to know, and has the columns of times."""
    with open(os.path.join(SOURCE, "docs", "map.md"), encoding="utf-8") as page:
        told = re.search(r"\| feature \| says \|\n(.*?)\n\n", page.read(), re.S).group(1)
    names = set(re.findall(r"^\| `(\w+)` \|", told, re.M))
    check(names == raymap.reader.FEATURES, f"features: {names ^ raymap.reader.FEATURES}")
    run("trace", "zoo.yaml", "-o", "timed.raymap", "-n", "100", "--time", "on", "--force", "--quiet")
    lens = raymap.open("timed.raymap")
    ray = lens.ray(17)
    check(ray["delay"] >= 0 and len(lens.columns("registration/group_path")["registration/group_path"]) == lens.n_registrations, "times")


check_lanes()
with open("zoo.yaml", "w", encoding="utf-8") as scene_file:
    scene_file.write(ZOO)
check_features()
examples = os.path.join(SOURCE, "examples")
for label, scene_path, more in (("double-gauss", f"{examples}/double-gauss/scene.yaml", ()),
                                ("room", f"{examples}/room/scene.yaml", ()),
                                ("zoo", "zoo.yaml", ()), ("zoo-rgb", "zoo.yaml", ("--color", "rgb"))):
    maps = [trace(scene_path, f"{label}-{encoding}.raymap", encoding, *more)
            for encoding in ("plain", "compact")]
    check_columns(*maps, label)
    for a_map in maps:
        check_package(a_map, a_map.path)
    for a_map in maps if label != "zoo-rgb" else ():
        check_report(a_map, a_map.path)
    ray_17 = maps[1].ray(17)
    check(ray_17["id"] == 17 and len(ray_17.segments["event"]) == ray_17["segment_count"], "a ray")
    if label == "double-gauss":
        check_many_pieces(maps[0])
print(f"{failures} failures")
sys.exit(failures > 0)
