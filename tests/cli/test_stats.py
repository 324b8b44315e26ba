#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The promise: `raymap stats` says of any number what numpy says from the columns: flux, moments,
quantiles and histograms of one and two numbers, weighted by flux, of several sources and of rays
that are registered several times; their errors are those of the clustered sums, and those that
twenty seeds show. More values than memory change nothing but the quantiles' last digits. Nothing to
count is no mistake; absurd or misspelt requests are refused with the reason."""
import csv
import json
import os
import re
import subprocess
import sys

import h5py
import numpy as np

sys.dont_write_bytecode = True

from asking import keys_of  # knows where the package is
import raymap.serve
from spot_scene import SPOT

PROGRAM = os.environ["RAYMAP"]
RAYS = 6000
failures = 0

# Light goes to and fro between two white walls, through a glass plate: rays are registered several
# times, sources differ in flux and rays, and some rays keep all wavelengths to their end.
SCENE = """raymap: 1
units: mm
spectrum: {mode: spectral, wavelengths: [450, 550, 650]}
media: {air: {index: 1}, glass: {glass: N-BK7}}
surfaces:
  white: {type: lambert, reflectance: 0.8}
  polished: {type: fresnel}
geometries:
  wall: {type: rectangle, size: [40, 40]}
  plate: {type: rectangle, size: [10, 10]}
objects:
  - {name: low, geometry: wall, at: [0, 0, 0], surface: white, front: air, back: air}
  - {name: high, geometry: wall, at: [0, 0, 20], surface: white, front: air, back: air}
  - {name: entry, geometry: plate, at: [3, 0, 5], surface: polished, front: glass, back: air}
  - {name: exit, geometry: plate, at: [3, 0, 6], surface: polished, front: air, back: glass}
sources:
  - {name: lamp, type: point, at: [0, 0, 10], direction: [0, 0, 1], distribution: isotropic,
     flux: 1 W, medium: air}
  - {name: side, type: point, at: [2, 1, 15], direction: [0, 0, -1], distribution: {cone: 60},
     flux: 3 W, rays_share: 2, medium: air}
detectors:
  - {name: sensor, type: plane, on: low, size: [40, 40], cells: [20, 20], at: [0, 0, 0],
     direction: [0, 0, 1]}
  - {name: top, type: plane, on: high, size: [40, 40], cells: [20, 20], at: [0, 0, 20],
     direction: [0, 0, -1]}
"""


def check(good, what):
    global failures
    if not good:
        failures += 1
        print("FAIL " + what, flush=True)


def near(a, b, what, relative=1e-9):
    if a is None or b is None or not abs(a - b) <= relative * max(abs(a), abs(b)) + 1e-300:
        check(False, f"{what}: {a} instead of {b}")


def run(*arguments, status=0):
    done = subprocess.run([PROGRAM, *map(str, arguments)], capture_output=True, text=True,
                          check=False)
    if done.returncode != status:
        check(False, f"{arguments}: status {done.returncode}, not {status}: {done.stderr}")
    return done


def stats(path, *arguments):
    """Of what names no file one server of the map is asked, whose answers are those of the command line."""
    if path == "a.raymap" and not {"-o", "--receivers", "--criteria", "--memory"} & set(arguments):
        return SERVER.stats(**keys_of(arguments))
    return json.loads(run("stats", path, "--json", *arguments).stdout)


def refused(status, *arguments):
    """Why the server does not answer it."""
    try:
        SERVER.stats(**keys_of(arguments))
    except raymap.serve.ServerError as error:
        check(error.status == status, f"{arguments}: status {error.status}, not {status}: {error}")
        return str(error)
    check(False, f"{arguments} was answered")
    return ""




class Map:
    """The columns of a map, and what its sources emitted."""

    def __init__(self, path):
        info = json.loads(run("info", path, "--json").stdout)
        with h5py.File(path + "/map.h5") as file:
            self.ray = {k: v[...] for k, v in file["ray"].items()}
            self.segment = {k: v[...] for k, v in file["segment"].items()}
            self.registration = {k: v[...] for k, v in file["registration"].items()}
            self.wavelength = np.array([450.0, 550.0, 650.0])
        n = len(self.ray["id"])
        self.emitted = np.array([s["emitted"] for s in info["sources"]], dtype=float)
        self.flux = np.array([s["flux"] for s in info["sources"]]) / self.emitted
        self.of_segment = np.repeat(np.arange(n), self.ray["segment_count"])
        self.of_registration = np.repeat(np.arange(n), self.ray["registration_count"])

    def registered(self, detector):
        return ((self.registration["detector"] == detector) &
                (self.registration["registered"] != 0))


def error(columns, source, per_weight, emitted):
    """Covariances of the totals of per-ray columns [ray][column]."""
    total = np.zeros((columns.shape[1],) * 2)
    for s, (f, n) in enumerate(zip(per_weight, emitted)):
        q = columns[source == s]
        if len(q):
            total += f * f * n / (n - 1) * (q.T @ q - np.outer(q.sum(0), q.sum(0)) / n)
    return total


def per_ray(m, ray, weight):
    """Sums over each ray of the rows of weight [reading][column]."""
    n = len(m.ray["id"])
    return np.stack([np.bincount(ray, column, n) for column in weight.T], 1)


def expected(m, ray, value, share, edges, ps):
    """Everything about readings: `share` of the ray's weight, each."""
    source = m.ray["source"]
    w = m.ray["weight"][ray] * share
    centre = np.average(value)
    u = value - centre
    q = per_ray(m, ray, np.stack([w * u**k for k in range(5)], 1))
    total = sum(m.flux[s] * q[source == s].sum(0) for s in range(len(m.flux)))
    covariance = error(q, source, m.flux, m.emitted)
    f = total[0]
    m1, m2, m3, m4 = total[1:] / f
    var = m2 - m1**2
    mu3, mu4 = m3 - 3 * m1 * m2 + 2 * m1**3, m4 - 4 * m1 * m3 + 6 * m1**2 * m2 - 3 * m1**4
    sd = var**0.5

    def by_delta(slope):  # of a function of m1 .. m4, by finite differences below
        g = np.array(slope) / f
        g = np.concatenate([[-(np.array(slope) * total[1:] / f).sum() / f], g])
        return float(max(g @ covariance @ g, 0) ** 0.5)

    def slopes(function):
        base, out = np.array([m1, m2, m3, m4]), []
        for k in range(4):
            h = 1e-6 * sd ** (k + 1)
            up, down = base.copy(), base.copy()
            up[k] += h
            down[k] -= h
            out.append((function(*up) - function(*down)) / (2 * h))
        return out

    def deviation(a, b, c, d):
        return (b - a * a) ** 0.5

    def skewness(a, b, c, d):
        return (c - 3 * a * b + 2 * a**3) / (b - a * a) ** 1.5

    def kurtosis(a, b, c, d):
        return (d - 4 * a * c + 6 * a * a * b - 3 * a**4) / (b - a * a) ** 2

    result = {"flux": (f, covariance[0, 0] ** 0.5), "mean": (m1 + centre, by_delta([1, 0, 0, 0])),
              "standard_deviation": (sd, by_delta(slopes(deviation))),
              "skewness": (mu3 / sd**3, by_delta(slopes(skewness))),
              "kurtosis": (mu4 / var**2, by_delta(slopes(kurtosis)))}
    # quantiles: flux at or below a value, source by source
    order = np.argsort(value, kind="stable")
    flux = m.flux[source[ray]] * w
    sums = np.cumsum(flux[order])

    def at(p):
        return float(value[order][np.searchsorted(sums, (p - 1e-12) * sums[-1])])

    quantiles = []
    for p in ps:
        v = at(p)
        below = per_ray(m, ray, np.stack([w, w * (value <= v)], 1))
        r = flux[value <= v].sum() / f
        e = error(below[:, 1:] - r * below[:, :1], source, m.flux, m.emitted)[0, 0] ** 0.5 / f
        quantiles.append((v, (at(min(p + e, 1)) - at(max(p - e, 0))) / 2))
    result["quantiles"] = quantiles
    # histogram
    n = len(edges) - 1
    k = np.searchsorted(edges, value, side="right") - 1
    k[value == edges[-1]] = n - 1
    bins = []
    for b in range(n):
        q = per_ray(m, ray[k == b], w[k == b][:, None])
        bins.append((sum(m.flux[s] * q[source == s].sum() for s in range(len(m.flux))),
                     error(q, source, m.flux, m.emitted)[0, 0] ** 0.5,
                     len(np.unique(ray[k == b]))))
    result["bins"] = bins
    return result


