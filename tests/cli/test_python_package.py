#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: examples/python is a package that pip installs without a network; it opens maps, makes
flat columns, hands on what the program says and how it fails; every example script runs on the
maps of the examples, without matplotlib; what docs/map.md shows in Python runs as it stands there."""
import os
import pathlib
import re
import shutil
import subprocess
import sys

import numpy as np

sys.dont_write_bytecode = True
from asking import SOURCE, check, finish  # noqa: E402
import raymap  # noqa: E402 (asking knows where it is)

PACKAGE = SOURCE / "examples" / "python"


def trace(scene, name, n, *more):
    shutil.rmtree(name, ignore_errors=True)
    raymap.Program().run("trace", scene, "-o", name, "-n", n, "--quiet", *more)
    return name


def script(name, *words, status=0):
    done = subprocess.run([sys.executable, "-B", PACKAGE / name, *map(str, words)], text=True,
                          capture_output=True, check=False)
    check(done.returncode == status, f"{name} {words}: {done.returncode}\n{done.stderr}")
    return done.stdout


def check_reading(lens):
    rays = raymap.open(lens)
    check(rays.digest == raymap.info(lens)["digest"], "digest")
    check(isinstance(rays, raymap.Map) and rays.n_rays == 3000, "a map")
    flat = raymap.records(rays, "segment")
    check(len(flat["ray_id"]) == rays.n_segments and "position_z" in flat, "flat columns")
    columns = rays.columns("segment/position", "ray/segment_count")
    check((flat["position_z"] == columns["segment/position"][:, 2]).all(), "positions")
    check((np.bincount(flat["ray_id"].astype(int), minlength=3000) ==
           columns["ray/segment_count"]).all(), "rays of segments")
    check(len(raymap.records(rays)["id"]) == 3000, "rays")
    raymap.Program().run("query", lens, "bounces > 1000", "-o", "none.raymap", "--force", "--quiet")
    none = raymap.open("none.raymap").columns()
    check({name: (column.dtype, column.shape[1:]) for name, column in none.items()} ==
          {name: (column.dtype, column.shape[1:]) for name, column in rays.columns().items()} and
          all(len(column) == 0 for column in none.values()), "columns of no rays")
    try:
        raymap.records(rays, "legs")
        check(False, "a table that there is not")
    except ValueError as error:
        check("legs" in str(error), "its name")
    try:
        frame = raymap.frame(rays, "segment")
        check(len(frame) == rays.n_segments, "a DataFrame")
    except ImportError as error:
        check("pandas" in str(error), "pandas is optional")


# Nothing in it takes one wavelength from another.
NO_DISPERSION = """raymap: 1
units: cm
spectrum: {mode: spectral, wavelengths: [450, 550, 650]}
media: {air: {index: 1}, water: {index: 1.33}}
surfaces:
  bare: {type: fresnel}
  red: {type: lambert, reflectance: {wavelength: [400, 700], value: [0.1, 0.9]}}
geometries: {ball: {type: sphere, radius: 2}, plate: {type: rectangle, size: [40, 40]}}
objects:
  - {name: drop, geometry: ball, at: [0, 0, 5], surface: bare, inside: water, outside: air}
  - {name: wall, geometry: plate, at: [0, 0, 20], rotate: [0, 20, 0], surface: red, front: air, back: air}
sources:
  - {name: lamp, type: point, at: [1, 0, 0], distribution: isotropic, flux: 3 W, spectrum: D65, medium: air}
detectors:
  - {name: film, type: plane, size: [20, 30], cells: [8, 6], at: [0, 1, 12], direction: [0, 0.2, -1], side: both}
  - {name: sky, type: intensity, cells: [18, 36], axis: [0, 1, 0]}
