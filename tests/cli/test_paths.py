#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: `raymap paths` finds the classes that a search through all columns finds, at every
level; each row's criterion counts exactly its rays; the sketch finds every large class."""
import csv
import json
import math
import os
import re
import shutil
import subprocess
import sys
from collections import Counter, defaultdict

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from evaluator_map import BIT, LETTERS, PlainMap  # noqa: E402

PROGRAM = os.environ["RAYMAP"]
DOUBLE_GAUSS = os.path.join(os.environ["SOURCE_DIR"], "examples", "double-gauss", "scene.yaml")

# Names that clash, odd names, groups in groups; things that happen inside media; detectors free in
# space, on an object, on a group and far away.
SCENE = """
raymap: 1
units: mm
spectrum: {mode: spectral, wavelengths: [500, 600]}
limits: {steps: 12}
media:
  air: {index: 1}
  milk: {index: 1.3, scattering: 0.05, absorption: 0.01}
  core: {index: 1.5, absorption: 0.02}
surfaces:
  bare: {type: fresnel}
  white: {type: lambert, reflectance: 0.7}
  gauze: {type: mixture, reflect_specular: 0.3, transmit_specular: 0.3, transmit_diffuse: 0.2}
geometries:
  ball: {type: sphere, radius: 8}
  plate: {type: rectangle, size: [60, 60]}
  doublet:
    type: lens
    surface: bare
    edge: white
    surfaces:
      - {radius: 40, thickness: 4, medium: core, aperture: 10}
      - {radius: -40, medium: air, aperture: 10}
objects:
  - {name: milk, geometry: ball, at: [0, 0, 40], surface: bare, inside: milk, outside: air}
  - name: core
    objects:
      - {name: lens, geometry: doublet, outside: air, at: [0, 0, 10]}
      - name: back rooms
        objects:
          - {name: 'odd name', geometry: plate, at: [0, 0, 70], surface: white, front: air, back: air}
          - {name: net, geometry: plate, at: [0, 0, 60], surface: gauze, front: air, back: air}
  - {name: ende, geometry: plate, at: [0, 0, -30], surface: white, front: air, back: air}
sources:
  - {name: lamp, type: point, at: [0, 0, -20], direction: [0, 0, 1], distribution: {cone: 30}, flux: 3 W, spectrum: {lines: {500: 1}}, medium: air}
  - {name: 'and', type: point, at: [5, 0, -20], direction: [0, 0, 1], distribution: {cone: 40}, flux: 1 W, rays_share: 2, spectrum: {lines: {600: 1}}, medium: air}
detectors:
  - {name: gate, type: plane, at: [0, 0, 25], size: [50, 50], cells: [5, 4], direction: [0, 0, -1]}
  - {name: eye, type: plane, on: 'odd name', size: [60, 60], cells: [6, 6], at: [0, 0, 70], direction: [0, 0, -1]}
  - {name: far, type: intensity, cells: [6, 12], axis: [0, 0, 1]}
"""
EXACT = 1e-12


def run(*arguments, status=0):
    done = subprocess.run([PROGRAM, *arguments], capture_output=True, text=True)
    assert done.returncode == status, (arguments, done.returncode, done.stderr)
    return done.stdout if status == 0 else done.stderr


def same(a, b):
    return (a is None and math.isnan(b)) or (a is not None and math.isclose(a, b, rel_tol=EXACT, abs_tol=1e-15))