def compare(got, m, ray, value, share, what, relative=1e-9):
    ps = [q["p"] for q in got["quantiles"]]
    want = expected(m, ray, value, share, np.array(got["histogram"]["edges"]), ps)
    check(got["values"] == len(value), f"{what}: {got['values']} values, not {len(value)}")
    for key in ("flux", "mean", "standard_deviation", "skewness", "kurtosis"):
        near(got[key]["value"], want[key][0], f"{what}: {key}", relative)
        e = got[key]["standard_error"]
        check(abs(e - want[key][1]) <= 1e-5 * want[key][1] + 1e-9 * abs(want[key][0]),
              f"{what}: error of {key}: {e} instead of {want[key][1]}")
    near(got["min"], float(value.min()), what + ": min", 0)
    near(got["max"], float(value.max()), what + ": max", 0)
    for q, (v, e) in zip(got["quantiles"], want["quantiles"]):
        near(q["value"], v, f"{what}: quantile {q['p']}", 1e-14)
        check(abs(q["standard_error"] - e) <= 1e-12 + 1e-9 * e,
              f"{what}: error of quantile {q['p']}: {q['standard_error']} instead of {e}")
    histogram = got["histogram"]
    for b, (f, e, rays) in enumerate(want["bins"]):
        if not np.isclose(histogram["flux"][b], f, rtol=1e-6, atol=1e-12):
            check(False, f"{what}: bin {b}: {histogram['flux'][b]} instead of {f}")
        if not np.isclose(histogram["standard_error"][b], e, rtol=1e-5, atol=1e-12):
            check(False, f"{what}: error of bin {b}: {histogram['standard_error'][b]}, not {e}")
        check(histogram["rays"][b] == rays, f"{what}: rays of bin {b}")


