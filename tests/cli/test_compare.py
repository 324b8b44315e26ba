#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: `raymap compare` tells maps that differ from maps that do not. Its z and chi-square
are those of numpy from the columns; p-values of maps that differ by their seed alone are uniform;
a changed surface is found; two criteria of one map are a paired sample; what cannot be compared, or
was asked wrongly, is said."""
import csv
import itertools
import json
import math
import os
import subprocess
import sys

import h5py
import numpy as np

sys.dont_write_bytecode = True

from spot_scene import SPOT

PROGRAM = os.environ["RAYMAP"]
PAIRS = int(os.environ.get("RAYMAP_COMPARE_PAIRS", "5"))  # tests/slow asks for 40
failures = 0

LENS = """raymap: 1
units: mm
spectrum: {mode: spectral, wavelengths: [486.13, 587.56, 656.27]}
media: {air: {index: 1}, glass: {glass: N-BK7}}
surfaces:
  polished: {type: fresnel}
  black: {type: absorber}
  white: {type: lambert, reflectance: REFLECTANCE}
geometries:
  slab: {type: lens, surface: polished, edge: black, surfaces: [
     {radius: 50, thickness: 5, medium: glass, aperture: 10},
     {radius: -50, medium: air, aperture: 10}]}
  wall: {type: rectangle, size: [40, 40]}
objects:
  - {name: lens, geometry: slab, outside: air}
  - {name: screen, geometry: wall, at: [0, 0, 40], surface: white, front: air, back: air}
sources:
  - {name: lamp, type: point, at: [0, 0, -30], direction: [0, 0, 1], distribution: {cone: 15},
     flux: 1 W, medium: air}
  - {name: side, type: point, at: [5, 0, 20], direction: [0, 0, 1], distribution: {cone: 40},
     flux: 3 W, medium: air}
detectors:
  - {name: sensor, type: plane, on: screen, size: [40, 40], cells: [16, 16], at: [0, 0, 40],
     direction: [0, 0, -1]}
"""
# Light goes to and fro between two white walls: a ray is registered several times.
ROOM = """raymap: 1
units: mm
spectrum: {mode: spectral, wavelengths: [550]}
media: {air: {index: 1}}
surfaces: {white: {type: lambert, reflectance: 0.8}}
geometries: {wall: {type: rectangle, size: [40, 40]}}
objects:
  - {name: low, geometry: wall, at: [0, 0, 0], surface: white, front: air, back: air}
  - {name: high, geometry: wall, at: [0, 0, 20], surface: white, front: air, back: air}
sources:
  - {name: lamp, type: point, at: [0, 0, 10], direction: [0, 0, 1], distribution: isotropic,
     flux: 1 W, medium: air}
detectors:
  - {name: sensor, type: plane, on: low, size: [40, 40], cells: [20, 20], at: [0, 0, 0],
     direction: [0, 0, 1]}