class Evaluator:
    """Classes by brute force."""

    def __init__(self, path, objects):
        """objects: {prefix: label} of names that are one object of the scene file."""
        self.map = PlainMap(path)
        self.file = path
        m = self.map
        self.letter = {}
        self.label = {"surface": m.names["object"], "object": [], "group": []}
        for name, group in zip(m.names["object"], m.object_group):
            prefix = name.split(".")[0]
            self.label["object"].append(objects.get(prefix, name))
            top = -1
            while group >= 0:
                top, group = group, m.group_group[group]
            self.label["group"].append(name if top < 0 else m.names["group"][top])
        on = m.detector["on_object"], m.detector["on_group"]
        self.follows = [int(a >= 0 or b >= 0) for a, b in zip(*on)]
        self.first_hit = [0] * m.n_ray
        at = 0
        for i, n in enumerate(m.ray["registration_count"]):
            self.first_hit[i], at = at, at + int(n)
        self.unit = m.source_flux / m.source_emitted

    def letter_of(self, event):
        if event not in self.letter:
            self.letter[event] = next(c for c, word in LETTERS if event & BIT[word])
        return self.letter[event]

    def step(self, row, level, events):
        s = self.map.segment
        letter, place = self.letter_of(int(s["event"][row])), int(s["object"][row])
        if place >= 0:
            return (letter if events else ".") + "@" + self.label[level][place]
        if letter in "SA":
            name = self.map.names["medium"][s["medium"][row]]
            shared = name in self.map.names["object"] + self.map.names["group"]
            return letter + "@" + name + ("[medium]" if shared else "")
        return letter

    def paths(self, ray, level, events, collapse, detector):
        """The whole path, None; or the paths until each registration on the detector, with its row."""
        m, g = self.map, self.map.registration
        n, first, steps, at = int(m.ray["segment_count"][ray]), int(m.first_segment[ray]), [], 0

        def write(step):
            if not (collapse and steps and steps[-1] == step):
                steps.append(step)

        hits = range(self.first_hit[ray], self.first_hit[ray] + int(m.ray["registration_count"][ray]))
        for i in hits:
            if not g["registered"][i]:
                continue
            d = int(g["detector"][i])
            place = int(g["segment"][i]) + self.follows[d]
            ends = m.names["detector"][d] == detector
            if ends:
                before = list(steps)
                for leg in range(at, place):
                    opened = self.follows[d] and leg == place - 1
                    write(self.step(first + leg, level, events and not opened))
                write("V@" + detector)
                yield tuple(steps), i
                steps = before
            for leg in range(at, place):
                write(self.step(first + leg, level, events))
            at = max(at, place)
            write("V@" + m.names["detector"][d])
        for leg in range(at, n):
            write(self.step(first + leg, level, events))
        if not detector:
            yield tuple(steps), None

    def classes(self, level, events, collapse, detector, rays=None):
        found = defaultdict(list)
        for ray in rays if rays is not None else range(self.map.n_ray):
            for path, hit in self.paths(ray, level, events, collapse, detector):
                found[self.map.names["source"][self.map.ray["source"][ray]], path].append((ray, hit))
        return found

    def error(self, source, contributions):
        """Of one source's rays that contribute so much each."""
        n = self.map.source_emitted[source]
        total, squares = sum(contributions), sum(q * q for q in contributions)
        return self.unit[source] * math.sqrt(max(n / (n - 1) * (squares - total * total / n), 0))

    def cells(self, members):
        """{(detector, i, j): {ray: contribution}}"""
        m, g, found = self.map, self.map.registration, defaultdict(lambda: defaultdict(float))
        for ray, hit in members:
            every = range(self.first_hit[ray], self.first_hit[ray] + int(m.ray["registration_count"][ray]))
            for i in every if hit is None else [hit]:
                d = int(g["detector"][i])
                if g["registered"][i]:
                    found[d, int(g["cell"][i][0]), int(g["cell"][i][1])][ray] += m.ray["weight"][ray]
        return found


def steps_of(sequence):
    steps = []
    for step, times in re.findall(r"((?:\[\^SV\]|.)(?:@(?:'[^']*'|[\w.]+)(?:\[medium\])?)?)(?:\{(\d+)\})? ?", sequence):
        steps += [step.replace("[^SV]", ".").replace("'", "")] * int(times or 1)
    return tuple(steps)


def check_peak(evaluator, row, source, members):
    cells = evaluator.cells(members)
    assert row["registrations"] == round(sum(sum(c.values()) for c in cells.values())), row
    if not cells:
        assert row["peak"] is None
        return
    per_detector = defaultdict(float)
    for (d, _, _), contribution in cells.items():
        per_detector[d] += sum(contribution.values())
    d = max(per_detector, key=lambda k: (per_detector[k], -k))
    assert evaluator.map.names["detector"][d] == row["peak"]["detector"], row
    extent = {}
    nx, ny = (int(n) for n in evaluator.map.detector["cells"][d])
    for (k, i, j) in cells:
        if k == d and row["peak"]["unit"] in ("W/m2", "lx"):
            sx, sy = evaluator.map.detector["size"][d]
            extent[i, j] = sx / nx * sy / ny * evaluator.map.length_unit ** 2
        elif k == d:
            extent[i, j] = (math.cos(math.pi * i / nx) - math.cos(math.pi * (i + 1) / nx)) * 2 * math.pi / ny
    value = {c: evaluator.unit[source] * sum(cells[(d, *c)].values()) / extent[c] for c in extent}
    best = max(value.values())
    assert math.isclose(best, row["peak"]["value"], rel_tol=1e-9), (best, row)
    errors = [evaluator.error(source, cells[(d, *c)].values()) / extent[c] for c in value
              if math.isclose(value[c], best, rel_tol=1e-9)]
    assert any(math.isclose(e, row["peak"]["standard_error"], rel_tol=1e-9) for e in errors), row


