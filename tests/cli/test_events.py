#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""The event of a ray, by the numbers of its source's file: criteria, statistics, tables, CSV and reports know it, in either encoding, on
any number of ranks. Rays fly straight through air at two plates, so that all readings are worked out here from the file's rows."""
import csv
import json
import pathlib

import asking
import h5py
import numpy as np
import ray_files
import served
from asking import check, run

N = 3000
ROWS = 5000  # more rays than rows
dice = np.random.default_rng(29)
place = dice.uniform(-1, 1, (N, 3))  # mm
right = dice.random(N) < 0.6
way = np.column_stack([*dice.uniform(-0.3, 0.3, (2, N)), np.where(right, 1.0, -1.0)])
way /= np.linalg.norm(way, axis=1)[:, None]
nm = dice.choice([450.0, 550.0, 650.0], N)
time = dice.uniform(0, 20, N)  # ns
event = np.sort(dice.choice(np.array([3, 4, 10, 11, 12, 500, 2**40]), N))
dice.shuffle(event)
row = np.arange(ROWS) % N
SCENE = """raymap: 1
units: mm
time: on
spectrum: {wavelengths: [450, 550, 650]}
media: {air: {index: 1}}
geometries: {plate: {type: rectangle, size: [400, 400]}}
objects:
  - {name: plate_r, geometry: plate, at: [0, 0, 100], surface: absorber}
  - {name: plate_l, geometry: plate, at: [0, 0, -200], surface: absorber}
sources: [{name: led, type: ray_file, file: rays.csv, medium: air, flux: FLUX}MORE]
detectors:
  - {name: right, type: plane, on: plate_r, cells: 4 RIGHT}
  - {name: left, type: plane, on: plate_l, cells: 4, direction: [0, 0, 1] LEFT}
"""


def scene(name, flux=f"{ROWS} W", more="", right_more="", left_more=""):
    text = SCENE.replace("FLUX", flux).replace("MORE", more).replace("RIGHT", right_more).replace("LEFT", left_more)
    pathlib.Path(name).write_text(text, encoding="utf-8")
    return name


def matched(target, what):
    return served.ask("query", target, what)["rays"]["matched"]


def check_number():
    ray_files.csv("rays.csv", "x (mm),y (mm),z (mm),dx,dy,dz,wavelength,time (ns),event", *place.T, *way.T, nm, time, event)
    of = event[row]
    for target, encoding, ranks in (("p.raymap", "plain", 1), ("c.raymap", "compact", 2)):
        run("trace", scene("a.yaml"), "-o", target, "-n", ROWS, "--quiet", "--force", "--encoding", encoding, ranks=ranks)
        for what, rows in (("event == 10", of == 10), ("event != 10", of != 10), ("event in 4..11", (of >= 4) & (of <= 11)), ("event > 12", of > 12),
                           (f"event == {2**40}", of == 2**40), ("event < 3", of < 3), ("event <= 3.5", of <= 3),
                           ("event == 10 and registered(right)", (of == 10) & right[row]), ("event(absorb) and event == 4", of == 4)):
            check(matched(target, what) == rows.sum(), f"{target}: {what}: {matched(target, what)} not {rows.sum()}")
        told = served.ask("stats", target, "--of", "event", "--where", "event < 1000")
        check(abs(told["mean"]["value"] - of[of < 1000].mean()) < 1e-9, f"stats: {told}")
        groups = served.ask("query", target, "registered(right)", "--by", "event")["groups"]
        check({one["name"]: one["rays"] for one in groups} == {str(n): int((of[right[row]] == n).sum()) for n in np.unique(of)}, f"{groups}")
        groups = served.ask("stats", target, "--of", "time(left)", "--by", "event", "--unit", "ns")["groups"]
        k, t = arrivals(False)
        for one in groups:
            want = t[event[k] == int(one["name"])].mean()
            check(abs(one["mean"]["value"] - want) < 1e-5, f"{one['name']}: {one['mean']} {want}")
        run("query", target, "all", "-o", "t.h5", "--force", "--columns", "ray/id,ray/event,registration/event")
        with h5py.File("t.h5") as file:
            check(np.array_equal(file["ray/event"], of.astype(float)), f"{target}: column of rays")
            check(np.array_equal(file["registration/event"], of.astype(float)), f"{target}: column of registrations")
        run("query", target, "ray in 5..9", "-o", "t.csv", "--force")
        with open("t.csv", encoding="utf-8", newline="") as file:
            check([int(line["event"]) for line in csv.DictReader(file)] == list(of[5:10]), "CSV")
        check(served.ask("report", target, 4321)["event"] == of[4321], "report")
    check(json.loads(run("report", "a.yaml", "--ray", 4321, "--json"))["event"] == of[4321], "traced again")
    said = run("query", "p.raymap", "registered(right where event == 3)", status=3)
    check("is of the whole ray, not of a registration" in said, said)


