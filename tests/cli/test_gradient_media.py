#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Gradient media from files, and ones that are wrong: what is told, with place and remedy; that light
which comes where there is no index ends with `error`, is counted, and nothing else is lost; that a map
goes on without the files; one digest for any number of ranks."""
import json
import os
import shutil
import subprocess
import sys

try:
    import h5py
    import numpy
except ImportError:
    print("no h5py here")
    sys.exit(77)

PROGRAM, PLUGINS = os.environ["RAYMAP"], os.environ["PLUGIN_DIR"]
os.environ["RAYMAP_ALLOW_PLUGINS"] = os.getcwd()
SCENE = """raymap: 1
units: mm
media:
  air: {index: 1}
  m: {gradient: %s}
geometries:
  ball: {type: sphere, radius: 10}
  cap: {type: disc, radius: 12}
objects:
  - {name: body, geometry: %s, surface: fresnel, %s}
sources:
  - {name: beam, type: collimated, shape: {disc: 8}, at: [0, 0, -20], spectrum: {lines: {587.56: 1}}}
detectors:
  - {name: focus, type: plane, size: [0.2, 0.2], cells: 8, at: [0, 0, 10.001], direction: [0, 0, -1]}
"""
failures = 0


def check(what, good):
    global failures
    failures += not good
    if not good:
        print("FAILED:", what)


def run(*arguments, ranks=0):
    mpirun = ["mpirun", "-np", str(ranks)] if ranks else []
    done = subprocess.run([*mpirun, PROGRAM, *map(str, arguments)], stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True, check=False)
    return done.returncode, done.stdout, done.stderr


def scene_of(gradient, body="ball", sides="outside: air, inside: m"):
    with open("s.yaml", "w", encoding="utf-8") as file:
        file.write(SCENE % (gradient, body, sides))


def told(status, words, gradient, *body):
    """What `check` answers to a scene."""
    scene_of(gradient, *body)
    code, _, err = run("check", "s.yaml")
    check(f"{gradient}: status {code}, {err}", code == status and all(w in err for w in words))


def trace(target="m.raymap", rays=500, ranks=0):
    shutil.rmtree(target, ignore_errors=True)
    code, out, err = run("trace", "s.yaml", "-o", target, "-n", rays, "--json", "--quiet",
                         ranks=ranks)
    check(f"trace: status {code}: {err}", code in (0, 7))  # 7: fields without a value end rays
    return json.loads(out), err


def answer(*arguments):
    code, out, err = run(*arguments, "--json")
    check(f"{arguments}: status {code}: {err}", code == 0)
    return json.loads(out)


def matched(criterion, target="m.raymap"):
    return answer("query", target, criterion, "--count")["rays"]["matched"]


def write_grid(path, n=41, half=11.0, **change):
    """A Luneburg lens of radius 10, with its continuation outside."""
    axis = numpy.linspace(-half, half, n)
    x, y, z = numpy.meshgrid(axis, axis, axis, indexing="ij")
    value = numpy.sqrt(numpy.maximum(2 - (x * x + y * y + z * z) / 100, 0.01))
    with h5py.File(path, "w") as file:
        data = file.create_dataset(change.get("name", "n"), data=change.get("make", lambda v: v)(value))
        attributes = {"lower": [-half] * 3, "upper": [half] * 3, "length_unit": "mm"}
        attributes.update(change.get("attributes", {}))
        for key, given in attributes.items():
            if given is not None:
                data.attrs[key] = given


def check_grids():
    write_grid("g.h5")
    scene_of("{type: grid, file: g.h5, tolerance: 1e-4}")
    digest = set()
    for ranks in (1, 3):
        summary, _ = trace(f"m{ranks}.raymap", ranks=ranks)
        digest.add(answer("info", f"m{ranks}.raymap")["digest"])
    check(f"one digest: {digest}", len(digest) == 1)
    # The grid's continuation goes on a little beyond the ball; a lens of 41^3 nodes has a sharp focus.
    focused = matched("registered(focus)", "m1.raymap")
    check(f"{focused} of 500 rays in the focus", focused > 470)
    os.rename("g.h5", "gone.h5")
    check("a map without its files", matched("medium(m)", "m1.raymap") > 470)
    check("verify without the files", run("verify", "m1.raymap")[0] == 0)
    code, _, err = run("check", "s.yaml")
    check(err, code == 3 and "s.yaml:5:36: error: ./g.h5 cannot be opened as an HDF5 file" in err)
    os.rename("gone.h5", "g.h5")
    # In metres, in another order, with the frame given by the scene.
    write_grid("si.h5", half=11.0, attributes={"lower": [-0.011] * 3, "upper": None, "length_unit": "m",
                                               "spacing": [0.00055] * 3, "axes": "zyx"})
    told(0, [], "{type: grid, file: si.h5, tolerance: 1e-4}")
    trace("si.raymap")
    check("metres", matched("registered(focus)", "si.raymap") > 470)


def check_bad_grids():
    told(3, ["5:36", "has no dataset 'index'", "name it with 'dataset:'"],
         "{type: grid, file: g.h5, dataset: index}")
    write_grid("b.h5", make=lambda v: v[0])
    told(3, ["dataset 'n' has 2 dimensions, a grid has 3"], "{type: grid, file: b.h5}")
    write_grid("b.h5", make=lambda v: v[:, :1, :])
    told(3, ["a grid has 1 node along y: it needs 2 at least"], "{type: grid, file: b.h5}")
    write_grid("b.h5", attributes={"length_unit": "parsec"})
    told(3, ["unknown length_unit 'parsec'; known: nm, um, mm, cm, m, in"], "{type: grid, file: b.h5}")
    write_grid("b.h5", attributes={"lower": [1, 2]})
    told(3, ["an attribute 'lower' that is not 3 numbers"], "{type: grid, file: b.h5}")
    write_grid("b.h5", attributes={"lower": None})
    told(3, ["does not say where it lies", "give 'origin' and 'spacing'"], "{type: grid, file: b.h5}")
    write_grid("b.h5", attributes={"upper": [-11.0, 11, 11]})
    told(3, ["spacing (0, "], "{type: grid, file: b.h5}")
    write_grid("b.h5", make=lambda v: v.astype("S8"))
    told(3, ["dataset 'n' holds no numbers"], "{type: grid, file: b.h5}")
    write_grid("b.h5", make=lambda v: numpy.full_like(v, numpy.nan))
    told(3, ["dataset 'n' holds no finite number"], "{type: grid, file: b.h5}")
    write_grid("b.h5", make=lambda v: v - 5)
    told(3, ["medium 'm' has no index > 0", "at body 'body'"], "{type: grid, file: b.h5}")
    write_grid("b.h5", half=6.0)
    told(0, ["warning: medium 'm' has no index > 0", "its value there: none"],
         "{type: grid, file: b.h5, tolerance: 1e-4}")
    with open("b.h5", "wb") as file:
        file.write(b"no HDF5 at all" * 100)
    told(3, ["./b.h5 cannot be opened as an HDF5 file"], "{type: grid, file: b.h5}")


def check_hole():
    """Light that comes to a hole ends there, is counted, and all the rest goes on."""
    def hole(v):
        v = v.copy()
        v[20:23, 20:23, 20:23] = numpy.nan
        return v
    write_grid("h.h5", make=hole)
    told(0, ["the grid has 27 holes", "end there with 'error'"], "{type: grid, file: h.h5, tolerance: 1e-4}")
    summary, err = trace()
    wrong, right = matched("ended(error)"), matched("registered(focus)")
    check(f"{wrong} rays end in the hole, {right} in the focus", 2 < wrong < 100 and right > 350)
    check(f"the first is named: {err}", "which has no index there" in err)
    total = answer("query", "m.raymap", "ended(error) or ended(left) or ended(absorbed)", "--count")
    check("nothing is lost", total["rays"]["matched"] == total["rays"]["total"] == 500)


def check_models():
    told(3, ["s.yaml:5:17: error: medium 'm' has no index > 0", "change the model's numbers"],
         "{type: luneburg, radius: 5}")
    told(3, ["'tolerance' must be greater than 0, not 0"], "{type: luneburg, radius: 10, tolerance: 0}")
    told(0, ["warning: gradient medium 'm' has no closed boundary", "close the body"],
         "{type: axial, coefficients: [1.5, 0.01]}", "cap", "back: air, front: m")
    told(0, ["warning: medium 'm' has no index > 0", "warning: gradient medium 'm' has no index where light comes"],
         "{type: formula, formula: 'x - 3'}")
    summary, err = trace()
    check("errors of a formula are counted", 200 < matched("ended(error)") < 500)


def check_plugins():
    for name in ("rod", "rubbish", "newer"):
        shutil.copy(os.path.join(PLUGINS, name + ".so"), name + ".so")
    told(3, ["s.yaml:5:38: error: plug-in './absent.so' cannot be read: check its name, or build it"],
         "{type: plugin, file: absent.so}")
    told(3, ["is of version 2 of the interface", "build it against"], "{type: plugin, file: newer.so}")
    told(3, ["refuses its parameters: give [n0, alpha0, length]"], "{type: plugin, file: rod.so}")
    with open("text.so", "w", encoding="utf-8") as file:
        file.write("no code")
    told(3, ["plug-in './text.so' cannot be loaded"], "{type: plugin, file: text.so}")
    told(0, ["has no index > 0", "light that comes there ends with 'error'"],
         "{type: plugin, file: rubbish.so}")
    trace(ranks=2)
    wrong = matched("ended(error)")
    check(f"{wrong} rays end in rubbish", wrong > 450)
    scene_of("{type: plugin, file: rod.so, parameters: [1.5, 0.01, 100]}")
    trace(ranks=2)
    with h5py.File("m.raymap/map.h5", "r") as index:
        plugins = index.attrs["plugins"]
    check(f"provenance: {plugins}", str(plugins).startswith("b'm xxh3:") or str(plugins).startswith("m xxh3:"))
    check("rays through the plug-in", matched("medium(m)") > 470)
    os.remove("rod.so")
    check("a map without the plug-in", matched("medium(m)") > 470)
    # Another file in its place: what is there cannot be gone on with.
    shutil.copy("rubbish.so", "rod.so")
    code, _, err = run("trace", "s.yaml", "-o", "m.raymap", "-n", 4000, "--append", "--quiet")
    check(f"another plug-in is another scene: {code} {err}", code != 0)


check_grids()
check_bad_grids()
check_hole()
check_models()
check_plugins()
sys.exit(1 if failures else 0)