"""


def check(good, what):
    global failures
    if not good:
        failures += 1
        print("FAIL " + what, flush=True)


def run(*arguments, status=0):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                          check=False)
    if done.returncode != status:
        check(False, f"{arguments}: status {done.returncode}, not {status}: {done.stderr}")
    return done


def compare(*arguments):
    return json.loads(run("compare", *arguments, "--json").stdout)


def trace(text, name, n, seed, *more):
    with open(name + ".yaml", "w", encoding="utf-8") as file:
        file.write(text)
    run("trace", name + ".yaml", "-o", name + ".raymap", "-n", n, "--seed", seed, "--quiet",
        "--encoding", "plain", "--force", *more)
    return name + ".raymap"


class Columns:
    """A plain map's columns, in whatever order its pieces have them."""

    def __init__(self, path):
        with h5py.File(path + "/map.h5") as index:
            self.flux, self.emitted = index["source/flux"][:], index["source/emitted"][:]
            self.objects = [name.decode() for name in index["name/object"][:]]
        parts = []
        for folder, _, files in sorted(os.walk(path)):
            for file in sorted(files):
                if file.startswith("piece-"):
                    with h5py.File(os.path.join(folder, file)) as piece:
                        parts.append({key: piece[key][:] for key in (
                            "ray/id", "ray/source", "ray/stop", "ray/segment_count",
                            "ray/registration_count", "ray/path_length", "segment/object",
                            "segment/event", "registration/cell",
                            "registration/registered")})
        whole = {key: np.concatenate([part[key] for part in parts]) for key in parts[0]}
        self.id, self.source, self.stop = (whole["ray/" + k] for k in ("id", "source", "stop"))
        self.path_length, self.segment_count = whole["ray/path_length"], whole["ray/segment_count"]
        self.object, self.event = whole["segment/object"], whole["segment/event"]
        self.last = whole["segment/object"][np.cumsum(whole["ray/segment_count"]) - 1]
        ray = np.repeat(np.arange(len(self.id)), whole["ray/registration_count"])
        seen = whole["registration/registered"] == 1
        self.hit_ray, self.hit_cell = ray[seen], whole["registration/cell"][seen]


def check_spot():
    """A spot in a wide field has bins of its own: its size is compared, too."""
    small, again = (trace(SPOT.replace("RADIUS", "0.01"), name, 8000, seed)
                    for name, seed in (("spot1", 51), ("spot2", 52)))
    large = trace(SPOT.replace("RADIUS", "0.013"), "spot3", 8000, 53)
    for other, same in ((again, True), (large, False)):
        answer = compare(small, other, "--of", "x(sensor)")
        check(answer["same"] is same and answer["tests"][0]["degrees"] >= 20,
              f"a spot and {other}: {answer['tests'][0]}")


def spread(q, n):
    return n / (n - 1) * ((q ** 2).sum() - q.sum() ** 2 / n)


def own(columns, q):
    """Flux and its standard error, from what each ray counts."""
    flux = variance = 0.0
    for s, n in enumerate(columns.emitted):
        unit, some = columns.flux[s] / n, q[columns.source == s]
        flux += unit * some.sum()
        variance += unit ** 2 * spread(some, n)
    return flux, math.sqrt(variance)


def pooled_z(a, qa, b, qb):
    """Independent samples: one variance of q for both."""
    difference = variance = 0.0
    for s, (n, m) in enumerate(zip(a.emitted, b.emitted)):
        x, y = qa[a.source == s], qb[b.source == s]
        both = np.concatenate([x, y])
        difference += a.flux[s] / n * x.sum() - b.flux[s] / m * y.sum()
        variance += (a.flux[s] ** 2 / n + b.flux[s] ** 2 / m) * spread(both, n + m) / (n + m)
    return difference / math.sqrt(variance)


def near(got, want, tolerance=1e-9):
    return got is not None and math.isclose(got, want, rel_tol=tolerance, abs_tol=1e-12)


def find(answer, quantity, name):
    return next(t for t in answer["tests"] if (t["quantity"], t["name"]) == (quantity, name))


def merged(expected, rest):
    """Neighbouring bins until both samples expect 10 rays; slices, and whether the last is left
    out because too few rays lie in none."""
    groups, at, held = [], 0, np.zeros(2)
    for b in range(len(expected[0])):
        held += [e[b] for e in expected]
        if (held >= 10).all():
            groups.append([at, b + 1])
            at, held = b + 1, np.zeros(2)
    groups[-1][1] = len(expected[0])
    return groups if (np.array(rest) >= 10).all() else groups[:-1]


def pearson(a, b, counts, source):
    """Chi-square of two rows of counts of one source, with the rays in no bin as one more."""
    n = np.array([c.emitted[source] for c in (a, b)])
    pool = (counts[0] + counts[1]) / n.sum()
    expected = [m * pool for m in n]
    groups = merged(expected, [m - e.sum() for m, e in zip(n, expected)])
    table = np.array([[row[i:j].sum() for i, j in groups] for row in counts])
    table = np.column_stack([table, n - table.sum(axis=1)])
    want = n[:, None] * table.sum(axis=0) / n.sum()
    return ((table - want) ** 2 / want).sum(), len(groups)