def check_none():
    ray_files.csv("rays.csv", "x (mm),y (mm),z (mm),dx,dy,dz", *place.T, *way.T)
    run("trace", scene("n.yaml"), "-o", "n.raymap", "-n", 100, "--quiet", "--force")
    check("no source of this map numbers events" in run("query", "n.raymap", "event == 3", status=3), "no events")
    check("no source of this map numbers events" in run("stats", "n.raymap", "--of", "event", status=3), "no events in stats")
    ray_files.csv("rays.csv", "x (mm),y (mm),z (mm),dx,dy,dz,wavelength,time (ns),event", *place.T, *way.T, nm, time, event)
    lamp = ", {name: lamp, type: point, medium: air, flux: 1 W}"
    run("trace", scene("m.yaml", more=lamp), "-o", "m.raymap", "-n", 100, "--quiet", "--force")
    check(matched("m.raymap", "event >= 0") == matched("m.raymap", "source(led)") == 50, "a lamp's rays have none")
    check(matched("m.raymap", "event != 3 and source(lamp)") == 0, "which holds for no comparison")
    groups = served.ask("query", "m.raymap", "all", "--by", "event")["groups"]
    check({one["name"]: one["rays"] for one in groups}["(none)"] == 50, f"{groups}")


def check_goes_on():
    """Light of a map, or of a query's table, as a source has its events; a lamp's among it none."""
    lamp = ", {name: lamp, type: collimated, shape: {disc: 2}, at: [0, 0, 50], medium: air, flux: 5000 W}"
    run("trace", scene("m.yaml", more=lamp), "-o", "m.raymap", "-n", 200, "--quiet", "--force")
    run("query", "m.raymap", "all", "-o", "m.h5", "--columns", "registration", "--force")
    want = {str(n): int((event[np.arange(100)][right[:100]] == n).sum()) for n in np.unique(event[:100][right[:100]])} | {"(none)": 100}
    text = pathlib.Path("m.yaml").read_text(encoding="utf-8")
    for file in "m.raymap", "m.h5":
        source = f"sources: [{{name: again, type: ray_file, file: {file}, detector: right, medium: air}}]\n"
        lines = [source if line.startswith("sources:") else line + "\n" for line in text.splitlines()]
        pathlib.Path("g.yaml").write_text("".join(lines).replace("at: [0, 0, 100]", "at: [0, 0, 150]"), encoding="utf-8")
        run("trace", "g.yaml", "-o", "g.raymap", "-n", 100 + right[:100].sum(), "--quiet", "--force")
        groups = served.ask("query", "g.raymap", "all", "--by", "event")["groups"]
        check({one["name"]: one["rays"] for one in groups if one["rays"]} == want, f"{file}: {groups} not {want}")


QE = {450.0: 0.1, 550.0: 0.25, 650.0: 0.5}
PARTS = ((True, 0), (False, 1))


def arrivals(side):
    """Of rays that go to the side: the row of the ray, and the time at its plate in ns."""
    of = right[row] == side
    k = row[of]
    reach = np.where(side, 100 - place[k, 2], 200 + place[k, 2]) / np.abs(way[k, 2])
    return k, time[k] + reach / 299.792458


