#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: maps that an earlier version of the format wrote are read for ever, and say what
they said then: digests, counts, fluxes and a ray in full. Read by the program and, as far as its
index goes, by the reader in Python. tests/format/fixtures/make_fixtures.sh made them."""
import glob
import json
import os
import shutil
import subprocess
import sys
import tarfile

sys.dont_write_bytecode = True  # the source tree stays as it is
SOURCE = os.environ["SOURCE_DIR"]
PROGRAM = os.environ["RAYMAP"]
FIXTURES = os.path.join(SOURCE, "tests", "format", "fixtures")
sys.path[:0] = [FIXTURES, os.path.join(SOURCE, "examples", "python")]
import describe  # noqa: E402
from reference import reader as raymap_reader  # noqa: E402

OF_OTHER_TRACERS = ("2.0", "4.0")
NOT_IN_PYTHON = ("5.0-models", "5.0-scatter", "5.0-metals-stored", "5.0-metals")  # surfaces with scatter models
SLOW = int(os.environ.get("RAYMAP_TEST_SCALE", "1")) > 1
failures = 0


def check(good, what):
    global failures
    if not good:
        failures += 1
        print("FAIL " + what)


def same(got, want, where):
    """Equal, floats to the last bits: sums over threads may be ordered otherwise some day."""
    if isinstance(want, dict):
        check(isinstance(got, dict) and set(want) <= set(got), f"{where}: keys")
        for key in want:
            same(got.get(key), want[key], f"{where}.{key}")
    elif isinstance(want, list):
        check(isinstance(got, list) and len(got) == len(want), f"{where}: length")
        for k, pair in enumerate(zip(got, want)):
            same(*pair, f"{where}[{k}]")
    elif isinstance(want, float):
        check(isinstance(got, float) and abs(got - want) <= 1e-14 * abs(want),
              f"{where}: {got} is not {want}")
    else:
        check(got == want, f"{where}: {got} is not {want}")


def left_scene(version):
    """The scene of the maps that a killed run left."""
    own = os.path.join(FIXTURES, f"left-{version}.yaml")
    return own if os.path.exists(own) else os.path.join(FIXTURES, "left.yaml")


def chosen(k, told):
    """Maps of archive k: all, or in turns a spectral one and two of the others, of both encodings."""
    if SLOW:
        return sorted(told)
    others = (("plain-left.raymap", "compact-rgb.raymap"), ("compact-left.raymap", "plain-rgb.raymap"),
              ("plain-left.raymap", "two-spaces.raymap"))
    spectral = "plain.raymap" if k % 2 == 1 and k % 3 < 2 else "compact.raymap"
    return sorted({spectral, *others[k % 3]} & set(told))


def read_in_python(target, said):
    """The rays that the index has, and those of the plain twin in the same numbers."""
    lens = raymap_reader.Map(target)
    columns = lens.columns()
    check(len(columns["segment/event"]) == lens.n_segments, f"{target}: segments in Python")
    ray = lens.ray(33)
    check([[float(x) for x in p] for p in ray.segments["position"]]
          == [step["position"] for step in said["ray"]["steps"]], f"{target}: ray 33 in Python")
    if "curve_points" in said:
        check(len(columns["curve/ray"]) == said["curve_points"], f"{target}: curves in Python")
        check([[float(x) for x in p] for p in ray.curve["position"]]
              == [p for step in said["ray"]["steps"] for p in step.get("curve", [])],
              f"{target}: curves of ray 33 in Python")


archives = sorted(glob.glob(os.path.join(FIXTURES, "maps-*.tar.xz")))
check(len(archives) > 0, "there are fixtures")
check(all(os.path.getsize(name) < 100000 for name in archives), "they are small")
for k, archive in enumerate(archives):
    version = os.path.basename(archive)[5:-7]
    shutil.rmtree(version, ignore_errors=True)
    with tarfile.open(archive) as tar:
        tar.extractall(version)
    with open(archive[:-7] + ".json", encoding="utf-8") as file:
        told = json.load(file)
    check(set(told) == set(os.listdir(version)), f"{version}: maps")
    names = chosen(k, told)
    for name in names:
        said = told[name]
        target = os.path.join(version, name)
        same(describe.describe(PROGRAM, target), said, f"{version}/{name}")
        if "left" not in name and "spaces" not in name and version not in NOT_IN_PYTHON:
            read_in_python(target, said)
    # A killed run's map goes on, unless its rays are of another revision of the tracer: then it stays as it is, and is
    # told so.
    for name in (name for name in names if "left" in name):
        target = os.path.join(version, name)
        check(0 < told[name]["rays"] < 12288 and not told[name]["complete"], f"{name}: left over")
        done = subprocess.run([PROGRAM, "trace", left_scene(version), "-o", target, "-n", "12288", "--seed", "5",
                               "--resume", "--quiet"], capture_output=True, text=True, check=False)
        if version not in OF_OTHER_TRACERS:
            check(done.returncode == 0 and describe.run(PROGRAM, "info", target)["rays"] == 12288,
                  f"{target}: {done.returncode} {done.stderr}")
            continue
        check(done.returncode == 3 and "has rays of tracer revision 1, and these are of" in done.stderr,
              f"{target}: {done.returncode} {done.stderr}")
        same(describe.describe(PROGRAM, target), told[name], f"{target}: after a refused resume")
    check(told["plain.raymap"]["digest"] == told["compact.raymap"]["digest"], "digests")
print(f"{len(archives)} archives, {failures} failures")
sys.exit(failures > 0)