def wald(a, b, q):
    """Chi-square of two samples [ray][group] of one source: with the covariance of all rays."""
    n = [len(x) for x in q]
    both = np.concatenate(q)
    covariance = np.cov(both.T, bias=True) * (1 / n[0] + 1 / n[1])
    d = q[0].mean(axis=0) - q[1].mean(axis=0)
    return d @ np.linalg.solve(covariance, d)


def check_against_numpy():
    one, other = trace(LENS.replace("REFLECTANCE", "0.5"), "n1", 9000, 11), \
        trace(LENS.replace("REFLECTANCE", "0.5"), "n2", 15000, 12)
    a, b = Columns(one), Columns(other)
    answer = compare(one, other)
    q = [np.bincount(c.hit_ray, minlength=len(c.id)).astype(float) for c in (a, b)]
    test = find(answer, "detector", "sensor")
    for k, columns in enumerate((a, b)):
        flux, error = own(columns, q[k])
        check(near(test["values"][k]["value"], flux), f"flux {k}: {flux}")
        check(near(test["values"][k]["standard_error"], error, 1e-7), f"error {k}: {error}")
    check(near(test["z"], pooled_z(a, q[0], b, q[1]), 1e-7), "z of the sensor")
    check(near(test["p"], math.erfc(abs(test["z"]) / math.sqrt(2))), "p of the sensor")
    screen = a.objects.index("screen")
    q = [((c.stop == 0) & (c.last == screen)).astype(float) for c in (a, b)]
    check(near(find(answer, "object", "screen")["z"], pooled_z(a, q[0], b, q[1]), 1e-7), "z object")
    # One source alone: Pearson's own sum.
    answer = compare(one, other, "--where", "source(side) and registered(sensor) == 1")
    counts = []
    for c in (a, b):
        times = np.bincount(c.hit_ray, minlength=len(c.id))
        once = (times[c.hit_ray] == 1) & (c.source[c.hit_ray] == 1)
        cell = c.hit_cell[once].astype(int)
        counts.append(np.bincount(cell[:, 0] + 16 * cell[:, 1], minlength=256))
    want, degrees = pearson(a, b, counts, 1)
    check_numbers(one, other, a, b)
    test = find(answer, "image", "sensor")
    check(near(test["chi_square"], want) and test["degrees"] == degrees,
          f"Pearson: {test['chi_square']} / {test['degrees']}, not {want} / {degrees}")
    p = test["p"]  # the average over a grid of the density, against the tail
    x = np.linspace(want, want + 60 * math.sqrt(2 * degrees), 400001)
    density = np.exp((degrees / 2 - 1) * np.log(x / 2) - x / 2 - math.lgamma(degrees / 2)) / 2
    check(abs(np.trapz(density, x) - p) < 1e-6, f"p of chi-square: {p}")