def table(target, *more, ranks=1):
    """What the program says, as JSON and as arrays."""
    told = json.loads(run("events", target, "--json", "-o", "e.h5", "-o", "e.csv", "-o", "e.json", "-o", "e.npz", "--force", *more, ranks=ranks))
    with h5py.File("e.h5") as file:
        arrays = {name: np.array(column) for name, column in file.items()}
        check(file.attrs["detectors"] in ("right,left", b"right,left"), f"{file.attrs['detectors']}")
    with np.load("e.npz") as packed:
        for name, column in arrays.items():
            check(np.array_equal(packed[name], column, equal_nan=True), f"npz: {name}")
    with open("e.csv", encoding="utf-8", newline="") as file:
        lines = list(csv.DictReader(line for line in file if not line.startswith("#")))
    with open("e.json", encoding="utf-8") as file:
        rows = json.load(file)["rows"]
    for name, column in arrays.items():
        for d, side in enumerate(("right", "left")) if column.ndim > 1 else ((0, None),):
            own = column[:, d] if side else column
            from_csv = [float(line[f"{name}({side})" if side else name] or "nan") for line in lines]
            from_json = [row[name][d] if side else row[name] for row in rows]
            check(np.array_equal(own, from_csv, equal_nan=True), f"CSV: {name} {side}")
            check(np.array_equal(own, [np.nan if v is None else v for v in from_json], equal_nan=True), f"JSON: {name} {side}")
    return told, arrays


def check_readings():
    """Sums, times and coincidences against numpy, from the rows of the file."""
    response = ", response: {wavelength: [450, 550, 650], value: [0.1, 0.25, 0.5]}"
    target = "r.raymap"
    run("trace", scene("r.yaml", right_more=response), "-o", target, "-n", ROWS, "--quiet", "--force", ranks=2)
    order, window, least = 3, 2.0, 2
    options = ("--order", order, "--window", f"{window} ns", "--threshold", 5)
    told, got = table(target, *options)
    number = np.unique(event)
    check(np.array_equal(got["event"], number.astype(float)), "events")
    check(np.array_equal(got["rays"], [(event[row] == n).sum() for n in number]), "rays of events")
    trigger = np.full((len(number), 2), np.nan)
    for side, d in PARTS:
        k, t = arrivals(side)
        w = np.array([QE[v] for v in nm[k]]) if side else np.ones(len(k))
        for i, n in enumerate(number):
            of = event[k] == n
            check(got["registrations"][i, d] == of.sum(), f"registrations {n} {side}")
            check(abs(got["sum"][i, d] - w[of].sum()) < 1e-9 * ROWS, f"sum {n} {side}: {got['sum'][i, d]} {w[of].sum()}")
            check(abs(got["first"][i, d] - t[of].min()) < 1e-6, f"first {n} {side}: {got['first'][i, d]} {t[of].min()}")
            check(abs(got["mean"][i, d] - (w * t)[of].sum() / w[of].sum()) < 1e-6, f"mean {n} {side}")
            trigger[i, d] = np.sort(t[of])[order - 1]
            check(abs(got["trigger"][i, d] - trigger[i, d]) < 1e-6, f"trigger {n} {side}")
    fired = got["sum"] >= 5
    both = fired.all(1) & (np.abs(trigger[:, 0] - trigger[:, 1]) <= window)
    check(np.array_equal(got["fired"], fired.sum(1)) and np.array_equal(got["coincident"], both), f"coincidences {got['coincident']} {both}")
    check(told["coincident"] == both.sum() and told["trigger"] == {"threshold": 5.0, "order": order, "coincidence": least, "window": window}, f"{told}")
    off = (trigger[:, 0] - trigger[:, 1])[fired.all(1)]
    check(abs(told["difference"]["mean"] - off.mean()) < 1e-6 and abs(told["difference"]["standard_deviation"] - off.std(ddof=1)) < 1e-6, "difference")
    of = told["detectors"][0]
    check(abs(of["signal"]["mean"] - got["sum"][:, 0].mean()) < 1e-9 and of["fired"] == fired[:, 0].sum(), f"{of}")
    for ranks in (3,):
        check(run("events", target, "--json", *options, ranks=ranks) == run("events", target, "--json", *options), f"{ranks} ranks")
        run("events", target, *options, "-o", "x.csv", "--force", ranks=ranks)
        check(pathlib.Path("x.csv").read_bytes() == pathlib.Path("e.csv").read_bytes(), f"the same table on {ranks} ranks")
    run("convert", target, "-o", "rp.raymap", "--encoding", "plain", "--force")
    run("events", "rp.raymap", *options, "-o", "x.csv", "--force")
    check(pathlib.Path("x.csv").read_bytes() == pathlib.Path("e.csv").read_bytes(), "the same table of columns")
    _, some = table(target, *options, "--where", "event in 4..11")
    check(np.array_equal(some["sum"], got["sum"][(number >= 4) & (number <= 11)]), "--where")