def check_numbers(m, path):
    """Numbers of rays and of registrations, with and without a criterion."""
    every = np.arange(len(m.ray["id"]))
    one = np.ones(len(every))
    for of in ("path_length", "optical_path"):
        compare(stats(path, "--of", of), m, every, m.ray[of], one, of)
    compare(stats(path, "--of", "segments", "--quantiles", "0,10,99.5,100"), m, every,
            m.ray["segment_count"].astype(float), one, "segments")
    hits = np.bincount(m.of_segment[m.segment["object"] == 0], minlength=len(every))
    few = stats(path, "--of", "path_length", "--where", "hit(low) >= 2", "--bins", "17")
    chosen = hits >= 2
    check(few["rays"] == {"total": len(every), "matched": int(chosen.sum())}, "matched rays")
    compare(few, m, every[chosen], m.ray["path_length"][chosen], one[chosen], "hit(low) >= 2")
    compare(stats(path, "--of", "hit(low)"), m, every, hits.astype(float), one, "hit(low)")
    compare(stats(path, "--of", "registrations(sensor)"), m, every,
            np.bincount(m.of_registration[m.registered(0)], minlength=len(every)).astype(float),
            one, "registrations(sensor)")
    on = m.registered(0)
    ray, share = m.of_registration[on], np.ones(on.sum())
    check(len(np.unique(ray)) < len(ray), "some rays are registered several times")
    x = (m.registration["relative"][on, 0] / 65535.0 - 0.5) * 40
    compare(stats(path, "--of", "x(sensor)", "--range", "-1..2 cm", "--bins", "13"), m, ray, x,
            share, "x(sensor)", 1e-8)
    compare(stats(path, "--of", "optical_path(sensor)", "--bins", "0,3 cm,50,90,4 m"), m, ray,
            m.registration["optical_path"][on], share, "optical_path(sensor)")
    edges = stats(path, "--of", "optical_path(sensor)", "--bins", "0,2,5.5, 9 cm")
    check(np.allclose(edges["histogram"]["edges"], [0, 20, 55, 90]), "the unit at the end is of all")
    compare(edges, m, ray, m.registration["optical_path"][on], share, "edges in cm")
    compare(stats(path, "--of", "path_length", "--detector", "sensor"), m, ray,
            m.ray["path_length"][ray], share, "path_length --detector")
    cosine = m.registration["direction"][on, 2].astype(float)
    angle = stats(path, "--of", "angle(sensor)", "--bins", "9")
    near(angle["mean"]["value"], float(np.average(
        np.degrees(np.arccos(-cosine)), weights=m.flux[m.ray["source"][ray]])), "angle", 1e-6)


def check_sums(m, path):
    """Sums of numbers: of rays, none where registrations of a number differ; with --detector of registrations."""
    every = np.arange(len(m.ray["id"]))
    compare(stats(path, "--of", "optical_path - 1.5 * path_length"), m, every, m.ray["optical_path"] - 1.5 * m.ray["path_length"],
            np.ones(len(every)), "optical_path - 1.5 * path_length", 1e-8)
    value, known = {}, np.ones(len(every), dtype=bool)
    for detector in (0, 1):
        on = m.registered(detector)
        least, most = np.full(len(every), np.inf), np.full(len(every), -np.inf)
        np.minimum.at(least, m.of_registration[on], m.registration["optical_path"][on])
        np.maximum.at(most, m.of_registration[on], m.registration["optical_path"][on])
        value[detector], known = least, known & (least == most)
    check(20 < known.sum() < len(every) / 2, "some rays are registered once on both")
    text = "optical_path(top) - 2 * optical_path(sensor) + 1 cm"
    got = stats(path, "--of", text)
    compare(got, m, every[known], 10 + value[1][known] - 2 * value[0][known], np.ones(known.sum()), "a sum of two detectors", 1e-8)
    check(got["undefined"] == len(every) - known.sum(), "rays without it")
    near(stats(path, "--of", text, "--unit", "cm")["mean"]["value"], got["mean"]["value"] / 10, "in cm")
    on = m.registered(0)
    x, y = ((m.registration["relative"][on] / 65535.0 - 0.5) * 40).T
    compare(stats(path, "--of", "x - y", "--detector", "sensor"), m, m.of_registration[on], x - y, np.ones(on.sum()), "x - y", 1e-7)
    own = m.of_registration[on]
    for text, value in (("optical_path", m.registration["optical_path"][on]), ("1 * optical_path(sensor)", m.registration["optical_path"][on]),
                        ("path_length - 2 * y", m.ray["path_length"][own] - 2 * y), ("2 * path_length", 2 * m.ray["path_length"][own])):
        compare(stats(path, "--of", text, "--detector", "sensor"), m, own, value, np.ones(on.sum()), text + " --detector", 1e-7)
    for where, told in (("registered(top where angle < 40)", 1), ("registered(top)", 0)):
        said = run("stats", path, "--of", "time(top) - time(sensor)", "-w", where).stderr
        check(said.count("'where angle < 40' chooses rays alone") == told, f"{where}: {said}")
    top = json.loads(run("query", path, "all", "--top", "3", "--of", "optical_path - path_length", "--json").stdout)
    greatest = np.argsort(m.ray["path_length"] - m.ray["optical_path"], kind="stable")[:3]
    check([ray["ray"] for ray in top["top"]] == m.ray["id"][greatest].tolist(), f"the greatest: {top}")


def check_wavelengths(m, path):
    """A ray that keeps several wavelengths is spread over them."""
    last = np.cumsum(m.ray["segment_count"]) - 1
    colour = m.segment["colour_spectral"][last] / 65535.0
    many = np.isnan(m.ray["wavelength"])
    check(many.any() and not many.all(), "some rays keep several wavelengths")
    shares = np.where(many[:, None], colour, m.ray["wavelength"][:, None] == m.wavelength)
    ray, channel = np.nonzero(shares)
    got = stats(path, "--of", "wavelength")
    check(got["histogram"]["edges"] == [400, 500, 600, 700], "bands of the channels")
    compare(got, m, ray, m.wavelength[channel], shares[ray, channel], "wavelength", 1e-6)