def check_numbers(one, other, a, b):
    """Distributions of numbers and of paths, of one source."""
    where = ("--where", "source(side)")
    mine = [c.source == 1 for c in (a, b)]
    low, high = 20.0, 70.0
    test = find(compare(one, other, *where, "--of", "path_length", "--bins", 30, "--range",
                        f"{low}..{high}"), "number", "path_length")
    counts = []
    for c, some in zip((a, b), mine):
        edges = np.concatenate([[-np.inf], np.linspace(low, high, 31), [np.inf]])
        counts.append(np.histogram(c.path_length[some], edges)[0])
    want, degrees = pearson(a, b, counts, 1)
    check(near(test["chi_square"], want) and test["degrees"] == degrees,
          f"path lengths: {test['chi_square']} / {test['degrees']}, not {want} / {degrees}")
    test = find(compare(one, other, *where, "--of", "segments"), "number", "segments")
    counts = [np.bincount(c.segment_count[some], minlength=60) for c, some in zip((a, b), mine)]
    want, degrees = pearson(a, b, counts, 1)
    check(near(test["chi_square"], want) and test["degrees"] == degrees,
          f"segments: {test['chi_square']} / {test['degrees']}, not {want} / {degrees}")
    # Few paths: they may lie in the bins in any order, which matters to those that are merged.
    first = [np.cumsum(c.segment_count) - c.segment_count for c in (a, b)]
    paths = [[tuple(zip(c.object[f:f + n], c.event[f:f + n])) for f, n in zip(
        at[some], c.segment_count[some])] for c, at, some in zip((a, b), first, mine)]
    seen = [{path: ways.count(path) for path in set(ways)} for ways in paths]
    often = sorted({path for path in {*seen[0], *seen[1]} if len(path) <= 1 or path[0][0] ==
                    a.objects.index("screen") and len(path) == 2})
    answer = compare(one, other, "--test", "paths", "--where",
                     "source(side) and (segments == 1 or segments == 2 and hit(screen))")
    test = find(answer, "paths", "")
    counts = np.array([[some.get(path, 0) for path in often] for some in seen])
    wanted = [pearson(a, b, counts[:, order], 1) for order in
              map(list, itertools.permutations(range(len(often))))]
    check(any(near(test["chi_square"], want) and test["degrees"] == degrees >= 1
              for want, degrees in wanted),
          f"paths: {test['chi_square']} / {test['degrees']}, not one of {wanted}: {counts}")
    for text, words in (("path_lenght", "did you mean"), ("x(film)", "no detector")):
        done = run("compare", one, other, "--of", text, status=3)
        check(words in done.stderr, f"--of {text}: {done.stderr}")
    done = run("compare", one, other, "--of", "bounces", "--bins", "1e9", status=2)
    check("between 1 and 1000" in done.stderr, "a billion bins")


def check_repeated():
    one, other = trace(ROOM, "r1", 8000, 21), trace(ROOM, "r2", 8000, 22)
    a, b = Columns(one), Columns(other)
    test = find(compare(one, other), "image", "sensor")
    counts = [np.bincount(c.hit_cell[:, 0].astype(int) + 20 * c.hit_cell[:, 1], minlength=400)
              for c in (a, b)]
    check(max(np.bincount(a.hit_ray)) > 1, "rays of the room are registered several times")
    groups, at, held = np.zeros(400, int), 0, 0.0
    least = max(10, min(c.sum() for c in counts) / 150)
    for k in range(400):
        groups[k] = at
        held += (counts[0][k] + counts[1][k]) / 2
        if held >= least:
            at, held = at + 1, 0.0
    groups[groups == at] = at - 1
    q = []
    for c in (a, b):
        cell = c.hit_cell[:, 0].astype(int) + 20 * c.hit_cell[:, 1]
        table = np.zeros((len(c.id), at))
        np.add.at(table, (c.hit_ray, groups[cell]), 1)
        q.append(table)
    want = wald(a, b, q)
    check(near(test["chi_square"], want, 1e-6) and test["degrees"] == at,
          f"repeated: {test['chi_square']} / {test['degrees']}, not {want} / {at}")


