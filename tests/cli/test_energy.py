#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: `report MAP --energy` shares out every ray that was emitted, exactly, and says where
it ended, with flux, shares and standard errors as a sum over the map's columns gives them."""
import csv
import json
import math
import os
import shutil
import subprocess
import sys

import numpy

PROGRAM = os.environ["RAYMAP"]
SOURCE = os.environ["SOURCE_DIR"]
sys.path.insert(0, os.path.join(SOURCE, "examples", "python"))
import raymap_reader  # noqa: E402

# Two absorbing media, a limit that some rays reach, a plane that rays cross several times.
TURBID = """\
raymap: 1
units: mm
spectrum: {mode: spectral, wavelengths: [486.13, 587.56, 656.27]}
media:
  air: {index: 1}
  grey: {index: 1.5, absorption: 0.02}
  fog: {index: 1.33, absorption: 0.01, scattering: 0.1}
surfaces:
  polished: {type: fresnel}
  white: {type: lambert, reflectance: 0.5}
geometries:
  globe: {type: sphere, radius: 10}
  wall: {type: rectangle, size: [60, 60]}
objects:
  - {name: 'ball, grey', geometry: globe, at: [0, 0, 20], surface: polished, inside: grey, outside: air}
  - {name: cloud, geometry: globe, at: [0, 0, 60], surface: polished, inside: fog, outside: air}
  - {name: screen, geometry: wall, at: [0, 0, 100], surface: white, front: air, back: air}
sources:
  - {name: lamp, type: point, at: [0, 0, 0], direction: [0, 0, 1], distribution: {cone: 30}, flux: 2 W, medium: air}
  - {name: sun, type: collimated, at: [0, 0, -5], direction: [0, 0, 1], shape: {disc: 8}, flux: 10 W, rays_share: 3, medium: air}
detectors:
  - {name: eye, type: plane, on: screen, size: [60, 60], cells: [10, 10], at: [0, 0, 100], direction: [0, 0, -1]}
  - {name: middle, type: plane, at: [0, 0, 40], size: [50, 50], cells: [20, 20], side: both}
  - {name: far, type: intensity, cells: [18, 36]}
limits: {steps: 20}
"""


def run(*arguments, status=0):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                          timeout=300, check=False)
    assert done.returncode == status, (arguments, done.returncode, done.stdout, done.stderr)
    return done.stdout if status == 0 else done.stderr


def trace(scene, path, n, *more):
    shutil.rmtree(path, ignore_errors=True)
    run("trace", scene, "-o", path, "-n", n, "--quiet", *more)


class Columns:
    """Of every ray: source, where it ended, whether it matches, registrations per detector."""

    def __init__(self, path, criterion=None):
        self.map = raymap_reader.Map(path)
        info = json.loads(run("info", path, "--json"))
        self.flux = {s["name"]: s["flux"] for s in info["sources"]}
        self.emitted = {s["name"]: s["emitted"] for s in info["sources"]}
        matching = None
        if criterion:
            rays = json.loads(run("query", path, criterion, "--limit", 10**9, "--json"))
            matching = {ray["ray"] for ray in rays}
        names = self.map.names
        self.rays = []  # source, (what, name), {detector: registrations}
        for portion in self.map.portions():
            for ray in portion.rays():
                if matching is not None and int(ray["id"]) not in matching:
                    continue
                assert ray["weight"] == 1.0
                self.rays.append((names["source"][ray["source"]], self.end(ray),
                                  self.registered(ray)))

    def end(self, ray):
        stop = raymap_reader.STOPS[ray["stop"]]
        if stop != "absorbed":
            return stop, ""
        last = ray.segments["object"][-1]
        if last >= 0:
            return "object", self.map.names["object"][last]
        return "medium", self.map.names["medium"][ray.segments["medium"][-1]]

    def registered(self, ray):
        count = {}
        rows = ray.registrations
        for detector, registered in zip(rows["detector"], rows["registered"]):
            if registered:
                name = self.map.names["detector"][detector]
                count[name] = count.get(name, 0) + 1
        return count

    def estimate(self, contribution, sources):
        """Sum, flux, its standard error; the share of the rays' flux and its error."""
        rays = flux = variance = total = 0.0
        parts = []
        for source in sources:
            n, unit = self.emitted[source], self.flux[source] / self.emitted[source]
            q = numpy.array([contribution(ray) for ray in self.rays if ray[0] == source], float)
            parts.append((n, unit, q))
            rays += q.sum()
            flux += unit * q.sum()
            total += unit * len(q)
            variance += self.variance(n, unit, q)
        if total == 0:
            return rays, flux, math.sqrt(variance), None, None
        share = flux / total
        of_share = sum(self.variance(n, unit, q - share) for n, unit, q in parts)
        return rays, flux, math.sqrt(variance), share, math.sqrt(of_share) / total

    @staticmethod
    def variance(n, unit, q):
        return unit**2 * n / (n - 1) * (numpy.sum(q * q) - numpy.sum(q) ** 2 / n)


def near(told, wanted, scale):
    if wanted is None or told is None:
        assert told is wanted, (told, wanted)
    else:
        assert abs(told - wanted) <= 1e-9 * abs(wanted) + 1e-11 * scale, (told, wanted)


def compare_row(row, wanted, counted="rays"):
    rays, flux, error, share, share_error = wanted
    assert row[counted] == rays, (row, wanted)
    near(row["flux"], flux, 1)
    near(row["standard_error"], error, flux + 1e3)  # a difference of large sums, where all match
    near(row["share"], share, 1)
    near(row["share_standard_error"], share_error, 1e3)