def check_two(m, path):
    on = m.registered(0)
    ray = m.of_registration[on]
    x, y = ((m.registration["relative"][on] / 65535.0 - 0.5) * 40).T
    run("stats", path, "--of", "x(sensor)", "--of", "y(sensor)", "--bins", "8", "--bins", "5",
        "--range", "-20..20", "--range", "-20..10", "-o", "two.csv", "--force")
    with open("two.csv", encoding="utf8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    check(len(rows) == 40, "40 cells")
    source = m.ray["source"]
    for row in rows:
        inside = ((x >= float(row["x_low"])) & (x < float(row["x_high"])) &
                  (y >= float(row["y_low"])) & (y < float(row["y_high"])))
        q = per_ray(m, ray[inside], m.ray["weight"][ray[inside]][:, None])
        near(float(row["flux"]), sum(m.flux[s] * q[source == s].sum() for s in range(2)), "cell")
        near(float(row["standard_error"]), error(q, source, m.flux, m.emitted)[0, 0] ** 0.5,
             "error of a cell", 1e-9)
    both = stats(path, "--of", "x(sensor)", "--of", "y(sensor)", "--bins", "8", "--bins", "5",
                 "--range", "-20..20", "--range", "-20..10")
    check(np.allclose(np.array(both["histogram"]["flux"]).ravel(),
                      [float(row["flux"]) for row in rows]), "the same in JSON")
    near(sum(map(sum, both["histogram"]["flux"])) + both["histogram"]["outside"]["flux"],
         both["flux"]["value"], "all light is somewhere", 1e-12)


def check_units(path):
    """Another unit is the same numbers, in it; bare ranges and edges are, too."""
    own = stats(path, "--of", "time(sensor)", "--range", "0..1 us", "--bins", "5")
    other = stats(path, "--of", "time(sensor)", "--unit", "ns", "--range", "0..1000", "--bins", "5")
    near(other["mean"]["value"], 1e9 * own["mean"]["value"], "mean in ns")
    check(other["unit"] == "ns" and own["unit"] == "s", "units")
    check(own["histogram"]["rays"] == other["histogram"]["rays"] and max(own["histogram"]["rays"]) > 0, "bins in ns")
    check("s ms us ns ps fs" in refused(2, "--of", "time(sensor)", "--unit", "mm"), "units that fit")
    check("plain number" in refused(2, "--of", "segments", "--unit", "mm"), "no unit")


def check_files(path):
    """NumPy and HDF5 files say what the JSON says; pictures are pictures."""
    names = ["out.npz", "out.npy", "out.h5", "out.png", "out.svg", "out.json"]
    outputs = [word for name in names for word in ("-o", name)]
    run("stats", path, "--of", "x(sensor)", "--by", "source", "--bins", "7", *outputs, "--force")
    with open("out.json", encoding="utf8") as file:
        groups = json.load(file)["groups"]
    flux = np.array([g["histogram"]["flux"] for g in groups])
    errors = np.array([g["histogram"]["standard_error"] for g in groups])
    npz = np.load("out.npz")
    check(np.array_equal(np.load("out.npy"), flux), ".npy")
    check(np.array_equal(npz["flux"], flux) and np.array_equal(npz["standard_error"], errors) and
          np.array_equal(npz["edges"], groups[0]["histogram"]["edges"]), ".npz")
    check(npz["moments"][1][1][0] == groups[1]["mean"]["value"] and
          npz["quantiles"][0][2][2] == groups[0]["quantiles"][2]["standard_error"], ".npz: moments")
    with h5py.File("out.h5") as file:
        check(np.array_equal(file["flux"], flux) and file["flux"].attrs["units"] == b"W" and
              file["edges"].attrs["units"] == b"mm" and file.attrs["groups"] == b"lamp\nside" and
              file["rays"].attrs["description"] != b"", ".h5")
    with open("out.png", "rb") as file:
        check(file.read(8) == b"\x89PNG\r\n\x1a\n", ".png")
    with open("out.svg", encoding="utf8") as file:
        text = file.read()
    check("x(sensor), mm" in text and "flux per bin, W" in text and "side" in text, ".svg")
    frame = max(float(x) for x in re.findall(r'<line x1="([0-9.]+)"', text))
    legend = re.search(r'<text x="([0-9.]+)"[^>]*>side</text>', text)
    check(float(legend[1]) > frame, "the legend stands beside the frame")
    run("stats", path, "--of", "path_length", "--where", "ray == 0", "-o", "out.svg", "--force")
    with open("out.svg", encoding="utf8") as file:
        check("nan" not in file.read(), "errors that are not defined are left out of the picture")
    run("stats", path, "--of", "x(sensor)", "--of", "y(sensor)", "-o", "two.npz", "-o", "two.svg",
        "--where", "segments > 99999", "--force")
    check(np.load("two.npz")["flux"].sum() == 0, "nothing, in two dimensions")
    with open("two.svg", encoding="utf8") as file:
        check("no ray has a value here" in file.read(), "a note in the picture")
    check("exists" in run("stats", path, "--of", "ray", "-o", "out.npz", status=2).stderr, "--force")


def check_receivers(m, path):
    """A receiver that lies where a detector is has its values."""
    with open("again.yaml", "w", encoding="utf8") as file:
        file.write("detectors:\n")
        for name in ("again", "once more"):
            file.write(f"  - {{name: {name}, type: plane, on: low, size: [40, 40], cells: [20, 20], at: [0, 0, 0], direction: [0, 0, 1]}}\n")
    both = [stats(path, "--of", f"optical_path({name})", "--receivers", "again.yaml", "--bins", 9,
                  "--range", "0..900") for name in ("sensor", "again")]
    check(both[0]["values"] == both[1]["values"] == int(m.registered(0).sum()), "values laid over")
    near(both[1]["mean"]["value"], both[0]["mean"]["value"], "mean laid over", 1e-5)
    for name in ("once more", "'once more'"):
        check(stats(path, "--of", "optical_path", "--detector", name, "--receivers", "again.yaml")["mean"] == both[1]["mean"], f"a name with a blank: {name}")
    with open("sky.yaml", "w", encoding="utf8") as file:
        file.write("detectors:\n  - {name: sky, type: intensity, cells: [4, 4]}\n")
    for words, n in ((("query", path, "x(*) > 3"), 1), (("stats", path, "--of", "x(*)"), 1), (("query", path, "registered(* where y < 3)"), 1),
                     (("query", path, "world_x(*) > 3"), 0), (("query", path, "x(sky) > 3"), 0)):
        said = run(*words, "--receivers", "sky.yaml").stderr
        check(said.count("far fields are in degrees") == n, f"{words}: {said}")
    asked = ("--receivers", "again.yaml", "-w", "registered(again)", "-w", "registered(sensor where scatter_order == 0)")
    for group, text in zip(stats(path, "--of", "optical_path(again)", *asked)["groups"], asked[3::2]):
        alone = stats(path, "--of", "optical_path(again)", *asked[:2], "-w", text)
        check(group["values"] == alone["values"] > 0 and group["flux"] == alone["flux"], f"by criterion, laid over: {text}")
    seen = {g["name"]: g for g in json.loads(run("query", path, "all", *asked[:2], "--by", "detector", "--json").stdout)["groups"]}
    check({**seen["again"], "name": ""} == {**seen["sensor"], "name": ""}, "rays on both")
    check("did you mean 'again'" in run("stats", path, "--of", "x(agan)", "--receivers",
                                        "again.yaml", status=3).stderr, "names of receivers")


def check_groups(m, path):
    by = stats(path, "--of", "path_length", "--by", "source")
    check([g["name"] for g in by["groups"]] == ["lamp", "side"], "names of sources")
    every = np.arange(len(m.ray["id"]))
    for s, group in enumerate(by["groups"]):
        own = m.ray["source"] == s
        compare(group, m, every[own], m.ray["path_length"][own], np.ones(own.sum()), group["name"])
    by = stats(path, "--of", "time", "--detector", "*", "--by", "detector")
    for d, group in enumerate(by["groups"]):
        on = m.registered(d)
        compare(group, m, m.of_registration[on],
                m.registration["optical_path"][on] * 1e-3 / 299792458.0, np.ones(on.sum()),
                group["name"])
    check_histories(m, path)
    check_criteria(path)
    check_paths(path)


def labels_of(m, row, before):
    """What --by tells the first `before` segments of a ray apart by."""
    first = m.first_segment[row]
    objects, events = (m.segment[name][first:first + before] for name in ("object", "event"))
    met = objects[objects >= 0]
    name = ["low", "high", "entry", "exit"]
    return {"object": name[met[-1]] if len(met) else "(none)", "ended": ["absorbed", "left", "limit", "error"][m.ray["stop"][row]],
            "ghost_order": str(int(((events & 1 != 0) & (objects >= 2)).sum())),  # the plate's faces let light through
            "scatter_order": str(int((events & 2 != 0).sum()))}


def check_histories(m, path):
    """Groups by what rays met and how they ended, in their whole histories or before a registration."""
    m.first_segment = np.cumsum(m.ray["segment_count"]) - m.ray["segment_count"]
    of_ray = [labels_of(m, row, n) for row, n in enumerate(m.ray["segment_count"])]
    on = np.flatnonzero(m.registered(0))
    of_registration = [labels_of(m, m.of_registration[k], m.registration["segment"][k]) for k in on]
    for by in ("object", "ended", "ghost_order", "scatter_order"):
        for labels, ray, value, words in (
                (of_ray, np.arange(len(m.ray["id"])), m.ray["path_length"], ("--of", "path_length")),
                (of_registration, m.of_registration[on], m.registration["optical_path"][on], ("--of", "optical_path(sensor)"))):
            own = np.array([one[by] for one in labels])
            if by.endswith("order"):
                own = np.array(["15 or more" if int(one) > 14 else one for one in own])
            got = stats(path, *words, "--by", by)
            check(got["by"] == by and {g["name"] for g in got["groups"]} == set(own), f"groups by {by}: {[g['name'] for g in got['groups']]}")
            for group in got["groups"]:
                its = own == group["name"]
                check(group["values"] == its.sum(), f"values of {by} {group['name']}")
                if value[its].min() == value[its].max():  # exactly, wherever the others are
                    check(group["mean"] == {"value": value[its][0], "standard_error": 0.0 if group["values_of_rays"] > 1 else None} and group["standard_deviation"]["value"] == 0 and
                          group["skewness"]["value"] is None, f"one number of {by} {group['name']}: {group['mean']}")
                elif its.sum() > 500:
                    compare(group, m, ray[its], value[its], np.ones(its.sum()), f"{words} by {by} {group['name']}")
            near(sum(g["flux"]["value"] for g in got["groups"]), stats(path, *words)["flux"]["value"], f"all of {by}")
        check_counts(path, by, own_of_rays := [one[by] for one in of_ray], m.ray["segment_count"])
        check(len(set(own_of_rays)) > 1, f"several groups by {by}")
    check_counts(path, "source", np.array(["lamp", "side"])[m.ray["source"]], m.ray["segment_count"])
    check(len(set(one["scatter_order"] for one in of_ray)) > 8 and len(set(one["ghost_order"] for one in of_registration)) > 1, "orders")
    check("did you mean 'ghost_order'" in refused(2, "--of", "flux", "--by", "gost_order"), "a wrong word")


def check_counts(path, by, label, n_segment):
    """`query --by` counts the rays that `stats --by` has, and their segments; by detector each ray once on each."""
    label = np.array(["15 or more" if by.endswith("order") and int(one) > 14 else one for one in label])
    for criterion in ("all", "segments > 3"):
        got = SERVER.query(criterion, by=by)
        of = {g["name"]: g for g in stats(path, "--of", "segments", "--by", by, "-w", criterion)["groups"]}
        its = n_segment > 3 if criterion != "all" else n_segment > 0
        check(got["by"] == by and [g["name"] for g in got["groups"]] == [name for name in of if (label[its] == name).any()], f"groups of {criterion} by {by}")
        for group in got["groups"]:
            want = of[group["name"]]
            check(group["rays"] == want["values_of_rays"] == (label[its] == group["name"]).sum(), f"rays of {criterion} by {by}: {group}")
            check(group["segments"] == n_segment[its][label[its] == group["name"]].sum(), f"segments of {criterion} by {by}: {group}")
            near(group["flux"]["value"], want["flux"]["value"], f"flux of {by} {group['name']}")
            near(group["flux"]["standard_error"], want["flux"]["standard_error"], f"error of {by} {group['name']}", 1e-6)
    for detector in SERVER.query("all", by="detector")["groups"]:
        alone = SERVER.query(f"registered({detector['name']})")
        check((detector["rays"], detector["segments"], detector["flux"]["value"], detector["flux"]["standard_error"]) ==
              (alone["rays"]["matched"], alone["segments"]["matched"], alone["flux"]["matched"], alone["flux"]["standard_error"]), f"on {detector}")


def check_criteria(path):
    """Several criteria in one scan: each group is what its criterion says alone, also where rays are in more than one, of registrations
    those that it has count, and with values in memory or not."""
    with open("named.criteria", "w", encoding="utf8") as file:
        file.write("let bounced = hit(*, reflect) >= 2\nlet seen = registered(sensor where angle < 40 deg)\n")
    bins = ("--bins", "12", "--range", "0..90 deg")
    asked = ["registered(sensor where angle < 30 deg)", "hit(low)", "segments > 99999", "registered(sensor where scatter_order == 1)", "all"]
    for words in (("--of", "path_length"), ("--of", "angle(sensor)", *bins), ("--of", "angle(sensor)", *bins, "--which", "angle < 50 deg"),
                  ("--of", "x(sensor)", "--of", "angle(sensor)", "--bins", "6"), ("--of", "path_length", "--memory", "1")):
        got = stats(path, *words, *(x for text in asked for x in ("-w", text)))
        check(got["by"] == "criterion" and [g["name"] for g in got["groups"]] == asked, f"names: {got['by']}")
        check(got["rays"] == stats(path, *words)["rays"], "all rays match one of them")
        for text, group in zip(asked, got["groups"]):
            alone = stats(path, *words, "-w", text)
            check(group["values"] == alone["values"] and group["values_of_rays"] == alone["values_of_rays"] and group["flux"] == alone["flux"],
                  f"{words} {text}: {group['values']} values, not {alone['values']}")
            if "--range" in words:
                check(group["histogram"] == alone["histogram"], f"histogram of {words} {text}")
            for one, other in zip(group.get("quantities", [group]), alone.get("quantities", [alone])):
                for key in ("mean", "standard_deviation"):
                    if other[key]["value"] is None:
                        check(one[key]["value"] is None, f"no {key} of {words} {text}")
                    else:
                        near(one[key]["value"], other[key]["value"], f"{key} of {words} {text}", 1e-8)
                check("--memory" in words or one["quantiles"] == other["quantiles"], f"quantiles of {words} {text}")
    for words in (("--of", "path_length", "--by", "source"), ("--of", "angle", "--detector", "*", "--by", "detector"),
                  ("--of", "angle(sensor)", "--by", "object"), ("--of", "optical_path(sensor)", "--by", "scatter_order", "--which", "angle < 50 deg")):
        words = (*words, "--bins", "6", "--range", "0..90")
        got = stats(path, *words, *(x for text in asked for x in ("-w", text)))["groups"]
        alone = [(text, g) for text in asked for g in stats(path, *words, "-w", text)["groups"]]
        check([g["criterion"] for g in got] == [text for text, _ in alone] and len(alone) > 7, f"criteria of {words}: {len(alone)}")
        for group, (text, own) in zip(got, alone):
            for key in ("name", "values", "values_of_rays", "flux", "histogram", "quantiles"):
                check(group[key] == own[key], f"{words} {text}: {key} {group[key]}, not {own[key]}")
    named = stats(path, "--of", "angle(sensor)", "--criteria", "named.criteria", "--by", "criterion")
    check([g["name"] for g in named["groups"]] == ["bounced", "seen"], "a file's names")
    check(named["groups"][1]["values"] == stats(path, "--of", "angle(sensor)", "--criteria", "named.criteria", "-w", "@seen")["values"], "@seen")
    check("\nsource lamp of hit(low)\n" in run("stats", path, "--of", "path_length", "--by", "source", "-w", "all", "-w", "hit(low)").stdout, "both are said")
    run("stats", path, "--of", "path_length", "-w", asked[0], "-w", asked[1], "-o", "two.svg", "-o", "two.csv", "--force")
    with open("two.svg", encoding="utf8") as drawn, open("two.csv", encoding="utf8") as listed:
        check(all(text.replace("<", "&lt;") in drawn.read() for text in asked[:1]) and "\nhit(low)," in listed.read(), "a line for each")
    for words, text in ((("--by", "criterion"), "anyway"), (("--by", "source", "--limit", "2"), "is of counts"), (("--by", "sorce"), "did you mean 'source'")):
        check(text in run("query", path, "all", *words, status=2).stderr, text)
    check("raymap paths" in run("query", path, "all", "--by", "path", status=2).stderr, "paths counts them")
    for words, text in ((("--by", "criterion"), "--criteria FILE"), (("--by", "path", "-w", "all", "-w", "all"), "join several"),
                        (("--zemax", "H1", "-w", "all"), "not both"), (65 * ("-w", "all"), "64 criteria"),
                        (("--of", "segments", "-w", "all", "-w", "all", "-o", "no.png"), "one criterion")):
        said = run("stats", path, "--of", "path_length", *words, status=2).stderr if "-o" in words else refused(2, "--of", "path_length", *words)
        check(text in said, f"{text}: {said}")


def check_paths(path):
    """Groups by path are the classes that `paths` ranks, with the values that their criteria pick, and the others."""
    where = ("-w", "segments > 1 and not hit(high) >= 3")
    for by, level in (("path", "surface"), ("path:object", "object"), ("path:group", "group")):
        for of, until in (("path_length", ()), ("angle(sensor)", ("--detector", "sensor"))):
            ranked = SERVER.paths(**keys_of([*where, "--by", level, *until, "--top", "4", "--no-peaks"]))
            got = stats(path, "--of", of, *where, "--by", by, "--top", "4")
            named = [f"{c['source']}: {c['sequence']}" for c in ranked["classes"]]
            check(got["by"] == by and [g["name"] for g in got["groups"]] == named + ["(others)"], f"{of} by {by}: {[g['name'] for g in got['groups']]}")
            for group, row in zip(got["groups"], ranked["classes"]):
                alone = stats(path, "--of", of, "-w", row["criterion"], "--which" if until else "--bins",
                              re.search(r"registered\(sensor where (path\(.*\))\)$", row["criterion"])[1] if until else "5")
                check(group["values"] == alone["values"] > 0 and group["values_of_rays"] == row["rays"], f"{of} of {group['name']}: {group['values']}")
                near(group["flux"]["value"], row["flux"], f"flux of {group['name']}")
                near(group["mean"]["value"], alone["mean"]["value"], f"mean of {group['name']}", 1e-8)
                check(group["quantiles"] == alone["quantiles"], f"quantiles of {group['name']}")
            every = stats(path, "--of", of, *where)
            check(sum(g["values"] for g in got["groups"]) == every["values"], "nothing is lost")
            near(sum(g["flux"]["value"] for g in got["groups"]), every["flux"]["value"], "flux of all")
    run("stats", path, "--of", "path_length", "--by", "path", "-o", "paths.svg", "--force")
    with open("paths.svg", encoding="utf8") as file:
        check(re.search(r">[1-9]  lamp: ", file.read()), "ranks in the legend")
    for words, text in ((("--by", "source", "--top", "3"), "--by path"), (("--by", "path", "--top", "101"), "between 1 and 100"),
                        (("--by", "path", "--until", "5%"), "all rays tell"), (("--by", "pathobject",), "did you mean 'path:object'")):
        said = refused(2, "--of", "path_length", *words)
        check(text in said, f"{text}: {said}")


def check_beams():
    """A source of few rays is shown in full beside one of many, and is seen in the picture. Few
    whole numbers are all shown, however rare."""
    with open("beams.yaml", "w", encoding="utf8") as file:
        file.write(SPOT.replace("RADIUS", "0.01"))
    run("trace", "beams.yaml", "-o", "beams.raymap", "-n", 12000, "--force", "--quiet")
    by = stats("beams.raymap", "--of", "x(sensor)", "--by", "source", "-o", "beams.svg", "--force")
    near(sum(by["groups"][1]["histogram"]["flux"]), 1e-3, "the wide beam's light in the bins")
    with open("beams.svg", encoding="utf8") as file:
        check("logarithmic scale" in file.read(), "the wide beam in the picture")
    run("stats", "beams.raymap", "--of", "x(sensor)", "--by", "source", "--where",
        "source(narrow)", "-o", "narrow.svg", "--force")
    with open("narrow.svg", encoding="utf8") as file:
        check("logarithmic" not in file.read(), "a logarithmic scale for one beam alone")
    edges = stats("beams.raymap", "--of", "cell_i(sensor)")["histogram"]["edges"]
    check((edges[0], edges[-1]) == (-0.5, 19.5), f"all columns of cells: {edges}")


def check_many_sources():
    """Groups of one source each take no more than their own; others say what would help."""
    with open("lamps.yaml", "w", encoding="utf8") as file:
        file.write("raymap: 1\nmedia: {air: {index: 1}}\nsurfaces: {white: {type: lambert, reflectance: 0.6}}\n"
                   "geometries: {b: {type: box, size: [10, 10, 10]}}\nobjects:\n")
        file.writelines(f"  - {{name: box{k}, geometry: b, at: [{11 * k}, 0, 0], surface: white, outside: air, inside: air}}\n" for k in range(250))
        file.write("sources:\n")
        file.writelines(f"  - {{name: s{k}, type: point, at: [{11 * (k % 250)}, 0, 0], medium: air, flux: {1 + k % 3}}}\n" for k in range(500))
    run("trace", "lamps.yaml", "-o", "lamps.raymap", "-n", 2000, "--force", "--quiet")
    by = stats("lamps.raymap", "--of", "path_length", "--by", "source")["groups"]
    check(len(by) == 500, f"{len(by)} sources")
    for k in (0, 1, 499):
        near(by[k]["flux"]["value"], 1 + k % 3, f"flux of s{k}")
        alone = stats("lamps.raymap", "--of", "path_length", "--where", f"source(s{k})")
        for key in ("value", "standard_error"):
            near(by[k]["mean"][key], alone["mean"][key], f"{key} of the mean of s{k} alone")
        check([q["value"] for q in by[k]["quantiles"]] == [q["value"] for q in alone["quantiles"]], f"quantiles of s{k} alone")
    check("fewer groups (--by, --where)" in run("stats", "lamps.raymap", "--of", "path_length", "--by", "object", status=2).stderr, "groups")


def check_memory(path):
    """Values that do not fit into memory: the map is read twice."""
    for of in ("x(sensor)", "segments"):
        whole = stats(path, "--of", of)
        lean = stats(path, "--of", of, "--memory", "1000")
        for key in ("flux", "mean", "standard_deviation", "skewness", "kurtosis", "histogram",
                    "values", "min", "max"):
            check(whole[key] == lean[key], f"{of}: {key} without memory")
        resolution = lean["quantile_resolution"]
        check((resolution > 0) == (of != "segments"), f"{of}: resolution {resolution}")
        for a, b in zip(whole["quantiles"], lean["quantiles"]):
            check(abs(a["value"] - b["value"]) <= resolution, f"{of}: quantile {a['p']}")
            if of == "segments":
                check(a == b, f"{of}: quantile {a['p']} of whole numbers")


def check_refusals(path):
    empty = stats(path, "--of", "path_length", "--where", "hit(low) > 100000", "-o", "empty.csv",
                  "--force")
    check(empty["values"] == 0 and empty["flux"]["value"] == 0 and empty["mean"]["value"] is None
          and empty["quantiles"][0]["value"] is None, "nothing matches")
    check("nothing to show" in run("stats", path, "--of", "x(top)", "--where",
                                   "segments > 99999").stdout, "a note that nothing matches")
    none = stats(path, "--of", "path_length", "--where", "segments > 99999", "--by", "source")
    check([g["values"] for g in none["groups"]] == [0, 0], "nothing matches, by source")
    wrong = {
        ("--of", "wavelengt"): (3, "did you mean 'wavelength'"),
        ("--of", "x(senso)"): (3, "did you mean 'sensor'"),
        ("--of", "hit(lo)"): (3, "did you mean 'low'"),
        ("--of", "x"): (3, "of which detector"),
        ("--of", "x(sensor)", "--of", "y(top)"): (3, "same detector"),
        ("--of", "hit(low) and hit(high)"): (3, "one number"),
        ("--of", "path_length > 3"): (3, "the end"),
        ("--of", ""): (3, "a number such as"),
        ("--of", "path_length - wavelength"): (3, "in another unit"),
        ("--of", "path_length - 2 deg"): (3, "no unit here"),
        ("--of", "x(sensor) - "): (3, "a number such as x(NAME) or path_length, found the end"),
        ("--of", "x - path_length(air)", "--detector", "sensor"): (3, "not in sums"),
        ("--of", "x - y(top)", "--detector", "sensor"): (3, "same detector"),
        (): (2, "--of is missing"),
        ("--of", "ray", "--of", "ray", "--of", "ray"): (2, "once, or twice"),
        ("--of", "path_length", "--bins", "1000000000"): (2, "1000000000 bins"),
        ("--of", "x(sensor)", "--of", "y(sensor)", "--bins", "1e5"): (2, "10000000000 bins"),
        ("--of", "path_length", "--bins", "0"): (2, "one bin"),
        ("--of", "path_length", "--bins", "3,2"): (2, "ascend"),
        ("--of", "path_length", "--range", "1..2 deg"): (2, "is no unit here"),
        ("--of", "path_length", "--range", "2..1"): (2, "backwards"),
        ("--of", "path_length", "--range", "1..1"): (2, "no width"),
        ("--of", "path_length", "--log", "--range", "0..1"): (2, "above 0"),
        ("--of", "path_length", "--by", "sourc"): (2, "did you mean 'source'"),
        ("--of", "path_length", "--by", "detector"): (2, "--detector"),
        ("--of", "path_length", "--quantiles", "101"): (2, "from 0 to 100"),
        ("--of", "path_length", "--quantiles", "nan"): (2, "from 0 to 100"),
        ("--of", "path_length", "-o", "x.doc"): (2, ".csv"),
    }
    for arguments, (status, text) in wrong.items():
        said = run("stats", path, *arguments, status=status).stderr if "-o" in arguments else refused(status, *arguments)
        check(text in said, f"{arguments}: {said}")
    run("stats", path, "--of", "path_length", "--log", "-o", "log.json", "--force")
    with open("log.json", encoding="utf8") as file:
        histogram = json.load(file)["histogram"]
    edges = histogram["edges"]
    check(all(isinstance(n, int) for n in histogram["rays"]), "rays are whole numbers")
    check(np.allclose(np.diff(np.log(edges)), np.log(edges[1] / edges[0])), "bins of equal ratio")
    run("stats", path, "--of", "path_length", "--log", "--range", "1..1000", "-o", "log.svg",
        "--force")
    with open("log.svg", encoding="utf8") as file:
        drawn = file.read()
    check(all(f">{tick}<" in drawn for tick in (1, 10, 100, 1000)), "values at the ticks")


def check_seeds():
    """Variance over seeds against the errors reported: each ratio within the law of chi-square
    with 19 degrees of freedom, 99.8 % of which lie in [0.29, 2.3]."""
    seen = {}

    results = []
    with raymap.serve.start("scene.yaml") as server:
        for seed in range(20):
            server.trace(1500, 100 + seed)
            results.append(server.stats(of="optical_path(sensor)", bins="0,20,60,400e3"))
    for got in results:
        figures = {k: got[k] for k in ("flux", "mean", "standard_deviation")}
        figures["median"] = got["quantiles"][2]
        for b in range(3):
            figures[f"bin {b}"] = {"value": got["histogram"]["flux"][b],
                                   "standard_error": got["histogram"]["standard_error"][b]}
        for key, value in figures.items():
            seen.setdefault(key, []).append((value["value"], value["standard_error"]))
    for key, pairs in seen.items():
        value, reported = np.array(pairs).T
        ratio = value.var(ddof=1) / (reported**2).mean()
        print(f"variance over seeds / reported, {key}: {ratio:.2f}")
        check(0.29 < ratio < 2.4, f"variance ratio of {key}: {ratio}")


def main():
    global SERVER
    with open("scene.yaml", "w", encoding="utf8") as file:
        file.write(SCENE)
    run("trace", "scene.yaml", "-o", "a.raymap", "-n", RAYS, "--encoding", "plain", "--force",
        "--quiet", status=7)  # some rays meet the wrong medium
    m = Map("a.raymap")
    with raymap.serve.start("a.raymap") as SERVER:
        check_numbers(m, "a.raymap")
        check_sums(m, "a.raymap")
        check_wavelengths(m, "a.raymap")
        check_two(m, "a.raymap")
        check_groups(m, "a.raymap")
        check_files("a.raymap")
        check_units("a.raymap")
        check_receivers(m, "a.raymap")
        check_memory("a.raymap")
        check_refusals("a.raymap")
    check_beams()
    check_many_sources()
    check_seeds()
    sys.exit(f"{failures} failures" if failures else 0)


main()