def check_chance():
    response = ", response: {wavelength: [450, 550, 650], value: [0.1, 0.25, 0.5]}, detect: chance"
    run("trace", scene("d.yaml", right_more=response), "-o", "d.raymap", "-n", ROWS, "--quiet", "--force")
    _, got = table("d.raymap")
    number = np.unique(event)
    for i, n in enumerate(number):
        check(got["registrations"][i, 0] == matched("d.raymap", f"detected(right) and event == {n}") == got["sum"][i, 0], f"by chance {n}")
    k, _ = arrivals(True)
    want = sum(QE[v] for v in nm[k])
    check(abs(got["sum"][:, 0].sum() - want) < 4 * np.sqrt(want), "by chance, in all")


def draws(reading, n=20000):
    """Cells of n events of 20 photo-electrons each on the right, none on the left."""
    ray_files.csv("rays.csv", "x (mm),y (mm),z (mm),dx,dy,dz,time (ns),event", *np.zeros((5, 20 * n)), np.ones(20 * n), np.zeros(20 * n),
                  np.arange(20 * n) // 20)
    path = scene("s.yaml", flux=f"{20 * n} photons", right_more=reading, left_more=reading)
    run("trace", path, "-o", "s.raymap", "-n", 20 * n, "--quiet", "--force")
    return json.loads(run("events", "s.raymap", "--json", "-o", "e.h5", "--force"))


def spread(what, got, mean, variance):
    z = (got.mean() - mean) / np.sqrt(variance / len(got))
    check(abs(z) < 4, f"{what}: mean {got.mean()} not {mean}: z = {z:.2f}")
    z = (got.var() / variance - 1) / np.sqrt((((got - got.mean())**4).mean() / got.var()**2 - 1) / len(got))
    check(abs(z) < 4.5, f"{what}: variance {got.var()} not {variance}: z = {z:.2f}")


def check_sipm():
    """Dark counts are Poisson's, crosstalk Borel's or geometric, cells saturate: means and variances."""
    n, p, cells = 1500, 0.2, 100
    told = draws(", reading: {gain: 1e6, dark: 10 MHz, window: 300 ns}", n)
    with h5py.File("e.h5") as file:
        got = {name: np.array(column) for name, column in file.items()}
        check(told["detectors"][0]["unit"] == "cells" and file["sum"].attrs["units"] in ("photons", b"photons"), f"{told['detectors']}")
    check(np.array_equal(got["photo_electrons"], np.column_stack([np.full(n, 20), np.zeros(n)])), "counted photons are not drawn again")
    spread("dark counts", got["dark"].ravel(), 3, 3)
    check(np.array_equal(got["cells"], got["photo_electrons"] + got["dark"]) and (got["crosstalk"] == 0).all(), "nothing else")
    check(np.allclose(got["charge"], got["cells"] * 1e6 * 1.602176634e-7, rtol=1e-12), "charge in pC")
    some = got["trigger"][:, 1][got["dark"][:, 1] > 0]
    k = np.arange(1, 40)  # the first of k is at 300 / (k + 1) in the mean
    share = np.exp(-3) * np.cumprod(3.0 / k) / (1 - np.exp(-3))
    want = (share * 300 / (k + 1)).sum()
    second = (share * 2 * 300**2 / ((k + 1) * (k + 2))).sum()
    spread("first dark count", some, want, second - want**2)
    check(np.isnan(got["first"][:, 1]).all(), "no light")
    lam = -np.log(1 - p)
    for model, mean, variance in (("borel", 20 / (1 - lam), 20 * lam / (1 - lam)**3), ("geometric", 20 / (1 - p), 20 * p / (1 - p)**2)):
        draws(f", reading: {{crosstalk: {p}, model: {model}}}", n)
        with h5py.File("e.h5") as file:
            spread(model, file["cells"][:, 0], mean, variance)
            check((file["cells"][:, 1] == 0).all(), "no crosstalk of nothing")
    draws(f", reading: {{cells: {cells}}}", n)
    with h5py.File("e.h5") as file:
        q = 1 - 1 / cells
        mean = cells * (1 - q**20)
        spread("cells that fire", file["cells"][:, 0], mean, cells * q**20 + cells * (cells - 1) * (1 - 2 / cells)**20 - (cells * q**20)**2)
    draws(", reading: {window: 40 ns, afterpulse: {probability: 0.3, time: 25 ns}}", n)
    with h5py.File("e.h5") as file:
        in_time = 0.3 * (1 - np.exp(-(40 - 100 / 299.792458) / 25))
        spread("afterpulses", file["afterpulses"][:, 0], 20 * in_time, 20 * in_time * (1 - in_time))
        check(np.array_equal(file["cells"][:, 0], 20 + file["afterpulses"][:, 0]) and (file["cells"][:, 1] == 0).all(), "cells fire once more")
    draws(", response: 0.25, reading: {gain: 1}", n)
    with h5py.File("e.h5") as file:
        check(np.allclose(file["sum"][:, 0], 5), "the sum is what is expected,")
        spread("photo-electrons of a weight", file["photo_electrons"][:, 0], 5, 5)
    run("events", "s.raymap", "-o", "x.csv", "--force", ranks=3)
    run("events", "s.raymap", "-o", "y.csv", "--force")
    check(pathlib.Path("x.csv").read_bytes() == pathlib.Path("y.csv").read_bytes(), "draws do not depend on ranks")


def check_window():
    """Light after the window is not read."""
    ray_files.csv("rays.csv", "x (mm),y (mm),z (mm),dx,dy,dz,wavelength,time (ns),event", *place.T, *way.T, nm, time, event)
    run("trace", scene("w.yaml", right_more=", reading: {window: 10 ns}"), "-o", "w.raymap", "-n", ROWS, "--quiet", "--force")
    _, got = table("w.raymap")
    k, t = arrivals(True)
    check(np.array_equal(got["registrations"][:, 0], [((event[k] == n) & (t < 10)).sum() for n in np.unique(event)]), "within 10 ns")
    k, _ = arrivals(False)
    check(np.array_equal(got["registrations"][:, 1], [(event[k] == n).sum() for n in np.unique(event)]), "no window on the left")


def check_mistakes():
    for reading, said in (("{dark: 3 kHz}", "'dark' counts are those of a 'window'"), ("{dark: 3 ns, window: 1 ns}", "'dark' must be a rate"),
                          ("{crosstalk: 0.7}", "'crosstalk' must be between 0 and 0.6"), ("{cells: 0}", "'cells'"), ("{afterpulse: {time: 3 ns}}", "a probability and a mean delay"), ("{gian: 3}", "unknown key in a reading")):
        told = run("check", scene("x.yaml", right_more=f", reading: {reading}"), status=3)
        check(said in told, f"{reading}: {told}")
    pathlib.Path("u.yaml").write_text(pathlib.Path("a.yaml").read_text("utf-8").replace("time: on\n", ""), "utf-8")
    run("trace", "u.yaml", "-o", "u.raymap", "-n", 100, "--quiet", "--force")
    for words, said in ((("n.raymap",), "no source of this map numbers events"), (("u.raymap", "--window", "3 ns"), "--window wants times of arrival"),
                        (("u.raymap", "--at", "rihgt"), "right"), (("u.raymap", "--at", "left,left"), "twice")):
        told = run("events", *words, status=2 if "left,left" in words else 3)
        check(said in told, f"{words}: {told}")
    for words in (("--order", 65), ("--order", 0), ("--coincidence", 3), ("--window", "3 mm"), ("--memory", 10)):
        run("events", "u.raymap", *words, status=2)
    told = json.loads(run("events", "u.raymap", "--json"))
    check("difference" not in told and told["coincident"] > 0, f"without times: {told}")


check_number()
check_none()
check_goes_on()
check_readings()
check_chance()
check_sipm()
check_window()
check_mistakes()
asking.finish()