def check_paired():
    """Two criteria of one map: rays in both cancel."""
    one, a = "n2.raymap", Columns("n2.raymap")
    left, right = "registered(sensor where x < -1)", "registered(sensor where x > -3)"
    answer = compare(one, "--where", left, "--where", right)
    check(answer["paired"] and not answer["independent"], "paired")
    rays = {text: {int(line.split()[0]) for line in run(
        "query", one, text, "--limit", 15000, "--quiet").stdout.splitlines()
        if line and line.split()[0].isdigit()} for text in (left, right)}
    inside = [np.isin(a.id, list(rays[text])).astype(float) for text in (left, right)]
    d = inside[0] - inside[1]
    difference, error = own(a, d)
    test = find(answer, "flux", "")
    check(near(test["z"], difference / error, 1e-7), f"paired z {test['z']}")
    check(near(test["difference"]["standard_error"], error, 1e-7), "paired error")
    flux, error = own(a, inside[0])
    check(near(test["values"][0]["value"], flux) and
          near(test["values"][0]["standard_error"], error, 1e-7), "own error")
    check(sum(inside[0] * inside[1]) > 100, "the criteria overlap")
    # The scene is symmetric in y: halves agree, and far better than independent ones need.
    answer = compare(one, "--where", "registered(sensor where y < 0)", "--where",
                     "registered(sensor where y > 0)", "--test", "flux,object")
    check(answer["same"], "two halves of a symmetric scene are the same")
    answer = compare(one, "--where", "source(side)", "--where", "all", "--test", "flux")
    check(not answer["same"], "a part is not the whole")
    answer = compare(one, "--where", "all", "--where", "all")
    check(answer["same"] and answer["tested"] == 0, "nothing differs: nothing to test")


def table_of(path):
    with open(path, encoding="utf-8") as file:
        rows = csv.DictReader(line for line in file if not line.startswith("#"))
        return [{key: float(value) if value else math.nan for key, value in row.items()} for row in rows]


KEYS = {"a": "a", "a_standard_error": "a_standard_error", "b": "b", "b_standard_error": "b_standard_error",
        "difference": "difference", "standard_error": "standard_error", "z": "z"}


def check_files(maps, options, rows, shape, kinds):
    """Every format has the same numbers; the picture is one."""
    answer = compare(*maps, *options, "-o", "d.json", "--force")
    for kind in ("h5", *kinds):
        run("compare", *maps, *options, "-o", "d." + kind, "--force", "--quiet")
    with open("d.json", encoding="utf-8") as file:
        document = json.load(file)
    bins = document.pop("bins")
    check(document == answer and len(bins) == 1, f"{options}: JSON with bins is that without, and one distribution")
    numbers = np.load("d.npz") if "npz" in kinds else None
    with h5py.File("d.h5") as file:
        places = {} if len(shape) == 1 else {key: key for key in rows[0] if key in ("x", "y", "theta", "phi")}
        check(len(places) == 2 * len(shape) - 2, f"{options}: cells have places")
        for key, name in {**KEYS, **places}.items():
            want = [row[name] for row in rows]
            check(np.array_equal(file[key][:].ravel(), want, equal_nan=True) and file[key].shape == shape, f"{options}: {key} of .h5")
            check(not numbers or np.array_equal(numbers[key].ravel(), want, equal_nan=True), f"{options}: {key} of .npz")
            own = [math.nan if v is None else v for v in bins[0][key]]
            check(np.array_equal(own, want, equal_nan=True), f"{options}: {key} of JSON")
    if "svg" in kinds:
        with open("d.svg", encoding="utf-8") as file:
            text = file.read()
        check("difference of" in text and maps[0] in text, f"{options}: a picture")
    check("png" not in kinds or os.path.getsize("d.png") > 5000, f"{options}: a picture in pixels")