def check_view(evaluator, level, events, collapse, detector, n_asked=12):
    options = ["--by", level, "--top", "all"]
    options += [] if events else ["--no-events"]
    options += ["--collapse"] if collapse else []
    options += ["--detector", detector] if detector else []
    document = json.loads(run("paths", evaluator.file, *options, "--json"))
    want = evaluator.classes(level, events, collapse, detector)
    rows = document["classes"]
    got = {(row["source"], steps_of(row["sequence"])): row for row in rows}
    assert len(got) == len(rows) and document["exact"] and document["bound"] is None
    assert set(got) == set(want), (options, set(got) ^ set(want))
    flux = sum(evaluator.unit[evaluator.map.names["source"].index(s)] * len(r) for (s, _), r in want.items())
    assert math.isclose(flux, document["flux"]["value"], rel_tol=1e-9)
    for key, members in want.items():
        rays = [ray for ray, _ in members]
        row, source = got[key], evaluator.map.names["source"].index(key[0])
        assert row["rays"] == len(set(rays)) and row["first_ray"] == min(evaluator.map.ray["id"][rays]), row
        assert row["segments"] == sum(int(evaluator.map.ray["segment_count"][r]) for r in set(rays))
        assert same(row["flux"], evaluator.unit[source] * len(rays))
        assert same(row["share"], row["flux"] / document["flux"]["value"])
        assert math.isclose(row["standard_error"], evaluator.error(source, Counter(rays).values()), rel_tol=1e-9)
    for row in rows[:30]:
        key = row["source"], steps_of(row["sequence"])
        check_peak(evaluator, row, evaluator.map.names["source"].index(key[0]), want[key])
    order = [(-row["flux"], row["first_ray"]) for row in rows]
    assert order == sorted(order) and [row["rank"] for row in rows] == list(range(1, len(rows) + 1))
    some = rows[:n_asked] + rows[n_asked::max(1, len(rows) // n_asked)]
    for row in some:
        assert "*" not in row["criterion"].replace("hit('*', limit)", "").replace(".*", "").replace("V*", "")
    answers = json.loads(run("query", evaluator.file, *[row["criterion"] for row in some], "--json"))
    for row, answer in zip(some, answers if len(some) > 1 else [answers]):
        assert answer["rays"]["matched"] == row["rays"], row
        assert answer["segments"]["matched"] == row["segments"], row
        assert answer["flux"]["matched"] == row["flux"], (row, answer)
        assert same(answer["flux"]["standard_error"], row["standard_error"]), (row, answer)
    return len(rows)


def check_all_views(evaluator, detectors):
    n = {}
    turn = 0
    for level in ("surface", "object", "group"):
        for events in (True, False):
            for collapse in (False, True):
                turn += 1
                for detector in (None, detectors[turn % len(detectors)]):
                    n[level, events, collapse, detector] = check_view(evaluator, level, events, collapse, detector)
    assert n["surface", True, False, None] > n["object", True, True, None] > n["group", False, True, None]


def check_narrowed(evaluator):
    """--where, --top, --sort, the remainder, CSV, an empty selection."""
    where = "hit(*, reflect_specular) or @seen"
    with open("names.txt", "w") as file:
        file.write("let seen = registered(gate)\n")
    options = ["--criteria", "names.txt", "--where", where]
    whole = json.loads(run("paths", evaluator.file, *options, "--top", "all", "--json"))
    some = json.loads(run("paths", evaluator.file, *options, "--top", "7", "--json", "-o", "x.csv", "--force"))
    assert some["classes"] == whole["classes"][:7]
    rest, left = some["remainder"], whole["classes"][7:]
    assert rest["classes"] == len(left) and rest["rays"] == sum(row["rays"] for row in left)
    assert math.isclose(rest["flux"], sum(row["flux"] for row in left), rel_tol=1e-9)
    assert whole["remainder"]["rays"] == 0 and whole["remainder"]["flux"] == 0
    for row in some["classes"]:
        answer, = json.loads(run("query", evaluator.file, "--criteria", "names.txt", row["criterion"], "--json"))
        assert answer["rays"]["matched"] == row["rays"] and answer["flux"]["matched"] == row["flux"]
    with open("x.csv") as file:
        lines = [line for line in file if not line.startswith("#")]
    table = list(csv.DictReader(lines))
    assert [row["criterion"] for row in table] == [row["criterion"] for row in some["classes"]]
    assert [float(row["flux"]) for row in table] == [row["flux"] for row in some["classes"]]
    for sort, key in (("rays", lambda r: r["rays"]), ("length", lambda r: r["segments"] / r["rays"])):
        rows = json.loads(run("paths", evaluator.file, "--sort", sort, "--json"))["classes"]
        assert [key(row) for row in rows] == sorted((key(row) for row in rows), reverse=True)
        assert len(rows) == 20
    none = json.loads(run("paths", evaluator.file, "--where", "segments > 1000", "--json"))
    assert none["classes"] == [] and none["flux"]["value"] == 0 and none["rays"]["matched"] == 0
    assert "no ray" in run("paths", evaluator.file, "--where", "segments > 1000")
    text = run("paths", evaluator.file, "--top", "3")
    for row in whole["classes"][:0] + json.loads(run("paths", evaluator.file, "--top", "3", "--json"))["classes"]:
        assert row["criterion"] in text
    assert "did you mean 'gate'" in run("paths", evaluator.file, "--detector", "gat", status=3)
    assert "did you mean 'group'" in run("paths", evaluator.file, "--by", "groupe", status=2)
    assert "surface, object or group" in run("paths", evaluator.file, "--by", "colour", status=2)
    assert "flux, rays, length or share" in run("paths", evaluator.file, "--sort", "size", status=2)
    run("paths", evaluator.file, "--exact", "3", status=2)
    run("paths", evaluator.file, "-o", "x.png", status=2)


def check_sketch(evaluator):
    """More classes than --exact allows: all of the bound's share and more, each exact."""
    whole = json.loads(run("paths", evaluator.file, "--top", "all", "--json"))
    every = {(row["source"], row["sequence"]): row for row in whole["classes"]}
    for most in (16, 100, 300):
        some = json.loads(run("paths", evaluator.file, "--top", "all", "--exact", str(most), "--json"))
        assert len(every) > most >= len(some["classes"]) > 0 and not some["exact"]
        bound = some["bound"]
        assert math.log(bound * most / 2, 4) % 1 < 1e-9 and some["remainder"]["classes"] is None
        found = {(row["source"], row["sequence"]) for row in some["classes"]}
        assert all(key in found for key, row in every.items() if row["share"] >= bound)
        for row in some["classes"]:
            full = dict(every[row["source"], row["sequence"]], rank=row["rank"])
            assert row == full, (row, full)
        assert some["flux"] == whole["flux"]
        rays = sum(row["rays"] for row in some["classes"])
        assert some["remainder"]["rays"] == whole["rays"]["matched"] - rays
    run("paths", evaluator.file, "--exact", "16", "--quiet")


def some_of(rows, most):
    return rows[::max(1, len(rows) // most)]


def check_selected(file, rows, where=()):
    """Each row's criterion counts its rays."""
    answers = json.loads(run("query", file, *where, *[row["criterion"] for row in rows], "--json"))
    for row, answer in zip(rows, answers if len(rows) > 1 else [answers]):
        assert answer["rays"]["matched"] == row["rays"], (row, answer)


def check_matrix_files(evaluator, document, options):
    """-o OUT.csv --matrix KIND is that matrix, as JSON has it."""
    for kind in ("orders", "ghosts", "contribution"):
        run("paths", evaluator.file, *options, "--matrix", kind, "-o", "m.csv", "--force", "--quiet")
        with open("m.csv") as file:
            table = list(csv.DictReader(line for line in file if not line.startswith("#")))
        assert len(table) == len(document[kind]) > 0
        for i, (line, row) in enumerate(zip(table, document[kind])):
            assert line.pop("row") == str(i + 1) and list(line) == list(row), (line, row)
            for name, value in row.items():
                if isinstance(value, float):
                    assert float(line[name]) == value
                else:
                    assert line[name] == str("" if value is None else value), (line, row)
    assert "one matrix" in run("paths", evaluator.file, "--matrix", "all", "-o", "m.csv", "--force", status=2)
    text = run("paths", evaluator.file, *options, "--matrix", "all", "--top", "3")
    for row in document["orders"] + document["ghosts"][:1]:
        assert row["criterion"] in text, row
    for kind in ("ghosts", "contribution"):
        text = run("paths", evaluator.file, *options, "--matrix", kind, "--top", "1")
        told = sum(int(line.split()[1].rstrip(":")) for line in text.splitlines() if line.startswith("and "))
        shown = sum(line.startswith("1  ") and " +- " in line for line in text.splitlines())
        assert told + shown == len(document[kind]), (kind, text)
    assert "orders, ghosts, contribution or all" in run("paths", evaluator.file, "--matrix", "order", status=2)


def check_grouped_matrices(evaluator, options):
    """Criteria of a matrix by larger parts, of rays that a criterion picked already."""
    for level in ("object", "group"):
        document = json.loads(run("paths", evaluator.file, *options, "--by", level, "--matrix", "all", "--where",
                                  "segments > 3 or not hit(*)", "--json"))
        assert document["ghosts"] and document["contribution"]
        for kind in ("orders", "ghosts", "contribution"):
            check_selected(evaluator.file, some_of(document[kind], 8))


def check_mean_orders(evaluator, rows, detector):
    """Statistics of orders on a detector are those of the matrix."""
    flux = sum(row["flux"] for row in rows)
    assert flux > 0 and max(row["ghost_order"] for row in rows) < 9
    for of in ("ghost_order", "scatter_order"):
        told = json.loads(run("stats", evaluator.file, "--of", f"{of}({detector})", "--json"))
        want = sum(row["flux"] * row[of] for row in rows) / flux
        assert math.isclose(told["mean"]["value"], want, rel_tol=1e-9), (of, told["mean"], want)


def check_matrices(evaluator, transmits, detector=None):
    """Orders, ghosts and contributions, from the steps before each registration."""
    options = ["--detector", detector] if detector else []
    document = json.loads(run("paths", evaluator.file, "--matrix", "orders,ghosts,contribution", "--json", *options))
    m, s, g = evaluator.map, evaluator.map.segment, evaluator.map.registration
    want = {key: defaultdict(lambda: defaultdict(float)) for key in ("orders", "ghosts", "last", "any", "all", "stray")}
    for i, ray in enumerate(m.ray_of_registration):
        name = m.names["detector"][g["detector"][i]]
        if not g["registered"][i] or (detector and name != detector):
            continue
        first = int(m.first_segment[ray])
        rows = range(first, first + int(g["segment"][i]))
        by = [int(s["object"][k]) for k in rows if s["event"][k] & BIT["reflect_specular"] and
              s["object"][k] >= 0 and m.names["object"][s["object"][k]] in transmits]
        scatter = sum(1 for k in rows if s["event"][k] & (BIT["reflect_diffuse"] | BIT["transmit_diffuse"] |
                                                          BIT["scatter_volume"]))
        met = [m.names["object"][s["object"][k]] for k in rows if s["object"][k] >= 0]
        source, w = m.names["source"][m.ray["source"][ray]], m.ray["weight"][ray]
        want["orders"][name, min(len(by), 9), min(scatter, 9)][ray] += w
        want["all"][name][ray] += w
        if by or scatter:
            want["stray"][name][ray] += w
        if len(by) == 2 and not scatter:
            want["ghosts"][name, *(m.names["object"][k] for k in by)][ray] += w
        want["last"][name, source, met[-1] if met else None][ray] += w
        for what in set(met):
            want["any"][name, source, what][ray] += w

    def estimate(contributions):
        flux, variance = 0.0, 0.0
        for k, source in enumerate(m.names["source"]):
            own = [q for ray, q in contributions.items() if m.ray["source"][ray] == k]
            flux += evaluator.unit[k] * sum(own)
            variance += evaluator.error(k, own) ** 2
        return flux, math.sqrt(variance)

    def check(rows, key_of, expected, whole):
        assert {key_of(row) for row in rows} == set(expected) and len(rows) == len(expected)
        for row in rows:
            flux, error = estimate(expected[key_of(row)])
            assert row["rays"] == len(expected[key_of(row)]), row
            assert math.isclose(row["flux"], flux, rel_tol=1e-9), (row, flux)
            assert math.isclose(row["standard_error"], error, rel_tol=1e-9), (row, error)
            assert math.isclose(row["share"], flux / estimate(want[whole][row["detector"]])[0], rel_tol=1e-9), row

    check(document["orders"], lambda r: (r["detector"], r["ghost_order"], r["scatter_order"]), want["orders"], "all")
    check(document["ghosts"], lambda r: (r["detector"], r["first"], r["second"]), want["ghosts"], "stray")
    for met in ("last", "any"):
        rows = [r for r in document["contribution"] if r["met"] == met]
        check(rows, lambda r: (r["detector"], r["source"], r["object"]), want[met], "all")
    for kind in ("orders", "ghosts", "contribution"):
        check_selected(evaluator.file, some_of(document[kind], 40))
    check_matrix_files(evaluator, document, options)
    check_grouped_matrices(evaluator, options)
    if detector:
        check_mean_orders(evaluator, document["orders"], detector)
    assert detector or (len(document["ghosts"]) >= 3 and len(document["orders"]) >= 4)


RECEIVERS = """
detectors:
  - {name: added, type: plane, at: [0, 0, 25], size: [30, 20], cells: [3, 4], direction: [0, 0, -1]}
  - {name: on_net, type: plane, on: net, size: [60, 60], cells: [6, 6], at: [0, 0, 60], direction: [0, 0, -1]}
"""


def check_receivers():
    """What receivers laid over a map saw is what a run with them as detectors saw."""
    with open("receivers.yaml", "w") as file:
        file.write(RECEIVERS)
    with open("more.yaml", "w") as file:
        file.write(SCENE + RECEIVERS.split("detectors:")[1])
    run("trace", "more.yaml", "-o", "more.raymap", "-n", "6000", "--encoding", "plain", "--quiet")
    over = ["--receivers", "receivers.yaml"]
    for detector in ("added", "on_net", "gate"):
        options = ["--detector", detector, "--matrix", "all", "--top", "all", "--json"]
        real = json.loads(run("paths", "more.raymap", *options))
        laid = json.loads(run("paths", "odd.raymap", *over, *options))
        for kind in ("orders", "ghosts", "contribution"):
            assert len(real[kind]) == len(laid[kind]) and real[kind]
            for a, b in zip(real[kind], laid[kind]):
                assert {k: v for k, v in a.items() if k != "share"} == {k: v for k, v in b.items() if k != "share"}, (a, b)
            check_selected("odd.raymap", some_of(laid[kind], 3), over)
        drop = ("share", "peak")
        assert [{k: v for k, v in row.items() if k not in drop} for row in real["classes"]] == \
            [{k: v for k, v in row.items() if k not in drop} for row in laid["classes"]]


for name in ("odd.raymap", "gauss.raymap", "more.raymap"):
    shutil.rmtree(name, ignore_errors=True)
with open("odd.yaml", "w") as file:
    file.write(SCENE)
run("trace", "odd.yaml", "-o", "odd.raymap", "-n", "6000", "--encoding", "plain", "--quiet")
run("trace", DOUBLE_GAUSS, "-o", "gauss.raymap", "-n", "6000", "--encoding", "plain", "--quiet")
odd = Evaluator("odd.raymap", {"lens": "lens"})
check_all_views(odd, ("gate", "eye", "far"))
check_narrowed(odd)
check_sketch(odd)
check_matrices(odd, ("milk", "lens.1", "lens.2", "net"))
check_receivers()
gauss = Evaluator("gauss.raymap", {"lens": "lens", "cover": "cover"})
for given in (("surface", True, False, None), ("object", True, True, "sensor"), ("group", False, False, None)):
    check_view(gauss, *given)
check_matrices(gauss, [name for name in gauss.map.names["object"] if re.fullmatch(r"(lens|cover)\.\d+|sensor_surface", name)],
               "sensor")
print("all as expected")