"""


def mean_of(rows, value):
    good = np.isfinite(value)
    return np.average(value[good], weights=rows["flux"][good])


def check_tables():
    """What follows from the columns is what the program says of it."""
    pathlib.Path("water.yaml").write_text(NO_DISPERSION, encoding="utf-8")
    water = trace("water.yaml", "water.raymap", 2000)
    seen = raymap.records(raymap.open(water), "registration")
    for name, wanted in (("film", ("x", "y", "angle", "time", "world_x", "world_y", "world_z", "flux")),
                         ("sky", ("x", "y", "angle", "optical_path"))):
        rows = {key: column[(seen["detector_name"] == name) & (seen["registered"] == 1)]
                for key, column in seen.items()}
        for key in wanted:
            of = key if key == "flux" else f"{key}({name})"
            said = raymap.stats(water, of, detector=name)["mean"]["value"]
            check(abs(mean_of(rows, rows[key]) - said) < 1e-9 * abs(said),
                  f"{of}: {mean_of(rows, rows[key])}, not {said}")
    check(set(seen["source_name"]) == {"lamp"} and np.isnan(seen["wavelength"]).all(), "no wavelength of its own")
    script = re.search("```python\n(.*?)```", (SOURCE / "docs" / "python.md").read_text(encoding="utf-8"), re.DOTALL)
    told = {}
    exec(script[1].replace("lens.raymap", water).replace("sensor", "film"), told)  # pylint: disable=exec-used
    bins = raymap.stats(water, "wavelength", detector="film")["histogram"]["flux"]
    check(np.allclose(told["spectrum"], bins, rtol=1e-6), f"a spectrum: {told['spectrum']}, not {bins}")
    rows = raymap.records(raymap.open(water), "segment", "object_name", "flux")
    check(list(rows) == ["object_name", "flux"] and None in rows["object_name"], "columns that were named")
    try:
        raymap.records(raymap.open(water), "registration", "times")
        check(False, "a column that there is not")
    except ValueError as error:
        check("'times'" in str(error) and "angle, time" in str(error), f"its name: {error}")


def check_asking(lens):
    some = raymap.query(lens, "registered(sensor)")
    check(some["rays"]["total"] == 3000 and 0 < some["rays"]["matched"] < 3000, "query")
    check(len(raymap.query(lens, "all", "segments > 3")) == 2, "two criteria")
    seen = raymap.image(lens, "sensor", where="segments > 3")
    check(seen.values.shape == (len(seen.y), len(seen.x)), "an image")
    sums = raymap.detector(lens, "sensor", where="segments > 3")
    check(seen.rays.sum() == sums["registrations"], "its registrations")
    check(seen.about["criterion"] == "segments > 3", "what the image is of")
    check(raymap.report(lens, 17)["ray"] == 17, "report")
    answer = raymap.compare(lens, where=["segments > 3", "segments > 4"])
    check(answer["paired"], "an option given twice")
    for status, question in ((3, lambda: raymap.query(lens, "hit(")),
                             (3, lambda: raymap.info("missing.raymap")),
                             (2, lambda: raymap.detector(lens, "sensor", colour=True))):
        try:
            question()
            check(False, f"no error {status}")
        except raymap.RaymapError as error:
            check(error.status == status and str(error), f"{error.status}: {error}")
    two = raymap.Program(os.environ["RAYMAP"], ["mpirun", "-np", "2"])
    check(raymap.query(lens, "segments > 3", program=two)["rays"] ==
          raymap.query(lens, "segments > 3")["rays"], "under mpirun")


def refused(kind, question, word):
    try:
        question()
        check(False, f"no {kind.__name__} with '{word}'")
    except kind as error:
        check(word in str(error), f"'{word}': {error}")


def check_given(lens):
    """A path and an open map do everywhere, and what is no such thing is told."""
    with raymap.open(lens) as rays:
        check(raymap.query(rays, "segments > 3")["rays"] == raymap.query(lens, "segments > 3")["rays"], "query of an open map")
        for read in (raymap.records, raymap.table):
            check((read(rays, "ray", "path_length")["path_length"] == read(lens, "ray", "path_length")["path_length"]).all(),
                  f"{read.__name__} of both")
        refused(TypeError, lambda: rays.portions("segment/position"), '["segment/position"]')
        refused(TypeError, lambda: rays.portion(0, "segment/position"), '["segment/position"]')
    refused(raymap.MapError, rays.columns, "closed")
    try:
        check(len(raymap.frame(lens, "ray", "flux")) == 3000, "a DataFrame of a path")
        refused(TypeError, lambda: raymap.frame(raymap.query(lens)), "a list of dicts")
    except ImportError as error:
        check("pandas" in str(error), "pandas is optional")
    first, picked = raymap.query(lens, limit=3), raymap.query(lens, sample=3, seed=2)
    check([ray["ray"] for ray in first] == [0, 1, 2] and len(picked) == 3 and picked != first, "rays of a query")
    longest = raymap.query(lens, top=3, of="path_length")["top"]
    length = raymap.records(lens, "ray", "path_length")["path_length"]
    check([ray["ray"] for ray in longest] == list(np.argsort(-length, kind="stable")[:3]), f"greatest values: {longest}")


def check_names_of_links():
    """Names that no group of the index can have: docs/map.md, /detector/NAME."""
    odd = NO_DISPERSION.replace("name: film", "name: 'fi/lm'").replace("name: sky", "name: '.'")
    pathlib.Path("odd.yaml").write_text(odd, encoding="utf-8")
    with raymap.open(trace("odd.yaml", "odd.raymap", 100)) as rays:
        check([(its["name"], its["type"], tuple(its["cells"])) for its in rays.detectors] ==
              [("fi/lm", "plane", (8, 6)), (".", "intensity", (18, 36))], f"detectors: {rays.detectors}")


def check_scripts(lens, other, room):
    """Each on one of the two: a map of columns and a compact one."""
    detector = raymap.open(room).names["detector"][0]
    check("peak" in script("detector_image.py", room, detector), "an image")
    check("counted from the columns" in script("energy_balance.py", room), "energy")
    said = script("number_statistics.py", lens)
    mean, hand = (float(line.split("mean ")[1].split()[0]) for line in said.splitlines()
                  if "mean " in line)
    check(abs(mean - hand) < 1e-7 * abs(hand), f"means: {mean} {hand}")
    check("rays reach sensor" in script("ghosts.py", lens, "sensor"), "ghosts")
    check("same" in script("compare_maps.py", lens, other), "comparison")
    check("both samples come from one map" in script(
        "compare_maps.py", lens, "--where", "segments > 3", "--where", "segments > 4"), "criteria")
    at = raymap.open(lens).detectors[0]
    said = script("own_receiver.py", "--cells", 32, lens, *at["origin"], at["size"][0],
                  *at["axis"])
    check("registrations" in said and not said.startswith("0 "), "an own receiver")
    check("ray 5 of" in script("raymap_reader.py", lens, 5), "one ray")


def check_plain(target):
    """Columns of a compact map are those that its rays are traced to, and the copy goes."""
    want = raymap.open(target).columns("segment/position")["segment/position"]
    with raymap.plain(target) as copy:
        where = copy.path
        check(copy.digest == raymap.open(target).digest and
              copy.columns("segment/position")["segment/position"].tobytes() == want.tobytes(),
              "columns of a compact map")
        with raymap.plain(where) as same:
            check(same.path == where, "a map of columns is taken as it is")
    check(where != target and not os.path.exists(where), "the copy is gone")


def check_pip():
    """Into an environment of its own, from a copy: the source tree stays as it is."""
    shutil.rmtree("venv", ignore_errors=True)
    shutil.rmtree("copy", ignore_errors=True)
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", "--system-site-packages", "venv"], check=True)
    shutil.copytree(PACKAGE, "copy", ignore=shutil.ignore_patterns("__pycache__"))
    python = os.path.abspath("venv/bin/python")
    setup = subprocess.run([python, "-c", "import setuptools, pip; print(setuptools.__version__)"],
                           capture_output=True, text=True, check=False)
    if setup.returncode != 0 or int(setup.stdout.split(".")[0]) < 61:
        print("not tested: python3-pip or python3-setuptools is missing, or older than 61")
        return
    done = subprocess.run([python, "-m", "pip", "install", "--quiet", "--no-index", "--no-deps",
                           "--no-build-isolation", "./copy"], capture_output=True, text=True,
                          check=False)
    check(done.returncode == 0, "pip install: " + done.stdout + done.stderr)
    clean = {key: value for key, value in os.environ.items() if key != "PYTHONPATH"}
    done = subprocess.run([python, "-c", "import raymap, raymap.plot, sys\n"
                           "print(raymap.__file__, len(raymap.records(raymap.open(sys.argv[1]))['id']))", "lens.raymap"],
                          capture_output=True, text=True, check=False, env=clean)
    check("venv" in done.stdout and "3000" in done.stdout, "installed: " + done.stdout + done.stderr)


def check_library():
    """RAYMAP_LIBRARY that is empty is none, and a library that is another one is told."""
    code = "import raymap\ntry:\n print(len(raymap.records('lens.raymap')['id']))\nexcept raymap.MapError as error:\n print(error)"
    for value, told in (("", "3000"), ("libc.so.6", "name it with RAYMAP_LIBRARY ("), ("no.so", "name it with RAYMAP_LIBRARY (")):
        done = subprocess.run([sys.executable, "-B", "-c", code], text=True, capture_output=True, check=False,
                              env={**os.environ, "PYTHONPATH": str(PACKAGE), "RAYMAP_LIBRARY": value})
        check(told in done.stdout and done.returncode == 0, f"RAYMAP_LIBRARY={value}: {done.stdout}{done.stderr}")


def check_document(columns, lens):
    """NAME.raymap there has columns, lens.raymap is what `raymap trace` makes."""
    shutil.rmtree("document", ignore_errors=True)
    os.mkdir("document")
    os.symlink(os.path.abspath(columns), "document/NAME.raymap")
    os.symlink(os.path.abspath(lens), "document/lens.raymap")
    text = (SOURCE / "docs" / "map.md").read_text(encoding="utf-8")
    shown = re.findall("```python\n(.*?)```", text, re.DOTALL)
    check(len(shown) == 2, f"docs/map.md shows Python {len(shown)} times, not twice")
    for code in shown:
        done = subprocess.run([sys.executable, "-B", "-c", code], cwd="document", text=True,
                              capture_output=True, check=False,
                              env={**os.environ, "PYTHONPATH": str(PACKAGE)})
        check(done.returncode == 0, "docs/map.md: " + done.stderr)


examples = SOURCE / "examples"
LENS = trace(examples / "double-gauss" / "scene.yaml", "lens.raymap", 3000, "--encoding", "plain")
OTHER = trace(examples / "double-gauss" / "scene.yaml", "other.raymap", 3000, "--seed", 2)
ROOM = trace(examples / "room" / "scene.yaml", "room.raymap", 2000)
check_reading(LENS)
check_tables()
check_asking(LENS)
check_given(LENS)
check_names_of_links()
check_library()
check_scripts(LENS, OTHER, ROOM)
check_plain(ROOM)
check_document(LENS, OTHER)
check_pip()
finish()