def check_bins():
    """-o: cells of a detector and bins of a number, of two maps and of two criteria of one."""
    text = LENS.replace("REFLECTANCE", "0.5")
    one, other = "n1.raymap", trace(text.replace("cone: 40", "cone: 38"), "b2", 15000, 52)
    a, b = Columns(one), Columns(other)
    run("compare", one, other, "-o", "image.csv", "--force")
    rows = table_of("image.csv")
    check(len(rows) == 256, "a row per cell")
    area = (40e-3 / 16) ** 2
    counted = 0
    for row in rows[::5] + rows[120:136]:
        cell = np.array([row["i"], row["j"]])
        q = [np.bincount(c.hit_ray[(c.hit_cell == cell).all(axis=1)], minlength=len(c.id)).astype(float) for c in (a, b)]
        check(near(row["x"], -20 + 2.5 * (row["i"] + 0.5)) and near(row["y"], -20 + 2.5 * (row["j"] + 0.5)), "centres")
        for key, columns, own_q in (("a", a, q[0]), ("b", b, q[1])):
            flux, error = own(columns, own_q)
            check(near(row[key], flux / area) and near(row[key + "_standard_error"], error / area, 1e-7), f"cell {cell}: {row}")
        if q[0].sum() + q[1].sum() > 0:
            z = pooled_z(a, q[0], b, q[1])
            check(near(row["z"], z, 1e-6) and near(row["difference"] / row["standard_error"], z, 1e-6), f"z of cell {cell}: {row['z']}, not {z}")
            counted += 1
    check(counted > 20, f"{counted} cells have rays")
    check_files((one, other), (), rows, (16, 16), ("npz", "png"))
    options = ("--of", "path_length", "--bins", 12, "--range", "20..70")
    run("compare", one, other, *options, "-o", "number.csv", "--force")
    rows = table_of("number.csv")
    edges = np.linspace(20, 70, 13)
    for k, row in enumerate(rows):
        q = [((c.path_length >= edges[k]) & ((c.path_length < edges[k + 1]) if k < 11 else (c.path_length <= 70))).astype(float)
             for c in (a, b)]
        check(near(row["low"], edges[k]) and near(row["high"], edges[k + 1]), "edges")
        for key, columns, own_q in (("a", a, q[0]), ("b", b, q[1])):
            flux, error = own(columns, own_q)
            check(near(row[key], flux) and near(row[key + "_standard_error"], error, 1e-7), f"bin {k}: {row}")
        if q[0].sum() + q[1].sum() > 0:
            check(near(row["z"], pooled_z(a, q[0], b, q[1]), 1e-6), f"z of bin {k}")
    check_files((one, other), options, rows, (12,), ("npz", "svg"))
    # without a wish for bins: fine ones joined to 50 equal ones, with all the flux
    run("compare", one, other, "--of", "path_length", "-o", "number.csv", "--force")
    rows = table_of("number.csv")
    flux = own(a, np.ones(len(a.id)))[0]
    check(len(rows) == 50 and near(sum(row["a"] for row in rows), flux), f"{len(rows)} joined bins")
    check(near(rows[0]["low"], min(a.path_length.min(), b.path_length.min())), "from the least value")
    check_bins_paired(one, a)
    check_bins_over(one, other, a)


def check_bins_paired(one, a):
    """The rays of both criteria cancel in every cell."""
    where = ("segments > 1", "source(side)")
    options = [word for text in where for word in ("--where", text)]
    run("compare", one, *options, "-o", "pair.csv", "--force")
    rows = table_of("pair.csv")
    inside = [a.segment_count > 1, a.source == 1]
    check((inside[0] & inside[1]).sum() > 100, "rays that both hold")
    area = (40e-3 / 16) ** 2
    for row in rows[100:160:3]:
        hits = np.bincount(a.hit_ray[(a.hit_cell == [row["i"], row["j"]]).all(axis=1)], minlength=len(a.id)).astype(float)
        for key, some in zip("ab", inside):
            flux, error = own(a, hits * some)
            check(near(row[key], flux / area) and near(row[key + "_standard_error"], error / area, 1e-7), f"paired: {row}")
        difference, error = own(a, hits * inside[0] - hits * inside[1])
        check(near(row["difference"], difference / area), f"paired difference: {row}")
        if error > 0:
            check(near(row["z"], difference / error, 1e-6), f"paired z: {row['z']}, not {difference / error}")
    check_files((one,), options, rows, (16, 16), ("svg",))