def rows_of(table):
    for kind, word in (("objects", "object"), ("media", "medium")):
        for row in table["absorbed"][kind]:
            yield (word, row["name"]), row
    for word in ("left", "limit", "error"):
        yield (word, ""), table[word]


def compare_table(table, columns, sources):
    ends = {ray[1] for ray in columns.rays if ray[0] in sources}
    told = dict(rows_of(table))
    assert ends <= set(told), ends - set(told)
    for end, row in told.items():
        compare_row(row, columns.estimate(lambda ray: ray[1] == end, sources))
        assert row["rays"] > 0 or end[0] in ("left", "limit", "error")
    emitted = sum(1 for ray in columns.rays if ray[0] in sources)
    assert table["emitted"] == emitted == sum(row["rays"] for row in told.values())
    assert table["exact"] is True
    for kind in ("objects", "media"):
        flux = [row["flux"] for row in table["absorbed"][kind]]
        assert flux == sorted(flux, reverse=True)
    assert [row["name"] for row in table["detectors"]] == columns.map.names["detector"]
    for row in table["detectors"]:
        wanted = columns.estimate(lambda ray: ray[2].get(row["name"], 0), sources)
        compare_row(row, wanted, "registrations")


def compare(path, criterion=None):
    columns = Columns(path, criterion)
    where = ["--where", criterion] if criterion else []
    told = json.loads(run("report", path, "--energy", "--json", *where))
    assert list(told) == ["version", "map", "criterion", "which", "rays", "flux", "total", "sources", "complete", "rays_asked", "rays_traced"]
    assert told["map"] == path and told["criterion"] == (criterion or "all")
    assert told["rays"] == {"total": columns.map.n_rays, "matched": len(columns.rays)}
    assert told["total"]["source"] is None
    compare_table(told["total"], columns, list(columns.flux))
    assert [table["source"] for table in told["sources"]] == list(columns.flux)
    for table in told["sources"]:
        compare_table(table, columns, [table["source"]])
    return told


def compare_csv(path, told):
    """The same numbers in every form."""
    run("report", path, "--energy", "-o", "energy.csv", "--force")
    run("report", path, "--energy", "-o", "energy.json", "--force")
    with open("energy.json", encoding="utf-8") as file:
        assert json.load(file) == told
    with open("energy.csv", encoding="utf-8") as file:
        lines = file.readlines()
    assert "# exact: true\n" in lines
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    wanted = []
    for table in [told["total"], *told["sources"]]:
        source = table["source"] or ""
        wanted.append((source, "emitted", "", table["emitted"]))
        wanted += [(source, *end, row["rays"]) for end, row in rows_of(table)]
        wanted += [(source, "detector", row["name"], row["registrations"])
                   for row in table["detectors"]]
    assert [(r["source"], r["what"], r["name"], int(r["rays"])) for r in rows] == wanted


with open("turbid.yaml", "w", encoding="utf-8") as file:
    file.write(TURBID)
trace("turbid.yaml", "turbid.raymap", 6001)
whole = compare("turbid.raymap")
absorbed = whole["total"]["absorbed"]
assert {row["name"] for row in absorbed["media"]} == {"grey", "fog"}
assert whole["total"]["limit"]["rays"] > 0 and whole["total"]["left"]["rays"] > 0
crossed = {row["name"]: row for row in whole["total"]["detectors"]}
assert crossed["far"]["registrations"] == whole["total"]["left"]["rays"]
compare_csv("turbid.raymap", whole)
compare("turbid.raymap", "registered(middle) >= 2")
none = compare("turbid.raymap", "hit(*) > 100000")
assert none["total"]["emitted"] == 0 and none["total"]["left"]["share"] is None
assert "no ray matches" in run("report", "turbid.raymap", "--energy", "--where", "hit(*) > 100000")
assert "exactly" in run("report", "turbid.raymap", "--energy")

trace(os.path.join(SOURCE, "examples", "double-gauss", "scene.yaml"), "lens.raymap", 8000,
      "--encoding", "plain")
compare("lens.raymap")
compare("lens.raymap", "hit(lens.*, reflect) >= 2")

# A map of a query keeps the fluxes of the map that was traced.
shutil.rmtree("part.raymap", ignore_errors=True)
run("query", "lens.raymap", "registered(sensor)", "-o", "part.raymap", "--quiet")
part = json.loads(run("report", "part.raymap", "--energy", "--json"))
same = json.loads(run("report", "lens.raymap", "--energy", "--json", "--where",
                      "registered(sensor)"))
assert part["sources"] == same["sources"] and part["total"] == same["total"]

# Pictures stand; all of what is wrong is said before anything is written.
for name in ("energy.svg", "energy.png"):
    run("report", "turbid.raymap", "--energy", "-o", name, "--force")
    run("report", "turbid.raymap", "--energy", "-o", name, "--force", "--where", "hit(*) > 100000")
with open("energy.svg", encoding="utf-8") as file:
    picture = file.read()
assert "no ray matches" in picture
for arguments, status, words in (
        (["turbid.raymap", "--energy", "-o", "energy.svg"], 2, "--force"),
        (["turbid.raymap", "--energy", "-o", "energy.pdf"], 2, ".png"),
        (["turbid.raymap", "3", "--energy"], 2, "without a ray"),
        (["turbid.yaml", "--ray", "3", "--energy"], 2, "without a ray"),
        (["turbid.raymap", "3", "--where", "all"], 2, "--energy"),
        (["turbid.raymap", "--energy", "--where", "hit(blal)"], 3, "blal"),
        (["none.raymap", "--energy"], 3, "none.raymap"),
        (["turbid.yaml", "--energy"], 4, "")):
    assert words in run("report", *arguments, status=status), (arguments, words)
print("energy balances agree with the columns")