def check_bins_over(one, other, a):
    """Receivers: the detector's own plane once more, and one that the scenes did not have."""
    with open("over.yaml", "w", encoding="utf-8") as file:
        file.write("detectors:\n"
                   "  - {name: again, type: plane, on: screen, size: [40, 40], cells: [16, 16], at: [0, 0, 40], direction: [0, 0, -1]}\n"
                   "  - {name: near, type: plane, size: [30, 30], cells: [6, 6], at: [0, 0, 20], direction: [0, 0, -1]}\n")
    over = ("--receivers", "over.yaml")
    answer = compare(one, other, *over)
    keys = ("values", "difference", "z", "chi_square", "degrees", "p")
    for kind in ("detector", "image"):
        mine, theirs = find(answer, kind, "sensor"), find(answer, kind, "again")
        check([mine.get(key) for key in keys] == [theirs.get(key) for key in keys], f"{kind} of a receiver over the sensor")
    check(find(answer, "detector", "near")["values"][0]["rays"] > 1000, "a receiver between")
    run("compare", one, other, *over, "--detector", "again", "-o", "again.csv", "--force")
    run("compare", one, other, "-o", "image.csv", "--force")
    check(table_of("again.csv") == table_of("image.csv") or str(table_of("again.csv")) == str(table_of("image.csv")), "its image")
    answer = compare(one, other, *over, "--of", "x(near)", "--where", "registered(near)")
    check(find(answer, "number", "x(near)")["degrees"] > 10, "numbers of a receiver")
    done = run("compare", one, other, *over, "-o", "two.csv", status=2)
    check("--detector NAME" in done.stderr, f"which detector: {done.stderr}")
    done = run("compare", one, other, "-o", "two.csv", "--of", "segments", "--of", "bounces", status=2)
    check("one --of" in done.stderr, "two numbers in one table")
    run("compare", one, other, "-o", "two.json", "--of", "segments", "--of", "bounces", "--force")
    with open("two.json", encoding="utf-8") as file:
        check([bins["name"] for bins in json.load(file)["bins"]] == ["segments", "bounces"], "two numbers in JSON")
    done = run("compare", one, other, "-o", "two.txt", status=2)
    for options, kinds in ((("--of", "path_length"), ("json", "svg")), ((), ("csv", "npz"))):
        for kind in kinds:
            run("compare", one, other, "--where", "segments > 9000", *options, "-o", "none." + kind, "--force", "--quiet")
    check(all(row["a"] == 0 and math.isnan(row["z"]) for row in table_of("none.csv")), "nothing matches: zeros")


def check_uniform():
    """Pairs of seeds: z over the sensor, chi-square of its image (Kolmogorov & Smirnov)."""
    text = LENS.replace("REFLECTANCE", "0.5")
    p = {("detector", "sensor"): [], ("image", "sensor"): [], ("paths", ""): [],
         ("number", "x(sensor)"): [], ("number", "path_length"): []}
    false_alarms = 0
    for k in range(PAIRS):
        maps = [trace(text, f"u{i}", 2500, 1000 + 2 * k + i, "--threads", "1") for i in (0, 1)]
        answer = compare(*maps, "--threads", "1", "--of", "x(sensor)", "--of", "path_length",
                         "--test", "flux,detector,object,stop,image,paths")
        false_alarms += not answer["same"]
        for (quantity, name), values in p.items():
            values.append(find(answer, quantity, name)["p"])
    check(false_alarms <= 2, f"{false_alarms} of {PAIRS} pairs that differ by their seed alone")
    for quantity, values in p.items():
        rank = np.arange(1, PAIRS + 1) / PAIRS
        far = np.abs(np.sort(values) - (rank - 0.5 / PAIRS)).max() + 0.5 / PAIRS
        # P(D > d) = 2 exp(-2 n d^2) = 0.001
        check(far < math.sqrt(math.log(2000) / 2 / PAIRS), f"p-values of {quantity} are not uniform: D = {far:.3f}")


def check_verdicts():
    half = trace(LENS.replace("REFLECTANCE", "0.5"), "v1", 12000, 41)
    less = trace(LENS.replace("REFLECTANCE", "0.45"), "v2", 12000, 42)
    answer = compare(half, less)
    check(not answer["same"] and not find(answer, "object", "screen")["same"] and
          find(answer, "detector", "sensor")["same"], "a darker screen is found, and where")
    check(answer["significance"] == 0.01 and answer["correction"] == "holm", "defaults")
    answer = compare(half, half)
    check(answer["identical"] and answer["same"] and not answer["independent"], "identical maps")
    akin = trace(LENS.replace("REFLECTANCE", "0.45"), "v3", 12000, 41)
    answer = compare(half, akin)
    check(not answer["independent"] and answer["shared_rays"] == 12000 and
          "same seed" in answer["notes"][0], "the same random numbers are told")
    answer = compare(trace(LENS.replace("REFLECTANCE", "0.5"), "part", 8000, 41), half)
    check(answer["shared_rays"] == 8000 and answer["same"], "a part of the map's own rays")
    check(not answer["suspiciously_equal"], "a part is no suspicion")
    bright = trace(LENS.replace("REFLECTANCE", "0.5").replace("flux: 3 W", "flux: 4 W"), "v4", 9000,
                   43)
    answer = compare(half, bright, "--test", "flux")
    check(not answer["same"] and find(answer, "flux", "side")["p"] == 0, "a brighter lamp")
    few = compare(half, less, "--where", "source(side) and ray < 9")
    for test in few["tests"]:
        check(test["method"] in ("binomial", None), f"few rays are counted: {test['name']}")
    check("verdict      none" in run("compare", half, less, "--where", "segments > 9000").stdout,
          "no verdict where nothing was tested")
    none = compare(half, less, "--where", "segments > 9000")
    check(none["same"] and not none["tests"] and none["empty"] > 0, "nothing matches")


def check_mistakes():
    one, other = "v1.raymap", "v2.raymap"
    lumen = trace(LENS.replace("REFLECTANCE", "0.5").replace(" W,", " lm,"), "m1", 500, 1)
    named = trace(LENS.replace("REFLECTANCE", "0.5").replace("name: lamp", "name: bulb").replace(
        "name: side", "name: spot"), "m2", 500, 2)
    screen = trace(LENS.replace("REFLECTANCE", "0.5").replace("name: screen", "name: paper").replace(
        "on: screen", "on: paper").replace("[16, 16]", "[10, 10]"), "m3", 500, 3)
    for status, words, arguments in (
            (2, "--where A --where B", (one, "--where", "all")),
            (2, "at most two", (one, other, "--where", "all", "--where", "all", "--where", "all")),
            (2, "between 0 and 1", (one, other, "--significance", "0")),
            (2, "did you mean 'image'", (one, other, "--test", "images")),
            (3, "no detector named", (one, other, "--detector", "film")),
            (3, "criterion:1:5", (one, other, "--where", "hit(lenz)")),
            (3, "criterion:1:1", (one, "--where", "all", "--where", ") or (")),
            (3, "missing.raymap", (one, "missing.raymap")), (3, "in W and", (one, lumen)),
            (3, "no source of the same name", (one, named))):
        done = run("compare", *arguments, status=status)
        check(words in done.stderr, f"{arguments}: '{words}' is not said: {done.stderr}")
    answer = compare(one, screen)
    check(answer["samples"][0]["only_here"] == ["object screen"] and
          answer["samples"][1]["only_here"] == ["object paper"], "names in one map alone")
    check(find(answer, "image", "sensor")["note"] == "its grid differs", "another grid")
    for k, where in enumerate(("hit(lens.*)", "registered(sensor)")):
        run("query", one, where, "-o", f"q{k}.raymap", "--force", "--quiet")
    done = run("compare", "q0.raymap", "q1.raymap", status=3)
    check("--where A --where B" in done.stderr and "different criteria" not in done.stderr, "maps picked out of one trace")


check_against_numpy()
check_repeated()
check_paired()
check_bins()
check_uniform()
check_verdicts()
check_spot()
check_mistakes()
print(f"{failures} failures")
sys.exit(failures > 0)
